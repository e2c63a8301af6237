"""Seed ranges in sweeps, and a launcher that composes each condition once and leaves the running to foundry.

Another launcher is kept for later: foundry makes the sweep's folder first, then has it start a job for each run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.config_store import ConfigStore
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.utils import JobReturn
from hydra.plugins.launcher import Launcher
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig

from foundry.composing.collecting import Collector
from foundry.errors import InputError
from foundry.expansion import expand_ranges


class FoundrySweeper(BasicSweeper):
    """Hydra's grid sweeper, with ranges of seeds, and without composing every job twice."""

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """Keep what another launcher needs."""
        super().setup(hydra_context=hydra_context, task_function=task_function, config=config)
        self.task_function = task_function

    def sweep(self, arguments: list[str]) -> Any:
        """Expand the sweep and hand all its jobs to the launcher at once."""
        assert self.hydra_context is not None and self.launcher is not None
        asked = [expand_ranges(override) for override in [*self._parse_config(), *arguments]]
        parser = OverridesParser.create(config_loader=self.hydra_context.config_loader)
        batches = self.split_arguments(parser.parse_overrides(asked), self.max_batch_size)
        jobs = [job for batch in batches for job in batch]
        return [self._composing().launch(jobs, initial_job_idx=0)]

    def _composing(self) -> FoundryLauncher:
        """Return the launcher that composes; another one, asked for instead, is kept for when the runs are known."""
        if isinstance(self.launcher, FoundryLauncher):
            return self.launcher
        assert self.hydra_context is not None and self.config is not None
        _collector(self.task_function).launch = self._launch
        composing = FoundryLauncher()
        composing.setup(hydra_context=self.hydra_context, task_function=self.task_function, config=self.config)
        return composing

    def _launch(self, task: TaskFunction, jobs: Sequence[Sequence[str]]) -> Sequence[JobReturn]:
        """Have the launcher that was asked for call a function in a job for each list of overrides."""
        assert self.hydra_context is not None and self.launcher is not None and self.config is not None
        self.launcher.setup(hydra_context=self.hydra_context, task_function=task, config=self.config)
        return self.launcher.launch(jobs, initial_job_idx=0)


class FoundryLauncher(Launcher):
    """Groups the jobs by condition, composes each condition once and gives it to the task function."""

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """Keep what `launch` needs."""
        self.hydra_context = hydra_context
        self.task_function = task_function
        self.config = config

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> Sequence[JobReturn]:
        """Compose every condition and pass it on with its seeds; nothing is run here."""
        conditions: dict[tuple[str, ...], list[str]] = {}
        for job in job_overrides:
            condition = tuple(o for o in job if not o.startswith("seed="))
            seeds = [o.removeprefix("seed=") for o in job if o.startswith("seed=")]
            conditions.setdefault(condition, []).extend(seeds)
        collector = _collector(self.task_function)
        for condition, seeds in conditions.items():
            config = self.hydra_context.config_loader.load_sweep_config(self.config, list(condition))
            collector.add(config, condition, seeds, config.hydra.runtime.choices)
        return []


def _collector(task: TaskFunction) -> Collector:
    """Return what takes the conditions: Hydra hands on, untouched, what `foundry` gave it to call.

    Raises:
        InputError: another program chose the sweeper or the launcher of foundry.
    """
    if not isinstance(task, Collector):
        raise InputError("hydra/sweeper=foundry and hydra/launcher=foundry serve the command foundry alone.")
    return task


_HERE = "hydra_plugins.foundry_plugins.sweeping"
_STORE = ConfigStore.instance()
_STORE.store(
    group="hydra/sweeper",
    name="foundry",
    node={"_target_": f"{_HERE}.FoundrySweeper", "max_batch_size": None, "params": {}},
    provider="foundry",
)
_STORE.store(
    group="hydra/launcher",
    name="foundry",
    node={"_target_": f"{_HERE}.FoundryLauncher"},
    provider="foundry",
)
