"""Assigns each run to its group, and gives each group a marker and a colour."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from analysis.figures.shown import ShownGroup
from analysis.lines import COMPLETE, FAILED
from analysis.stats.factors import MODEL
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.groups import group_keys
from foundry.palette import LOOKS
from foundry.records import Outcome, RunSummary
from foundry.storing.store import RunFolder

_READ = (Outcome.CHOSEN, Outcome.REPAIRED)


@dataclass(frozen=True)
class Member:
    """A run and its group."""

    folder: RunFolder
    shown: ShownGroup
    seed: int
    status: str
    summary: RunSummary | None

    @property
    def complete(self) -> bool:
        """True if the run is complete."""
        return self.status == COMPLETE

    @property
    def failed(self) -> bool:
        """Whether the run ended because of a failure."""
        return self.status == FAILED

    @property
    def decisions(self) -> int:
        """Number of decisions that choose an action."""
        return sum(self.summary.counts.outcomes.values()) if self.summary else 0

    @property
    def unreadable(self) -> int:
        """Number of unreadable decisions about actions."""
        outcomes = self.summary.counts.outcomes if self.summary else {}
        return sum(count for outcome, count in outcomes.items() if outcome not in _READ)


def members(
    runs: pd.DataFrame, groups: pd.DataFrame, shown: Sequence[ShownGroup], folders: Mapping[str, RunFolder]
) -> list[Member]:
    """Return every run with its group, in the order of the runs."""
    known = {condition.group: condition for condition in shown}
    columns = (runs[name].tolist() for name in ("run", "seed", "status"))
    return [
        Member(folders[run], known[key], int(seed), str(status), folders[run].summary())
        for key, run, seed, status in zip(group_keys(groups), *columns, strict=True)
    ]


def shown_groups(comparison: Comparison) -> list[ShownGroup]:
    """Return the groups in the order of their models' first runs, baselines last; a model looks the same everywhere."""
    at = comparison.group_columns.index(MODEL)
    own = [group for group in comparison.groups if group not in comparison.baselines]
    others = [group for group in comparison.groups if group in comparison.baselines]
    return [*_looks(own, at, comparison.models, baseline=False), *_looks(others, at, (), baseline=True)]


def _looks(groups: Sequence[Group], at: int, order: Sequence[str], *, baseline: bool) -> list[ShownGroup]:
    models = list(dict.fromkeys(group[at] for group in groups))
    if len(models) == 1 < len(groups):
        return [ShownGroup(group, index, baseline) for index, group in enumerate(groups)]
    places = {model: place for place, model in enumerate(dict.fromkeys((*order, *models)))}
    return [
        ShownGroup(group, places[model] + turn * LOOKS, baseline)
        for model in models
        for turn, group in enumerate(group for group in groups if group[at] == model)
    ]
