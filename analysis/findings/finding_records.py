"""Writes and reads findings as `findings.json`, a list with one object per finding."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import pandas as pd

from analysis.findings.moments import Moment

FILE = "findings.json"
STANDS, DESCRIBES = "stands", "describes these runs"
"""The values of `standing`: STANDS for a significant difference that was declared, else DESCRIBES."""


class FindingRecord(msgspec.Struct, frozen=True, kw_only=True):
    """A finding with its numbers; JSON `null` stands for a number that is undefined.

    Attributes:
        sentence: the finding in words.
        measure: name of the measure, such as `exploration.coverage`.
        label: title of the measure.
        factor: the setting that differs, such as `model`.
        level: the value of the factor that is the subject of the sentence.
        reference: the other value of the factor whose mean is nearest; the numbers compare these two.
        others: all values with which the sentence compares `level`, in the order of their first runs.
        context: other swept settings, equal in both, such as `world=bar`; "" if there are none.
        value: mean of the level over seeds.
        reference_value: mean of the reference.
        difference: mean of the paired differences, level minus reference.
        low: lower end of the difference's 95 % interval.
        high: upper end.
        p: corrected p, the largest over all `others`.
        family: number of tests in the correction.
        claim: `declared` or `exploratory`.
        standing: STANDS or DESCRIBES.
        seeds: number of pairs of seeds, the smallest over all `others`.
        note: limitations, such as missing runs, or "".
        moments: example moments, earliest first.
        no_moments: the reason why there is no moment, or "".
    """

    sentence: str
    measure: str
    label: str
    factor: str
    level: str
    reference: str
    others: tuple[str, ...]
    context: str
    value: float | None
    reference_value: float | None
    difference: float | None
    low: float | None
    high: float | None
    p: float | None
    family: int
    claim: str
    standing: str
    seeds: int
    note: str
    moments: tuple[Moment, ...]
    no_moments: str

    @property
    def stands(self) -> bool:
        """True for a significant declared difference."""
        return self.standing == STANDS


def write_findings(folder: Path, records: Sequence[FindingRecord]) -> Path:
    """Write `findings.json` and return its path."""
    path = folder / FILE
    path.write_bytes(msgspec.json.format(msgspec.json.encode(list(records)), indent=1) + b"\n")
    return path


def findings_frame(content: bytes) -> pd.DataFrame:
    """Return the findings of `findings.json` as a table, one row per finding; `moments` holds lists of mappings.

    Raises:
        msgspec.MsgspecError: the content is not a list of findings.
    """
    records = msgspec.json.decode(content, type=list[FindingRecord])
    frame = pd.DataFrame(
        [msgspec.structs.asdict(record) for record in records], columns=list(FindingRecord.__struct_fields__)
    )
    moments = pd.Series([[msgspec.structs.asdict(moment) for moment in record.moments] for record in records])
    frame = frame.assign(moments=moments)
    return frame.astype(dict.fromkeys(("value", "reference_value", "difference", "low", "high", "p"), float))
