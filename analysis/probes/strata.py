"""What the world of a probe tells its moments apart by, as columns."""

from __future__ import annotations

from pathlib import Path

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


def with_strata(moments: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Return a table of moments with a column for each thing that they were drawn evenly over, behind the moment.

    Args:
        moments: with the columns of `MomentKey`.
        file: the moments as they were drawn.

    Raises:
        RecordError: the file cannot be read.
    """
    try:
        found = msgspec.json.decode(file.read_bytes(), type=_Moments)
    except (OSError, *NOT_JSON) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    told = [
        dict(zip(_KEY, key, strict=True)) | strata for key, strata in zip(found.moments, found.strata, strict=False)
    ]
    names = list(dict.fromkeys(name for strata in found.strata for name in strata))
    if not names:
        return moments
    joined = moments.merge(pd.DataFrame(told), on=_KEY, how="left", validate="many_to_one")
    first = [*MomentKey._fields, *names]
    return joined[[*first, *(name for name in moments.columns if name not in first)]]
