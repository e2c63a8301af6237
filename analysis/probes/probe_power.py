"""Computes from a pilot probe how many seeds a probe needs."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.filtering import Filter
from analysis.probes.choices import read_answers
from analysis.probes.comparing import compared_edits, compared_pairs
from analysis.probes.differences import named
from analysis.probes.narrowing import narrowed, strata_of
from analysis.probes.probe_declaring import Family
from analysis.stats.contrasts import ALPHA
from analysis.stats.power import COLUMNS, check_wanted, seeds_needed
from foundry.storing.store import SweepFolder


def probe_power(
    folder: SweepFolder, names: Sequence[str], chosen: Filter, *, difference: float | None = None, target: float = 0.8
) -> pd.DataFrame:
    """Return how many seeds each comparison of a probe needs, in a table like that of `analysis.stats.power.power`.

    The one-sided tests at the level ALPHA are planned as two-sided tests at the level 2 ALPHA, with the same power.

    Args:
        folder: the pilot probe.
        names: models and edits to declare; by default all.
        chosen: filter that selects answers.
        difference: excess to detect, 0..1; by default that of the pilot.
        target: desired power, 0..1.

    Raises:
        InputError: a number is out of range, or a name is not a model or edit.
        RecordError: a recorded file is damaged.
    """
    check_wanted(difference, target)
    answers = narrowed(read_answers(folder.runs()), strata_of(folder.moments_file), chosen)
    family = Family.of(names, answers)
    blocks = [
        named(about) | {"differences": compared.excesses()}
        for about, compared in (*compared_pairs(answers), *compared_edits(answers))
        if family.holds(about)
    ]
    if not blocks:
        return pd.DataFrame(columns=list(COLUMNS))
    frame = pd.DataFrame(blocks).assign(declared=True)
    excesses = frame["differences"]
    frame["n_pairs"] = excesses.map(len)
    frame["observed"] = excesses.map(lambda own: own.mean() if len(own) else np.nan)
    frame["sd"] = excesses.map(lambda own: own.std(ddof=1) if len(own) > 1 else np.nan)
    tested = frame["sd"] > 0
    tests = tested.groupby(frame["factor"]).transform("sum") if not family.is_given else tested.sum()
    frame = frame.assign(family=tests, pairs=tests)
    frame[["family", "pairs"]] = frame[["family", "pairs"]].clip(lower=1)
    return seeds_needed(frame, frame["observed"].clip(lower=0) if difference is None else difference, target, 2 * ALPHA)
