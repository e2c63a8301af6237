"""What the world of a probe tells its moments apart by, as columns."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

import msgspec
import pandas as pd

from analysis.probes.choices import MomentKey
from foundry.errors import RecordError
from foundry.records import NOT_JSON

_KEY = [name for name in MomentKey._fields if name != "seed"]


class _Moments(msgspec.Struct):
    """What is read of `moments.json`: run, step, agent, kind and again of each moment, and its strata."""

    moments: list[tuple[str, int, int, str, int]]
    strata: list[dict[str, str | bool]] = []


Strata: TypeAlias = Mapping[tuple[str, int, int, str, int], Mapping[str, str | bool]]
"""The strata of each moment, by run, step, agent, kind and again."""


def strata_of(file: Path) -> Strata:
    """Return the strata of the moments of a probe.

    Args:
        file: the moments as they were drawn.

    Raises:
        RecordError: the file cannot be read.
    """
    try:
        drawn = msgspec.json.decode(file.read_bytes(), type=_Moments)
    except (OSError, *NOT_JSON) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    return dict(zip(drawn.moments, drawn.strata, strict=False))


def with_strata(moments: pd.DataFrame, strata: Strata) -> pd.DataFrame:
    """Return a table of moments with a column for each thing that they were drawn evenly over, behind the moment.

    Args:
        moments: with the columns of `MomentKey`.
        strata: of each moment.
    """
    names = list(dict.fromkeys(name for values in strata.values() for name in values))
    if not names:
        return moments
    columns = pd.DataFrame([{**dict(zip(_KEY, key, strict=True)), **values} for key, values in strata.items()])
    joined = moments.merge(columns, on=_KEY, how="left", validate="many_to_one")
    first = [*MomentKey._fields, *names]
    return joined[[*first, *(name for name in moments.columns if name not in first)]]
