"""Computes how well labellers agree: the people, models and rules that labelled texts of a sweep."""

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.agreement import cohen_kappa, krippendorff_alpha
from analysis.arrays import BoolArray, IntArray
from analysis.stats.intervals import student_quantile
from analysis.tables.table import Table
from analysis.tables.texts import number, remove_table, with_interval, write_table
from foundry.labels.definition import UNCLEAR, Label, label_files, label_named
from foundry.labels.folder import LabelFolder, Labels, label_names
from foundry.labels.items import content_of
from foundry.labels.sampling import SampledText
from foundry.storing.store import SweepFolder, ensure_writable

NAME = "labellers"
_COLUMNS = ["label", "first", "second", "texts", "seeds", "same", "kappa", "low", "high", "note"]
RULE = "the rule"
LabelsByItem = Mapping[str, str]


@dataclass(frozen=True)
class Kappa:
    """How well labellers agree beyond chance, with an interval.

    Attributes:
        kappa: Cohen's kappa of two labellers or Krippendorff's alpha of several, -1..1, or NaN.
        low: lower end of the interval; NaN if undefined.
        note: the reason why there is no interval, or "".
    """

    kappa: float
    low: float = math.nan
    high: float = math.nan
    note: str = ""


def labellers(sweep: SweepFolder) -> pd.DataFrame:
    """Return, for each person and every other labeller, how well their labels of the same texts agree.

    There is one row per pair of labellers, and a further row for all people and models together if there are more than
    two.

    - first, second: the labellers; in the row of all, their number and "".
    - texts: number of texts that both labelled; in the row of all, that at least two labelled.
    - same: share of equal pairs of labels, 0..1.
    - kappa: agreement beyond chance; low, high: its interval over seeds; note: the reason why there is no interval.

    Raises:
        RecordError: the labels cannot be read.
    """
    labels = (label_named(name) for name in label_names(sweep) if name in label_files())
    return pd.DataFrame([row for label in labels for row in _agreed(sweep, label)], columns=_COLUMNS)


def labellers_table(frame: pd.DataFrame) -> Table:
    """Return the agreement of labellers as a readable table."""
    rows = [
        (row["label"], row["first"], row["second"], str(row["texts"]), str(row["seeds"]), number(row["same"]),
         with_interval(row["kappa"], row["low"], row["high"]) + (f" ({row['note']})" if row["note"] else ""))
        for row in frame.to_dict("records")
    ]  # fmt: skip
    caption = (
        "Agreement of labellers: the number of texts that both labelled, the share of equal labels, and Cohen's kappa "
        "with its 95 % interval over seeds. For several labellers together, kappa is Krippendorff's alpha."
    )
    return Table(NAME, caption, ("label", "first", "second", "texts", "seeds", "same", "kappa"), tuple(rows), labels=3)


def write_labellers(sweep: SweepFolder) -> list[Path]:
    """Write the table and return its files; if nobody labelled texts, remove the table."""
    frame = labellers(sweep)
    if len(frame):
        ensure_writable(sweep.analysis_dir)
        return write_table(sweep.analysis_dir, labellers_table(frame), frame)
    remove_table(sweep.analysis_dir / NAME)
    return []


def _agreed(sweep: SweepFolder, label: Label) -> Iterator[dict[str, Any]]:
    stored_labels = Labels.of(sweep, label)
    if stored_labels is None:
        return
    drawn = {text.item: text for text in stored_labels.sample.drawn}
    people = {name: _clear(labels, drawn) for name, labels in stored_labels.by_person.items()}
    judges = {
        judge.labeller: {content_of(text.text, text.context): text.label for text in judge.judgements}
        for judge in LabelFolder.of(sweep, label.name).judges()
    }
    models = {
        name: {item: said for item, text in drawn.items() if (said := labels.get(content_of(text.text, text.context)))}
        for name, labels in judges.items()
    }
    rule = label.rule_function()
    ruled = {item: rule(text.text, text.context) for item, text in drawn.items()} if rule else {}
    others = {**models, **({RULE: {item: said for item, said in ruled.items() if said is not None}} if rule else {})}
    every = {**others, **people}
    for first, second in sorted([*itertools.product(people, others), *itertools.combinations(people, 2)]):
        yield _pair(label, first, second, every, drawn)
    if people and len(people) + len(models) > 2:
        yield _together(label, {**people, **models}, drawn)


def _clear(labels: LabelsByItem, drawn: Mapping[str, SampledText]) -> dict[str, str]:
    return {item: said for item, said in labels.items() if said != UNCLEAR and item in drawn}


def _pair(
    label: Label, first: str, second: str, labels: Mapping[str, LabelsByItem], drawn: Mapping[str, SampledText]
) -> dict[str, Any]:
    both = [item for item in labels[first] if item in labels[second]]
    names = sorted({labels[name][item] for name in (first, second) for item in both})
    labels_of_first, labels_of_second = (
        np.array([names.index(labels[name][item]) for item in both], dtype=np.int64) for name in (first, second)
    )
    seeds = np.array([drawn[item].seed for item in both], dtype=np.int64)
    same = float((labels_of_first == labels_of_second).mean()) if both else math.nan
    return _row(label, first, second, seeds, same, clustered_kappa(labels_of_first, labels_of_second, seeds))


def _together(label: Label, labels: Mapping[str, LabelsByItem], drawn: Mapping[str, SampledText]) -> dict[str, Any]:
    by_item = {item: Counter(own[item] for own in labels.values() if item in own) for item in drawn}
    several = {item: counts for item, counts in by_item.items() if counts.total() > 1}
    names = sorted({name for counts in several.values() for name in counts})
    counts = np.array([[counts_of_text[name] for name in names] for counts_of_text in several.values()], dtype=np.int64)
    seeds = np.array([drawn[item].seed for item in several], dtype=np.int64)
    made = counts.sum(axis=1)
    same = float(((counts * (counts - 1)).sum(axis=1) / (made * (made - 1))).mean()) if several else math.nan
    alpha = _clustered(lambda used: krippendorff_alpha(counts[used]), seeds)
    return _row(label, f"all {len(labels)} people and models", "", seeds, same, alpha)


def _row(label: Label, first: str, second: str, seeds: IntArray, same: float, kappa: Kappa) -> dict[str, Any]:
    counts = {"texts": len(seeds), "seeds": len(np.unique(seeds))}
    return {"label": label.name, "first": first, "second": second, **counts, "same": same, **asdict(kappa)}


def clustered_kappa(first: IntArray, second: IntArray, cluster: IntArray) -> Kappa:
    """Return Cohen's kappa of two labellers' choices (n,), with a 95 % interval over clusters of texts (n,)."""
    return _clustered(lambda used: cohen_kappa(first[used], second[used]), cluster)


def _clustered(statistic: Callable[[BoolArray], float], cluster: IntArray) -> Kappa:
    """Return a statistic of n texts with a 95 % interval; the units are clusters of texts (the texts of one seed).

    The interval is a delete-one-cluster jackknife with Student's quantile (Tukey 1958), cut to -1..1. Choices within a
    cluster are dependent, so clusters are the units.
    """
    value = statistic(np.ones(len(cluster), dtype=np.bool_)) if len(cluster) else math.nan
    clusters = np.unique(cluster)
    if len(clusters) < 2:
        return Kappa(value, note="no interval: one seed" if len(clusters) else "no common texts")
    left_out = np.array([statistic(cluster != left) for left in clusters])
    if not np.isfinite(left_out).all() or math.isnan(value) or not np.ptp(left_out):
        return Kappa(value, note="no interval: the same without any seed")
    count = len(clusters)
    error = math.sqrt((count - 1) / count * float(((left_out - left_out.mean()) ** 2).sum()))
    half = student_quantile(count - 1) * error
    return Kappa(value, max(-1.0, value - half), min(1.0, value + half))
