"""The tables of a probe: choices by moment, pairs of models, edits."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from analysis.probes.choices import Answers, MomentKey, Subject, read_answers
from analysis.probes.comparing import ALL, Compared, corrected
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.tables.texts import Table, number, p_value, with_interval, write_table
from foundry.storing.store import SweepFolder, ensure_writable

NONE = "none"
"""The edit that changes nothing."""
FORM = "probe"
MOST_SHOWN = 20
"""Moments that the short table shows: those in which the models are furthest apart."""
_MOMENT = MomentKey._fields


@dataclass(frozen=True)
class ProbeAnalysis:
    """What was found in a probe, and where it was written.

    Attributes:
        path: the folder of tables.
        moments: one row per moment, subject, edit and choice.
        agreement: one row per pair of subjects and kind of question.
        edits: one row per subject, edit and kind of question.
        tables: the short tables of agreement and edits.
        notes: what a reader must know, one line each.
        written: the files.
    """

    path: Path
    moments: pd.DataFrame
    agreement: pd.DataFrame
    edits: pd.DataFrame
    tables: tuple[Table, ...]
    notes: tuple[str, ...]
    written: tuple[Path, ...]


def is_probe(folder: SweepFolder) -> bool:
    """Return whether a sweep is a probe."""
    return {run.declared.form for run in folder.runs()} == {FORM}


def analyze_probe(folder: SweepFolder) -> ProbeAnalysis:
    """Compare who was asked in the moments of a probe, and write the tables into its folder.

    Raises:
        RecordError: a recorded file is damaged.
    """
    answers = read_answers(folder.runs())
    pairs = _pairs(answers)
    agreement = _agreement(pairs)
    edits = _edits(answers)
    moments = _moments(answers)
    tables = (_agreement_table(agreement), _edits_table(edits))
    ensure_writable(folder.analysis_dir)
    written = [
        *write_table(folder.analysis_dir, _moments_table(answers, pairs), moments),
        *write_table(folder.analysis_dir, tables[0], agreement),
        *write_table(folder.analysis_dir, tables[1], edits),
    ]
    shown = tuple(table for table in tables if table.rows)
    return ProbeAnalysis(folder.analysis_dir, moments, agreement, edits, shown, tuple(_notes(answers)), tuple(written))


def _pairs(answers: Answers) -> dict[tuple[str, str], Compared]:
    """Compare every two subjects where nothing is edited."""
    found = {}
    for first, second in itertools.combinations(answers.names, 2):
        names = answers.names[first], answers.names[second]
        found[names] = Compared.of(answers.of(first, NONE), answers.of(second, NONE), " and ".join(names))
    return found


def _agreement(pairs: dict[tuple[str, str], Compared]) -> pd.DataFrame:
    rows = [{"first": pair[0], "second": pair[1]} | row for pair, found in pairs.items() for row in found.rows()]
    return corrected(rows, ("first", "second"))


def _edits(answers: Answers) -> pd.DataFrame:
    edited = [change for name, change in answers.changes.items() if name != NONE]
    rows = []
    for subject, change in itertools.product(answers.names, edited):
        before, after = answers.of(subject, NONE), answers.of(subject, change.name)
        expected = {key: change.carried(counts) for key, counts in before.items()}
        about = {"model": answers.names[subject], "edit": change.name, "leaves": change.leaves, "asked": len(before)}
        found = Compared.of(expected, after, f"{answers.names[subject]} {change.name}")
        rows += [about | row for row in found.rows()]
    return corrected(rows, ("model", "edit", "leaves", "asked"))


def _moments(answers: Answers) -> pd.DataFrame:
    rows = [
        (*key, answers.names[subject], edit, choice, count, count / counts.total())
        for (subject, edit), chosen in answers.chosen.items()
        for key, counts in sorted(chosen.items())
        for choice, count in sorted(counts.items())
    ]
    return pd.DataFrame(rows, columns=[*_MOMENT, "model", "edit", "choice", "count", "share"])


def _moments_table(answers: Answers, pairs: dict[tuple[str, str], Compared]) -> Table:
    """Return what each chose most often in the moments in which they are furthest apart."""
    mean: dict[MomentKey, float] = {}
    for found in pairs.values():
        for key, one in found.moments.items():
            mean[key] = mean.get(key, 0.0) + one.distance / len(pairs)
    furthest = sorted(mean, key=lambda key: (-mean[key], key))[:MOST_SHOWN]
    rows = [
        (key.run, str(key.step), str(key.agent), key.kind, number(mean[key]),
         *(_most(answers, subject, key) for subject in answers.names))
        for key in furthest
    ]  # fmt: skip
    caption = (
        f"The {MOST_SHOWN} moments in which the models are furthest apart: what each chose most often, and how often."
    )
    columns = ("run", "step", "agent", "kind", "distance", *answers.names.values())
    return Table("moments", caption, columns, tuple(rows), labels=4)


def _most(answers: Answers, subject: Subject, key: MomentKey) -> str:
    counts = answers.of(subject, NONE).get(key)
    if counts is None:
        return ""
    choice, count = min(counts.items(), key=lambda one: (-one[1], one[0]))
    return f"{choice} {count}/{counts.total()}"


_FIGURES = ("moments", "distance", "floor", "excess", "p (Holm)", "stand out")


def _figures(row: pd.Series) -> tuple[str, ...]:
    return (
        str(row["moments"]),
        number(row["distance"]),
        number(row["floor"]),
        with_interval(row["excess"], row["excess_low"], row["excess_high"]),
        p_value(row["p_holm"]),
        number(row["standing_out"]),
    )


def _agreement_table(frame: pd.DataFrame) -> Table:
    rows = [(row["first"], row["second"], *_figures(row)) for _, row in frame[frame["kind"] == ALL].iterrows()]
    caption = (
        "Total variation between what two models chose in the same moments; the floor is what one chance would give; "
        "excess with its 95 % interval over seeds."
    )
    return Table("agreement", caption, ("first", "second", *_FIGURES), tuple(rows), labels=2)


def _edits_table(frame: pd.DataFrame) -> Table:
    rows = [
        (row["model"], row["edit"], row["leaves"], str(row["asked"]), *_figures(row))
        for _, row in frame[frame["kind"] == ALL].iterrows()
    ]
    caption = (
        "Total variation between what a model chose in a moment and in the edited one, over the moments in which the "
        "edit changes something; for an equivariance, from what should have been chosen there."
    )
    return Table("edits", caption, ("model", "edit", "leaves", "asked", *_FIGURES), tuple(rows), labels=3)


def _notes(answers: Answers) -> Sequence[str]:
    chosen = [counts for mine in answers.chosen.values() for counts in mine.values()]
    seeds = {key.seed for mine in answers.chosen.values() for key in mine}
    notes = []
    if answers.missing:
        notes.append(f"{answers.missing} runs are not complete, and their moments are missing")
    if chosen and max(counts.total() for counts in chosen) == 1:
        notes.append("each moment was asked once, so no difference can stand above its floor: ask with repeats=10")
    if len(seeds) < FEWEST_FOR_CLAIMS:
        notes.append(f"fewer than {FEWEST_FOR_CLAIMS} seeds: the numbers describe these runs, and prove nothing")
    return notes
