"""The runs of one sweep, measured and put into groups, without a table being written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from analysis.figures.members import Member, members, shown_groups
from analysis.load import runs_by_id
from analysis.measuring.memory import open_memory
from analysis.measuring.runs import RunResult, measure_runs
from analysis.pipeline import sources_of
from analysis.prose import percent
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison, compare
from analysis.tables.groups import group_columns, group_keys
from analysis.tables.signature_table import build_table
from foundry.storing.determinism import repeats_of
from foundry.storing.store import SweepFolder, ensure_writable


@dataclass(frozen=True)
class Found:
    """A sweep as a card takes it.

    Attributes:
        sweep: the sweep.
        compared: its groups, with baselines that were run beside it.
        first: the first run of each group.
        members: the runs.
    """

    sweep: SweepFolder
    compared: Comparison
    first: Mapping[Group, RunResult]
    members: tuple[Member, ...]

    @property
    def name(self) -> str:
        """The name of its folder."""
        return self.sweep.path.resolve().name

    @property
    def models(self) -> set[str]:
        """The models that ran in it."""
        return {str(one.keys["model"]) for one in self.first.values()}

    def facts(self, model: str) -> tuple[str, ...]:
        """Return the row of a model: sweep, weights, foundry, repeating, runs, complete, unread decisions."""
        mine = [one for one in self.members if str(one.folder.config()["model"]["name"]) == model]
        summaries = [one.summary for one in mine if one.summary is not None]
        decisions = sum(one.decisions for one in mine)
        return (
            self.name,
            _unique((one.model_digest or "")[:12] for one in summaries),
            _unique(one.foundry_version for one in summaries),
            _unique(f"{one.least} calls exactly" for one in repeats_of(self.sweep) if one.of == model),
            str(len(mine)),
            str(sum(one.complete for one in mine)),
            percent(sum(one.unreadable for one in mine) / decisions) if decisions else "-",
        )


def _unique(texts: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(filter(None, texts))) or "-"


def read_sweep(sweep: SweepFolder) -> Found:
    """Return the runs of a sweep; those that were measured before are not measured again.

    Raises:
        InputError: its folder cannot be written.
        RecordError: a recorded file is damaged.
    """
    sources = sources_of([sweep], [sweep.path.name], labelled_by_model=False)
    ensure_writable(sweep.analysis_dir)
    with open_memory(sweep.analysis_dir / "measured.sqlite") as memory:
        results = [one.without_steps() for one in measure_runs(sources, memory)]
    table = build_table(results)
    groups = group_columns(results, table)
    compared = compare(table, groups)
    first: dict[Group, RunResult] = {}
    for key, result in zip(group_keys(groups), results, strict=True):
        first.setdefault(key, result)
    folders = runs_by_id([source.path for source in sources])
    return Found(sweep, compared, first, tuple(members(table.frame, groups, shown_groups(compared), folders)))
