"""What Hydra is given to call instead of a task: it keeps what is composed, and runs nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from foundry.expansion import overridden

Launch: TypeAlias = Callable[[Callable[[Any], Any], Sequence[Sequence[str]]], Sequence[Any]]
"""Calls a function in a job for each list of overrides; returns Hydra's `JobReturn`s."""


@dataclass(frozen=True)
class Collected:
    """One composed condition.

    Attributes:
        config: as Hydra composed it, unresolved.
        overrides: the swept overrides.
        seeds: the seeds that were asked for, as they were written; none where the configuration says the one.
        choices: the option of each group.
    """

    config: Any
    overrides: tuple[str, ...]
    seeds: tuple[Any, ...]
    choices: Mapping[str, str]


@dataclass
class Collector:
    """A task function that Hydra calls with a single run; the sweeper of `hydra_plugins` hands it whole sweeps.

    Attributes:
        conditions: what was composed so far.
        launch: has one of Hydra's own launchers call a function in jobs; None where none was asked for.
    """

    conditions: list[Collected] = field(default_factory=list)
    launch: Launch | None = None

    def __call__(self, config: Any) -> None:
        """Keep a single run, without Hydra's part."""
        from omegaconf import open_dict

        choices = dict(config.hydra.runtime.choices)
        with open_dict(config):
            del config["hydra"]
        self.add(config, (), (), choices)

    def said(self, argv: Sequence[str]) -> set[str]:
        """Return the keys that the command line or a sweep's file gives values, in whichever condition."""
        seeds = {"seed"} if any(one.seeds for one in self.conditions) else set()
        return overridden(argv).union(seeds, *(overridden(one.overrides) for one in self.conditions))

    def add(self, config: Any, overrides: Sequence[str], seeds: Sequence[Any], choices: Mapping[str, str]) -> None:
        """Keep a condition of a sweep."""
        self.conditions.append(Collected(config, tuple(overrides), tuple(seeds), dict(choices)))
