"""Runs a sweep by one of Hydra's own launchers (joblib, submitit): every job plays one run into the shared folder."""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from foundry.composing.points import Launch
from foundry.errors import FoundryError
from foundry.running.lane import Lane, LaneSpec, run_lane
from foundry.running.local import PlayPhase, Runner, SweepJob, SweepStopped, raise_if_stopped
from foundry.storing.store import RunFolder, SweepFolder


@dataclass(frozen=True)
class OneRun:
    """What a job does: it plays the run that has the job's number.

    Attributes:
        spec: what every job is given.
        command: process of the command, which keeps its Ctrl-C where a launcher runs jobs in that process.
    """

    spec: LaneSpec
    command: int

    def __call__(self, config: object) -> str | None:
        """Play the run; the configuration that Hydra composed for the job is the sweep's, and known."""
        from hydra.core.hydra_config import HydraConfig

        number = int(HydraConfig.get().job.num)
        spec = replace(self.spec, name=f"{self.spec.name}-{number}", runs=(self.spec.runs[number],))
        return Lane(spec).run() if os.getpid() == self.command else run_lane(spec)


class LauncherRunner(Runner):
    """Has a launcher start a job for each run; where and when jobs run is the launcher's to say."""

    def __init__(self, launch: Launch) -> None:
        super().__init__(open_runs=1)
        self._launch = launch

    @contextlib.contextmanager
    def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
        """Check nothing: the launcher finds out."""
        folder = job.folder
        absolute = SweepFolder(folder.path.absolute(), folder.sweep, folder.settings, folder.models)
        yield functools.partial(self._play, replace(job, folder=absolute))

    def _play(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> None:
        jobs = [[f"seed={run.run.seed}"] for run in runs]
        fatal: str | None = None
        try:
            for done in self._launch(OneRun(self.spec(job, runs, number), os.getpid()), jobs):
                fatal = fatal or done.return_value
        except FoundryError:
            raise
        except Exception as error:  # the boundary: every launcher has errors of its own
            raise SweepStopped(f"the launcher's jobs failed: {type(error).__name__}: {error}") from error
        raise_if_stopped(fatal, job)
