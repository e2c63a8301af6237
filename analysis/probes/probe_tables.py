"""Analyses a probe: compares models, edits and formats, and writes tables, plots and findings."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.filtering import Filter
from analysis.findings.finding_records import FindingRecord, write_findings
from analysis.findings.ranking import findings
from analysis.findings.recording import records_of
from analysis.paper.ending import EndingContent, ending
from analysis.paper.sentence import Row, Sides
from analysis.paper.summary import summary_of
from analysis.plots import draw, write
from analysis.probes.changed import changes_of
from analysis.probes.choices import Answers, MomentKey, read_answers
from analysis.probes.comparing import Compared, compared_edits, compared_pairs, framed
from analysis.probes.curves import curve_tables
from analysis.probes.differences import CAPTION, DISTANCES, contrasts_of, sides_of
from analysis.probes.distance import ChoiceDistance
from analysis.probes.formats import format_tables
from analysis.probes.layouts import LAYOUTS
from analysis.probes.narrowing import narrowed, strata_of, with_strata
from analysis.probes.probe_declaring import Family, held_probe
from analysis.probes.probe_pictures import pictures_of
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.tables.table import Table
from analysis.tables.texts import contrast_table, write_numbers, write_summary, write_table
from foundry.storing.store import SweepFolder, ensure_writable
from foundry.texts import counted

MOST_SHOWN = 20
"""Maximum number of moments that are shown: those with the largest distances between models."""
_MOMENT = MomentKey._fields
_NOT_AGAIN = ("output.dir", "moments_seed")
"""Settings that a command for other moments must not repeat."""


@dataclass(frozen=True)
class ProbeAnalysis:
    """The results of a probe's analysis, and their files.

    Attributes:
        frames: the tables of numbers, by name.
        contrasts: comparisons of models, edits and formats, in the columns of a sweep's contrasts.
        tables: the short tables that have rows.
        furthest: the `MOST_SHOWN` moments with the largest distances between models, and these distances.
        planned: whether a plan made before the runs declares the comparisons.
        filtered: description of the filter; "" if all answers are included.
    """

    path: Path
    frames: Mapping[str, pd.DataFrame]
    contrasts: pd.DataFrame
    tables: tuple[Table, ...]
    notes: tuple[str, ...]
    furthest: Mapping[MomentKey, ChoiceDistance]
    planned: bool
    filtered: str
    written: tuple[Path, ...] = ()

    @property
    def every_frame(self) -> dict[str, pd.DataFrame]:
        """All tables with numbers."""
        return {**self.frames, "contrasts": self.contrasts}

    @cached_property
    def sides(self) -> Sides:
        """Facts about the compared models, edits and formats, for sentences."""
        return sides_of(self.frames)

    @cached_property
    def findings(self) -> tuple[FindingRecord, ...]:
        """The comparisons with a difference above 0, the largest first, as in `findings.json`."""
        above = self.contrasts[self.contrasts["difference"] > 0]
        return tuple(records_of(findings(above.to_dict("records")), self.sides, _Elsewhere()))

    @property
    def summary(self) -> tuple[str, ...]:
        """A sentence for each finding."""
        lead = [f"These are findings of a part of the answers: {self.filtered}."] if self.filtered else []
        lead += [DISTANCES] if len(self.contrasts) else []
        return summary_of(self.contrasts, self.sides, self.alone, lead, planned=self.planned)

    @property
    def alone(self) -> str:
        """A sentence for a probe that compares neither models nor edits."""
        if len(self.frames["steepness"]):
            return "Neither models nor edits are compared: see steepness.md."
        return "Nothing is compared: one model was asked, without edits."

    @property
    def study(self) -> str:
        """The size of the probe in one line: models, moments, edits, formats and answers."""
        moments = self.frames["moments"]
        parts = [
            counted(moments["model"].nunique(), "model"),
            f"{counted(len(moments[list(_MOMENT)].drop_duplicates()), 'moment')} of "
            f"{counted(moments['seed'].nunique(), 'seed')}",
            *(f"{counted(number, what)}" for what in ("edit", "format") if (number := moments[what].nunique() - 1) > 0),
        ]
        return f"{', '.join(parts)}: {counted(int(moments['count'].sum()), 'answer')}"

    def in_other_moments(self, folder: Path, measures: Sequence[str]) -> str:
        """Return the command that declares these comparisons for other moments; "" if only formats are compared."""
        rows = self.contrasts[self.contrasts["measure"].isin(measures)].to_dict("records")
        asked = SweepFolder.open(folder).sweep.asked[1:]
        seeds = [int(argument.partition("=")[2]) for argument in asked if argument.startswith("moments_seed=")]
        arguments = [argument for argument in asked if argument.partition("=")[0] not in _NOT_AGAIN]
        names = dict.fromkeys(name for row in rows for name in _declares(row))
        family = [part for name in names for part in ("--family", name)]
        if not family:
            return ""
        return shlex.join(["foundry", "preregister", *arguments, f"moments_seed={max(seeds, default=0) + 1}", *family])

    def ending(self, folders: Sequence[Path], width: int, printed: int = 0) -> list[str]:
        """Return the last lines of the analysis on a terminal; see `analysis.paper.ending`."""
        (folder,) = folders
        results = EndingContent(
            contrasts=self.contrasts,
            sides=self.sides,
            notes=self.notes,
            study=f"{self.study}. {DISTANCES}" if len(self.contrasts) else self.study,
            folders=str(folder),
            tables=str(self.path),
            again=lambda measures, pairs: self.in_other_moments(folder, measures),
            alone=self.alone,
            one_sided=True,
        )
        return ending(results, width, printed)


def analyze_probe(
    folder: SweepFolder,
    family: Sequence[str] = (),
    *,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    plots: bool = True,
) -> ProbeAnalysis:
    """Compare models, edits and formats of a probe, and write the results into its folder.

    Args:
        folder: the probe.
        family: declared models and edits; by default all.
        only: filters KEY=VALUE[,VALUE...] for answers to include, such as `edit=no_fire`; see `narrowing.narrowed`.
        without: filters for answers to exclude, in the same form.
        plots: whether to draw the plots.

    Raises:
        InputError: a name is not in the probe, no answer is left, or a family is given although there is a plan.
        RecordError: a recorded file is damaged.
    """
    every, strata, chosen = read_answers(folder.runs()), strata_of(folder.moments_file), Filter.of(only, without)
    answers = narrowed(every, strata, chosen)
    held, late = held_probe(folder, family)
    declared = Family.of(held.plan.family if held else family, answers)
    pairs = compared_pairs(answers)
    agreement = framed(pairs, ("first", "second"))
    edits = framed(compared_edits(answers), ("model", "edit", "leaves", "asked"))
    declared.correct(agreement, edits)
    spread, orders = format_tables(answers, declared)
    curves, steepness = curve_tables(answers, declared)
    frames = {
        "moments": with_strata(_moments(answers), strata),
        "agreement": agreement,
        "edits": edits,
        "edit_choices": changes_of(answers, declared),
        "formats": spread,
        "format_orders": orders,
        "curves": curves,
        "steepness": steepness,
    }
    filtered = f"{chosen}: {answers.count:,} of {every.count:,} answers" if chosen else ""
    part = [f"only a part of the answers, {filtered}"] if filtered else []
    named = ["the family was named with the analysis"] if family else []
    planned = held.notes() if held else []
    known = held.plan.known if held else ""
    ensure_writable(folder.analysis_dir)
    chosen.write(folder.analysis_dir, answers.count, every.count, "answers")
    analysis = ProbeAnalysis(
        path=folder.analysis_dir,
        frames=frames,
        contrasts=contrasts_of(frames, declared, planned=held is not None, known=known),
        tables=(),
        notes=(*part, *planned, *late, *named, *declared.note(agreement, edits), *_notes(answers)),
        furthest=_furthest([compared for _, compared in pairs]),
        planned=held is not None,
        filtered=filtered,
    )
    return _written(analysis, plots=plots)


def _written(analysis: ProbeAnalysis, *, plots: bool) -> ProbeAnalysis:
    frames = analysis.every_frame
    short = {
        "contrasts": replace(contrast_table(analysis.contrasts), caption=CAPTION),
        **{name: layout.table(name, frames[name]) for name, layout in LAYOUTS.items()},
    }
    files: list[Path] = []
    for name, frame in frames.items():
        if name in short:
            files += write_table(analysis.path, short[name], frame, analysis.filtered)
        else:
            files += write_numbers(analysis.path / name, frame, analysis.filtered)
    for picture in pictures_of(analysis.frames, analysis.contrasts) if plots else ():
        files += write(draw(picture, "svg", "png"), analysis.path / "plots")
    files += [
        write_findings(analysis.path, analysis.findings),
        write_summary(analysis.path, analysis.summary, analysis.notes),
    ]
    tables = tuple(table for table in short.values() if table.rows)
    return replace(analysis, tables=tables, written=tuple(files))


class _Elsewhere:
    """Puts no example moments into `findings.json`, because the tables of a probe list all moments."""

    def moments(self, row: Row, level: str, reference: str) -> tuple[tuple[()], str]:
        """Return an empty tuple, and a sentence that names the file with all moments."""
        return (), "moments.csv has each model's choices in every moment"


def _declares(row: Row) -> tuple[str, ...]:
    return (row["level"], row["reference"]) if row["factor"] == "model" else (row["level"],) * (row["factor"] == "edit")


def _moments(answers: Answers) -> pd.DataFrame:
    rows = [
        (*key, answers.names[asked.subject], asked.edit, asked.format, choice, called[choice], share, by)
        for asked, chosen in answers.chosen.items()
        for key, counts in sorted(chosen.items())
        for called, by in [(answers.called(asked, key), answers.by(asked, key))]
        for choice, share in sorted(answers.shares(asked, key).items())
    ]
    return pd.DataFrame(rows, columns=[*_MOMENT, "model", "edit", "format", "choice", "count", "share", "by"])


def _furthest(pairs: Sequence[Compared]) -> dict[MomentKey, ChoiceDistance]:
    """Return the moments in which models differ most, with the mean distance between models and the mean floor.

    The order is by the distance minus the floor, as a mean over the pairs of models.
    """
    by_moment: dict[MomentKey, list[ChoiceDistance]] = {}
    for compared in pairs:
        for key, apart in compared.moments.items():
            by_moment.setdefault(key, []).append(apart)
    sums = {
        key: np.sum([(distance.distance, distance.floor) for distance in distances], axis=0)
        for key, distances in by_moment.items()
    }
    means = {
        key: ChoiceDistance(float(gap[0]) / len(pairs), float(gap[1]) / len(pairs), np.nan) for key, gap in sums.items()
    }
    order = sorted(means, key=lambda key: (-means[key].excess, -means[key].distance, key))
    return {key: means[key] for key in order[:MOST_SHOWN]}


def _notes(answers: Answers) -> Sequence[str]:
    chosen = [counts for mine in answers.chosen.values() for counts in mine.values()]
    seeds = {key.seed for mine in answers.chosen.values() for key in mine}
    notes = []
    if answers.missing:
        notes.append(f"{answers.missing} runs are incomplete, and their moments are missing")
    if answers.told:
        asked = sum(map(len, answers.chosen.values()))
        error = max(choices.error for choices in answers.told.values())
        notes.append(
            f"{len(answers.told):,} of {asked:,} sets of choices come from the probabilities of one reply, with an "
            f"error of at most {error:.2f}, and {asked - len(answers.told):,} from repeated calls"
        )
    if chosen and max(counts.total() for counts in chosen) == 1:
        notes.append("repeats=1: differences cannot be tested; use repeats=10")
    if len(seeds) < FEWEST_FOR_CLAIMS:
        notes.append(f"fewer than {FEWEST_FOR_CLAIMS} seeds: the numbers are descriptive, and nothing is tested")
    return notes
