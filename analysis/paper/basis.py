"""The data from which methods and references are written."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from analysis.figures.members import Member
from analysis.form import FormAnalysis
from analysis.labelling import Labelling
from analysis.planned.holding import Held
from analysis.stats.fingerprint import Fingerprint


@dataclass(frozen=True)
class Basis:
    """An analysis and its runs.

    Attributes:
        contrasts: one row per measure and pair of groups.
        filtered: the filter of the runs; "" for all runs.
    """

    members: Sequence[Member]
    forms: Sequence[FormAnalysis]
    labelled_by: Sequence[Labelling]
    comparison: pd.DataFrame
    contrasts: pd.DataFrame
    fingerprint: Fingerprint
    planned: Held | None = None
    filtered: str = ""
