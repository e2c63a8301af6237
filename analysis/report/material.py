"""Gathers the content of a report: the analysis, and the runs on which it is based."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from analysis.figures.examples import Examples, examples
from analysis.figures.members import Member
from analysis.figures.shown import ShownGroup
from analysis.form import FormAnalysis, forms_of
from analysis.labelling import Labelling, labelling_of
from analysis.load import Folders, folders_of
from analysis.paper.methods import Basis
from analysis.pipeline import Analysis, analyze, basis_of
from foundry.storing.store import SweepFolder


@dataclass(frozen=True)
class Material:
    """The content of a report.

    Attributes:
        beside: sweeps with the baselines of these sweeps.
    """

    sweeps: tuple[SweepFolder, ...]
    beside: tuple[SweepFolder, ...]
    analysis: Analysis
    labellings: Mapping[str, Labelling]
    examples: Examples

    @property
    def shown(self) -> tuple[ShownGroup, ...]:
        """The groups of runs; the baselines are last."""
        return self.analysis.shown

    @property
    def members(self) -> tuple[Member, ...]:
        """The runs."""
        return self.analysis.members

    @cached_property
    def forms(self) -> list[FormAnalysis]:
        """The forms of the runs."""
        return forms_of(member.folder for member in self.members)

    @cached_property
    def labelled_by(self) -> list[Labelling]:
        """For each run, who labels messages as warnings."""
        return list(self.labellings.values())

    @cached_property
    def basis(self) -> Basis:
        """The data from which the methods section and its references are written."""
        return basis_of(self.analysis, self.labelled_by)

    @property
    def own(self) -> list[ShownGroup]:
        """The groups other than baselines."""
        return [shown for shown in self.shown if not shown.baseline]

    def of(self, shown: ShownGroup) -> list[Member]:
        """Return the runs of a group."""
        return [member for member in self.members if member.shown == shown]


def gather(dirs: Folders, *, labelled_by_model: bool = False, **options: Any) -> Material:
    """Analyse sweeps with the options of `analysis.analyze`, and read the content of their report.

    Raises:
        InputError: as for `analysis.analyze`.
        RecordError: a recorded file is damaged.
    """
    analysis = analyze(dirs, plots=False, labelled_by_model=labelled_by_model, **options)
    sweeps = [SweepFolder.open(path) for path in folders_of(dirs)]
    beside = [SweepFolder.open(sweep.baselines_dir) for sweep in sweeps if sweep.baselines_dir.exists()]
    labellings = _labellings(sweeps, labelled_by_model)
    return Material(
        sweeps=tuple(sweeps),
        beside=tuple(beside),
        analysis=analysis,
        labellings=labellings,
        examples=examples(analysis.members, analysis.shown, labellings),
    )


def _labellings(sweeps: Sequence[SweepFolder], labelled_by_model: bool) -> Mapping[str, Labelling]:
    """Return for each run id who labels messages as warnings; a sweep's baselines get the labeller of the sweep."""
    by_run: dict[str, Labelling] = {}
    for sweep in reversed(sweeps):
        labelling = labelling_of(sweep, by_model=labelled_by_model)
        beside = [SweepFolder.open(sweep.baselines_dir)] if sweep.baselines_dir.exists() else []
        by_run |= dict.fromkeys((run.id for folder in (*beside, sweep) for run in folder.runs()), labelling)
    return by_run
