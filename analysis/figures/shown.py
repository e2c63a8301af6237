"""The groups as tables and plots show them: names, places among the others, which are baselines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from analysis.comparison import Comparison
from analysis.groups import group_label
from analysis.lines import COMPLETE, FAILED
from analysis.plots import style
from foundry.records import Outcome, RunSummary
from foundry.storing.store import RunFolder

_READ = (Outcome.CHOSEN, Outcome.REPAIRED)


@dataclass(frozen=True)
class Shown:
    """A group.

    Attributes:
        group: the values of the columns that tell groups apart.
        index: place among the groups of its kind, baselines or not, which decides its looks.
        baseline: whether it is there to be compared with only.
    """

    group: tuple[str, ...]
    index: int
    baseline: bool

    @property
    def label(self) -> str:
        """Its name."""
        return group_label(self.group)

    @property
    def colour(self) -> str:
        """Its colour."""
        return style.colour(self.index, baseline=self.baseline)


@dataclass(frozen=True)
class Member:
    """A run and the group it belongs to."""

    folder: RunFolder
    shown: Shown
    seed: int
    status: str
    summary: RunSummary | None

    @property
    def complete(self) -> bool:
        """Whether the run came to its end."""
        return self.status == COMPLETE

    @property
    def failed(self) -> bool:
        """Whether a failure ended the run."""
        return self.status == FAILED

    @property
    def decisions(self) -> int:
        """Number of action decisions."""
        return sum(self.summary.counts.outcomes.values()) if self.summary else 0

    @property
    def unreadable(self) -> int:
        """Number of action decisions that could not be read."""
        outcomes = self.summary.counts.outcomes if self.summary else {}
        return sum(count for outcome, count in outcomes.items() if outcome not in _READ)


def members(
    runs: pd.DataFrame, groups: pd.DataFrame, shown: Sequence[Shown], folders: Mapping[str, RunFolder]
) -> list[Member]:
    """Return every run with its group, in their order.

    Args:
        runs: one row per run, as in the table of signatures.
        groups: the columns that tell groups apart, one row per run.
        shown: all groups.
        folders: the folders of the runs by id.
    """
    known = {one.group: one for one in shown}
    keys = groups.astype(str).itertuples(index=False, name=None)
    columns = (runs[name].tolist() for name in ("run", "seed", "status"))
    return [
        Member(folders[run], known[key], int(seed), str(status), folders[run].summary())
        for key, run, seed, status in zip(keys, *columns, strict=True)
    ]


def shown_groups(comparison: Comparison) -> list[Shown]:
    """Return the groups in the order of their first run, baselines last."""
    own = [group for group in comparison.groups if group not in comparison.baselines]
    others = [group for group in comparison.groups if group in comparison.baselines]
    return [
        *(Shown(group, index, False) for index, group in enumerate(own)),
        *(Shown(group, index, True) for index, group in enumerate(others)),
    ]
