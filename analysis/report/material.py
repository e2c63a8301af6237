"""Everything that a report is made of: the analysis, the statistics, and the runs behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from analysis.camera_run import CameraRun
from analysis.figures.examples import Examples, examples
from analysis.figures.shown import Member, Shown, members, shown_groups
from analysis.grid_records import is_grid
from analysis.labelling import Labelling, model_labelling, rule_labelling
from analysis.load import Folders, folders_of
from analysis.pipeline import Analysis, analyze
from analysis.run import GridRun
from foundry.storing.store import RunFolder, SweepFolder


@dataclass(frozen=True)
class Material:
    """What a report is made of.

    Attributes:
        sweeps: the sweeps.
        beside: the baselines beside them.
        analysis: tables and comparison.
        shown: the groups, baselines last.
        members: the runs.
        labellings: who says which messages are warnings, by run.
        examples: what is shown of the runs themselves.
    """

    sweeps: tuple[SweepFolder, ...]
    beside: tuple[SweepFolder, ...]
    analysis: Analysis
    shown: tuple[Shown, ...]
    members: tuple[Member, ...]
    labellings: Mapping[str, Labelling]
    examples: Examples

    @cached_property
    def kinds(self) -> set[type]:
        """The kinds of runs: 2D, 3D or both."""
        return {GridRun if is_grid(member.folder.config()) else CameraRun for member in self.members}

    @property
    def own(self) -> list[Shown]:
        """The groups that are no baselines."""
        return [one for one in self.shown if not one.baseline]

    def of(self, shown: Shown) -> list[Member]:
        """Return the runs of a group."""
        return [member for member in self.members if member.shown == shown]


def gather(dirs: Folders, *, labelled_by_model: bool = False, **options: Any) -> Material:
    """Analyse the sweeps, as far as that was not done before, and read what the report shows of their runs.

    Args:
        dirs: the folder of a sweep, or those of several.
        labelled_by_model: whether warnings are what a model labelled, and not what the rule says.
        **options: further ones of `analysis.analyze`, such as `family` and `margins`.

    Raises:
        InputError: as `analysis.analyze`.
        RecordError: a recorded file is damaged.
    """
    analysis = analyze(dirs, plots=False, labelled_by_model=labelled_by_model, **options)
    sweeps = [SweepFolder.open(path) for path in folders_of(dirs)]
    beside = [SweepFolder.open(sweep.baselines_dir) for sweep in sweeps if sweep.baselines_dir.exists()]
    labellings = _labellings(sweeps, labelled_by_model)
    shown = shown_groups(analysis.compared)
    found = members(analysis.runs, analysis.groups, shown, _folders([*sweeps, *beside]))
    return Material(
        sweeps=tuple(sweeps),
        beside=tuple(beside),
        analysis=analysis,
        shown=tuple(shown),
        members=tuple(found),
        labellings=labellings,
        examples=examples(found, shown, labellings),
    )


def _labellings(sweeps: Sequence[SweepFolder], labelled_by_model: bool) -> Mapping[str, Labelling]:
    """Return who says which messages are warnings, by run; the baselines of a sweep are labelled as the sweep is."""
    found: dict[str, Labelling] = {}
    for sweep in reversed(sweeps):
        labelling = model_labelling(sweep) if labelled_by_model else rule_labelling()
        beside = [SweepFolder.open(sweep.baselines_dir)] if sweep.baselines_dir.exists() else []
        found |= dict.fromkeys((run.id for one in (*beside, sweep) for run in one.runs()), labelling)
    return found


def _folders(sweeps: Sequence[SweepFolder]) -> Mapping[str, RunFolder]:
    """Return the runs by id; runs of one id are the same run, so the first stands for all."""
    return {run.id: run for sweep in reversed(sweeps) for run in sweep.runs()}
