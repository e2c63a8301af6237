"""The tables of a probe: choices by moment, pairs of models, edits, formats."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from analysis.filtering import Filter
from analysis.paper.ending import ending_of_sentences
from analysis.plots import draw, write
from analysis.probes.agreement_matrix import matrix_of, matrix_table
from analysis.probes.changed import changes_of, changes_table
from analysis.probes.choices import Answers, MomentKey, Subject, read_answers
from analysis.probes.comparing import ALL, Compared, framed
from analysis.probes.curves import curve_tables, curves_table, steepness_table
from analysis.probes.formats import format_tables, formats_table, orders_table
from analysis.probes.narrowing import counted_answers, narrowed
from analysis.probes.planned import held_probe
from analysis.probes.probe_declaring import Family
from analysis.probes.probe_pictures import pictures_of
from analysis.probes.probe_summary import summary_of
from analysis.probes.strata import strata_of, with_strata
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.tables.table import Table
from analysis.tables.texts import alike, p_value, told_rows, write_summary, write_table
from foundry.storing.store import SweepFolder, ensure_writable
from foundry.texts import counted

MOST_SHOWN = 20
"""Moments that the short table shows: those in which the models are furthest apart."""
_MOMENT = MomentKey._fields


class Gap(NamedTuple):
    """How far models are apart in a moment, mean over their pairs, and how far one chance would put them."""

    distance: float
    floor: float

    @property
    def excess(self) -> float:
        """What no chance explains, in the mean."""
        return self.distance - self.floor


@dataclass(frozen=True)
class ProbeAnalysis:
    """What was found in a probe, and where it was written.

    Attributes:
        path: the folder of tables.
        frames: the tables as they are written, by name.
        tables: the short tables with anything in them, but those of moments and curves.
        summary: what was found, a sentence each.
        notes: what a reader must know, one line each.
        furthest: the 20 moments in which the models are furthest apart above chance, and how far.
        written: the files.
    """

    path: Path
    frames: Mapping[str, pd.DataFrame]
    tables: tuple[Table, ...]
    summary: tuple[str, ...]
    notes: tuple[str, ...]
    furthest: Mapping[MomentKey, Gap]
    written: tuple[Path, ...]

    def ending(self, folder: Path, width: int, printed: int = 0) -> list[str]:
        """Return the lines with which the analysis ends on a terminal; see `analysis.paper.ending`.

        Args:
            folder: the probe, as the user names it.
            width: columns of the terminal.
            printed: lines that stand above it.
        """
        moments = self.frames["moments"]
        parts = [
            counted(moments["model"].nunique(), "model"),
            f"{counted(len(moments[list(_MOMENT)].drop_duplicates()), 'moment')} of "
            f"{counted(moments['seed'].nunique(), 'seed')}",
            *(f"{counted(found, what)}" for what in ("edit", "format") if (found := moments[what].nunique() - 1) > 0),
        ]
        study = f"{', '.join(parts)}: {counted(int(moments['count'].sum()), 'answer')}"
        return ending_of_sentences(
            study, self.summary, self.notes, str(folder), str(self.path), width=width, printed=printed
        )


def analyze_probe(
    folder: SweepFolder,
    family: Sequence[str] = (),
    *,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    plots: bool = True,
) -> ProbeAnalysis:
    """Compare who was asked in the moments of a probe, and write the tables into its folder.

    Args:
        folder: the probe.
        family: the models and edits that were declared beforehand; nothing: all.
        only: answers that are taken, as KEY=VALUE[,VALUE...], such as `edit=no_fire`; see `narrowing.narrowed`.
        without: answers that are left out, in the same way.
        plots: whether to draw the plots.

    Raises:
        InputError: what is declared or filtered is not in the probe, no answer is left, or a plan was made before the
            probe and a family is given.
        RecordError: a recorded file is damaged.
    """
    every, strata, chosen = read_answers(folder.runs()), strata_of(folder.moments_file), Filter.of(only, without)
    answers = narrowed(every, strata, chosen)
    taken, of = counted_answers(answers), counted_answers(every)
    filtered = f"{chosen}: {taken:,} of {of:,} answers" if chosen else ""
    plan = held_probe(folder, family)
    declared = Family.of(plan.names or family, answers)
    pairs = _pairs(answers)
    agreement, edits = _agreement(pairs), _edits(answers)
    moments = with_strata(_moments(answers), strata)
    declared.correct(agreement, edits)
    matrix, changes = matrix_of(answers), changes_of(answers, declared)
    spread, orders = format_tables(answers, declared)
    curves, steepness = curve_tables(answers, declared)
    furthest = _furthest(pairs)
    found = (
        (_moments_table(answers, furthest), moments),
        (_agreement_table(agreement), agreement),
        (matrix_table(matrix, agreement), matrix),
        (_edits_table(edits), edits),
        (changes_table(changes), changes),
        (formats_table(spread), spread),
        (orders_table(orders), orders),
        (curves_table(curves), curves),
        (steepness_table(steepness), steepness),
    )
    ensure_writable(folder.analysis_dir)
    chosen.write(folder.analysis_dir, taken, of, "answers")
    written = tuple(file for table, frame in found for file in write_table(folder.analysis_dir, table, frame, filtered))
    frames = {table.name: frame for table, frame in found}
    pictures = pictures_of(frames) if plots else ()
    drawn = tuple(file for picture in pictures for file in write(draw(picture), folder.analysis_dir / "plots"))
    shown = tuple(table for table, _ in found if table.rows and table.name not in ("moments", "curves"))
    part = [f"a part of the answers alone, {filtered}"] if filtered else []
    late = ["the family was named with the analysis"] if family else []
    notes = (*part, *plan.notes, *late, *declared.note(agreement, edits), *_notes(answers))
    summary = summary_of(frames, declared, filtered, planned=bool(plan.names), known=plan.known)
    written = (*written, *drawn, write_summary(folder.analysis_dir, summary, notes))
    return ProbeAnalysis(folder.analysis_dir, frames, shown, summary, notes, furthest, written)


def _pairs(answers: Answers) -> dict[tuple[str, str], Compared]:
    """Compare every two subjects where nothing is edited."""
    found = {}
    for first, second in itertools.combinations(answers.names, 2):
        names = answers.names[first], answers.names[second]
        found[names] = Compared.of(answers.of(first), answers.of(second), " and ".join(names))
    return found


def _agreement(pairs: dict[tuple[str, str], Compared]) -> pd.DataFrame:
    rows = [{"first": pair[0], "second": pair[1]} | row for pair, found in pairs.items() for row in found.rows()]
    return framed(rows, ("first", "second"))


def _edits(answers: Answers) -> pd.DataFrame:
    rows = []
    for subject, change in answers.edited():
        expected, after = answers.expected(subject, change), answers.of(subject, change.name)
        about = {"model": answers.names[subject], "edit": change.name, "leaves": change.leaves, "asked": len(expected)}
        found = Compared.of(expected, after, f"{answers.names[subject]} {change.name}")
        rows += [about | row for row in found.rows()]
    return framed(rows, ("model", "edit", "leaves", "asked"))


def _moments(answers: Answers) -> pd.DataFrame:
    rows = [
        (*key, answers.names[asked.subject], asked.edit, asked.format, choice, count, count / counts.total())
        for asked, chosen in answers.chosen.items()
        for key, counts in sorted(chosen.items())
        for choice, count in sorted(counts.items())
    ]
    return pd.DataFrame(rows, columns=[*_MOMENT, "model", "edit", "format", "choice", "count", "share"])


def _furthest(pairs: Mapping[tuple[str, str], Compared]) -> dict[MomentKey, Gap]:
    """Return the moments in which models are furthest apart above chance, with the means over their pairs."""
    gaps: dict[MomentKey, Gap] = {}
    for compared in pairs.values():
        for key, apart in compared.moments.items():
            before = gaps.get(key, Gap(0.0, 0.0))
            distance, floor = before.distance + apart.distance / len(pairs), before.floor + apart.floor / len(pairs)
            gaps[key] = Gap(distance, floor)
    order = sorted(gaps, key=lambda key: (-gaps[key].excess, -gaps[key].distance, key))
    return {key: gaps[key] for key in order[:MOST_SHOWN]}


def _moments_table(answers: Answers, furthest: Mapping[MomentKey, Gap]) -> Table:
    """Return what each chose most often in the moments in which they are furthest apart."""
    rows = [
        (key.run, str(key.step), str(key.agent), key.kind, distance, excess,
         *(_most(answers, subject, key) for subject in answers.names))
        for key, distance, excess in zip(
            furthest,
            alike([gap.distance for gap in furthest.values()]),
            alike([gap.excess for gap in furthest.values()]),
            strict=True,
        )
    ]  # fmt: skip
    caption = (
        f"The {MOST_SHOWN} moments in which the models are furthest apart above chance: what each chose most often, "
        "and how often; distance as counted, excess less what one chance would give."
    )
    columns = ("run", "step", "agent", "kind", "distance", "excess", *answers.names.values())
    return Table("moments", caption, columns, tuple(rows), labels=4)


def _most(answers: Answers, subject: Subject, key: MomentKey) -> str:
    counts = answers.of(subject).get(key)
    if counts is None:
        return ""
    choice, count = min(counts.items(), key=lambda one: (-one[1], one[0]))
    return f"{choice} {count}/{counts.total()}"


_FIGURES = ("moments", "distance", "floor", "excess", "p (Holm)", "stand out")


def _told(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Return the rows over all kinds of question as texts."""
    numbers = ("distance", "floor", "standing_out")
    return told_rows(frame[frame["kind"] == ALL], numbers, {"excess": ("excess_low", "excess_high")})


def _figures(row: Mapping[Any, Any]) -> tuple[str, ...]:
    return (
        str(row["moments"]),
        row["distance"],
        row["floor"],
        row["excess"],
        p_value(row["p_holm"]),
        row["standing_out"],
    )


def _agreement_table(frame: pd.DataFrame) -> Table:
    rows = [(row["first"], row["second"], *_figures(row)) for row in _told(frame)]
    caption = (
        "Total variation between what two models chose in the same moments; the floor is what one chance would give; "
        "excess with its 90 % interval over seeds, whose ends belong to one-sided tests at .05."
    )
    return Table("agreement", caption, ("first", "second", *_FIGURES), tuple(rows), labels=2)


def _edits_table(frame: pd.DataFrame) -> Table:
    rows = [(row["model"], row["edit"], row["leaves"], str(row["asked"]), *_figures(row)) for row in _told(frame)]
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
