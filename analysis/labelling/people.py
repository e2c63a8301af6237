"""How far people who labelled texts of a sweep agree with the rule, a model, the records and each other."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.agreement import cohen_kappa
from analysis.arrays import IntArray
from analysis.labelling.warning_rule import RULE_VERSION, is_warning
from analysis.stats.intervals import student_quantile
from analysis.tables.table import Table
from analysis.tables.texts import number, remove_table, with_interval, write_table
from foundry.labels import REPLIES, WARNINGS, Judged
from foundry.storing.store import SweepFolder

NAME = "labellers"
_SAID = {True: "yes", False: "no"}
_COLUMNS = ["what", "first", "second", "texts", "seeds", "same", "kappa", "low", "high", "note"]
_READER = "the records"


@dataclass(frozen=True)
class Kappa:
    """Cohen's kappa with its interval.

    Attributes:
        kappa: -1..1, or NaN.
        low: lower end of the interval; NaN where there is none.
        high: upper end.
        note: why there is no interval; "" where there is one.
    """

    kappa: float
    low: float = math.nan
    high: float = math.nan
    note: str = ""


@dataclass(frozen=True)
class Agreed:
    """How far two labellers agree.

    Attributes:
        what: `warnings` or `replies`.
        first: a person.
        second: another, the rule, a model, or the records.
        texts: distinct texts that both labelled.
        seeds: of the runs in which they appeared first.
        same: share of equal labels, 0..1.
        kappa: Cohen's, with its interval over seeds.
    """

    what: str
    first: str
    second: str
    texts: int
    seeds: int
    same: float
    kappa: Kappa


Key = tuple[str, str, tuple[str, ...]]
Labels = Mapping[Key, str]


def labellers(sweep: SweepFolder) -> pd.DataFrame:
    """Return the agreement of each person with all others who labelled the same; empty where nobody did.

    Returns:
        One row a pair: what, first, second, texts, seeds, same, kappa, low, high, note.

    Raises:
        RecordError: the labels cannot be read.
    """
    rows = [{**asdict(one), **asdict(one.kappa)} for one in _agreed(sweep)]
    return pd.DataFrame(rows, columns=_COLUMNS)


def labellers_table(frame: pd.DataFrame) -> Table:
    """Return the same as texts."""
    rows = [
        (row["what"], row["first"], row["second"], str(row["texts"]), str(row["seeds"]), number(row["same"]),
         with_interval(row["kappa"], row["low"], row["high"]) + (f" ({row['note']})" if row["note"] else ""))
        for row in frame.to_dict("records")
    ]  # fmt: skip
    caption = "Texts that both labelled, the share of equal labels, Cohen's kappa with its 95 % interval over seeds."
    if (frame["what"] == REPLIES).any():
        caption += " Half of the replies are ones that could not be read: their figures hold for such a mix alone."
    return Table(NAME, caption, ("what", "first", "second", "texts", "seeds", "same", "kappa"), tuple(rows), labels=3)


def write_labellers(sweep: SweepFolder) -> list[Path]:
    """Write the table, or remove it where nobody labelled anything; returns the files."""
    frame = labellers(sweep)
    if len(frame):
        return write_table(sweep.analysis_dir, labellers_table(frame), frame)
    remove_table(sweep.analysis_dir / NAME)
    return []


def _agreed(sweep: SweepFolder) -> Iterator[Agreed]:
    kept = sweep.people().people
    for what in (REPLIES, WARNINGS):
        people = {one.labeller: one for one in kept if one.what == what}
        seeds = {_key(one): one.seed for person in people.values() for one in person.labels}
        said = {name: {_key(one): one.label for one in person.labels} for name, person in people.items()}
        others = _others(sweep, what, [one for person in people.values() for one in person.labels])
        pairs = [*itertools.product(said, others), *itertools.combinations(said, 2)]
        for first, second in sorted(pairs):
            yield _pair(what, (first, said[first]), (second, {**others, **said}[second]), seeds)


def _others(sweep: SweepFolder, what: str, labels: Sequence[Judged]) -> dict[str, Labels]:
    """Return what labellers that are no people say of the same texts."""
    if what != WARNINGS:
        return {_READER: {_key(one): one.recorded for one in labels}}
    ruled = {_key(one): is_warning(one.text, one.fires) for one in labels}
    by_rule = {key: _SAID[one] for key, one in ruled.items() if one is not None}
    found: dict[str, Labels] = {f"rule {RULE_VERSION}": by_rule}
    kept = sweep.labels()
    if kept is not None:
        found[kept.labeller] = {
            ("", one.text, one.fires): _SAID[one.warning] for one in kept.labels if one.warning is not None
        }
    return found


def _key(one: Judged) -> Key:
    return one.kind, one.text, one.fires


def _pair(what: str, first: tuple[str, Labels], second: tuple[str, Labels], seeds: Mapping[Key, int]) -> Agreed:
    both = [key for key in first[1] if key in second[1]]
    names = sorted({labels[key] for labels in (first[1], second[1]) for key in both})
    one, other = (
        np.array([names.index(labels[key]) for key in both], dtype=np.int64) for labels in (first[1], second[1])
    )
    cluster = np.array([seeds[key] for key in both], dtype=np.int64)
    same = float((one == other).mean()) if both else math.nan
    kappa = clustered_kappa(one, other, cluster)
    return Agreed(what, first[0], second[0], len(both), len(np.unique(cluster)), same, kappa)


def clustered_kappa(first: IntArray, second: IntArray, cluster: IntArray) -> Kappa:
    """Return Cohen's kappa of two rows of choices (n,) with a 95 % interval over clusters.

    The interval is that of the delete-one-cluster jackknife with Student's quantile (Tukey 1958), cut to -1..1: choices
    of one cluster are alike, so it is clusters that count.

    Args:
        first: choices, indices from 0.
        second: those of another.
        cluster: the cluster that each is of.
    """
    kappa = cohen_kappa(first, second) if len(first) else math.nan
    clusters = np.unique(cluster)
    if len(clusters) < 2:
        return Kappa(kappa, note="no interval: one seed" if len(clusters) else "nothing in common")
    left_out = np.array([cohen_kappa(first[cluster != one], second[cluster != one]) for one in clusters])
    if not np.isfinite(left_out).all() or math.isnan(kappa) or not np.ptp(left_out):
        return Kappa(kappa, note="no interval: the same without any seed")
    count = len(clusters)
    error = math.sqrt((count - 1) / count * float(((left_out - left_out.mean()) ** 2).sum()))
    half = student_quantile(count - 1) * error
    return Kappa(kappa, max(-1.0, kappa - half), min(1.0, kappa + half))
