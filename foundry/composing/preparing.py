"""Checks composed conditions and creates the folder of their sweep. A sweep with a plan runs from look to look."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from foundry.composing.compose import Composed
from foundry.composing.defaults import resolved
from foundry.composing.identifying import identified, remember
from foundry.composing.points import Launch
from foundry.composing.preflight import check, check_begun, declare, notes_of
from foundry.composing.settings import UNTIL
from foundry.errors import FoundryError, InputError
from foundry.expansion import Sweep, expand
from foundry.models.answers.answers import settled
from foundry.models.answers.known_weights import with_weights
from foundry.models.answers.opening import check_reachable
from foundry.models.base import ModelInfo
from foundry.paths import conf_dir
from foundry.running.build import build
from foundry.running.lane import Lane, LaneSpec, run_lane
from foundry.running.local import PlayPhase, Runner, SweepJob, SweepStopped, raise_if_stopped
from foundry.storing.determinism import SETTING
from foundry.storing.growing import growth
from foundry.storing.plain import read_config
from foundry.storing.preregistration import PREREGISTRATION_FILE, Preregistration, preregistration_of
from foundry.storing.store import RunFolder, SweepFolder, ensure_writable, fresh_folder, is_sweep
from foundry.trust.repeating import repeat_calls

OUTPUTS = Path("outputs")
"""Folder for sweeps that name no output.dir."""


@dataclass(frozen=True)
class OneRun:
    """Plays one run as a job of a launcher: job number n plays the run with index n in `spec`.

    Attributes:
        spec: input of every job.
        command: id of the process of the command. A job in this process leaves Ctrl-C to the command.
    """

    spec: LaneSpec
    command: int

    def __call__(self, config: object) -> str | None:
        """Play the run. Hydra's configuration of the job is ignored, since `spec` contains the run's settings."""
        from hydra.core.hydra_config import HydraConfig

        number = int(HydraConfig.get().job.num)
        spec = replace(self.spec, name=f"{self.spec.name}-{number}", runs=(self.spec.runs[number],))
        return Lane(spec).run() if os.getpid() == self.command else run_lane(spec)


class LauncherRunner(Runner):
    """Lets one of Hydra's launchers start a job for each run; the launcher decides where and when jobs run."""

    def __init__(self, launch: Launch) -> None:
        super().__init__(open_runs=1)
        self._launch = launch

    @contextlib.contextmanager
    def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
        """Yield the function that plays runs; nothing is checked first, since the launcher reports its errors."""
        yield partial(self._play, replace(job, folder=job.folder.part(job.folder.runs())))

    def _play(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> None:
        jobs = [[f"seed={run.run.seed}"] for run in runs]
        fatal: str | None = None
        try:
            for done in self._launch(OneRun(self.spec(job, runs, number), os.getpid()), jobs):
                fatal = fatal or done.return_value
        except FoundryError:
            raise
        except Exception as error:  # the boundary: every launcher has its own errors
            raise SweepStopped(f"the launcher's jobs failed: {type(error).__name__}: {error}") from error
        raise_if_stopped(fatal, job)


def stages(composed: Composed) -> list[Composed]:
    """Return the runs up to each interim analysis (look) of the plan in the sweep's folder.

    Each stage has the first seeds of the plan, and the next stage adds seeds to them.
    """
    plan = _plan(composed)
    ids = {run.id for run in expand(composed.asked, composed.conditions).runs}
    if ids != plan.runs.keys():
        raise InputError(
            f"{UNTIL}=answered runs exactly the {len(plan.runs)} runs of {PREREGISTRATION_FILE}. Your overrides "
            f"leave out {len(plan.runs.keys() - ids)} of these runs and add {len(ids - plan.runs.keys())} other runs. "
            f"Repeat the overrides with which {PREREGISTRATION_FILE} was made."
        )
    return [replace(part, settings={**part.settings, UNTIL: None}) for part in _parts(composed, plan)]


def _plan(composed: Composed) -> Preregistration:
    folder = composed.settings["output"]["dir"]
    plan = preregistration_of(Path(folder)) if folder else None
    if plan is None:
        where = f"folder '{folder}' contains no {PREREGISTRATION_FILE}" if folder else "no output.dir is named"
        raise InputError(f"{UNTIL}=answered needs a plan, but {where}. Make a plan with: foundry preregister")
    if is_sweep(Path(folder)) and SweepFolder.open(folder).plan != plan[1]:
        raise InputError(
            f"The sweep in '{folder}' began without this plan, so it cannot follow the plan. Preregister and run it in "
            "another output.dir."
        )
    return plan[0]


def _parts(composed: Composed, plan: Preregistration) -> Iterator[Composed]:
    for look in plan.looks:
        own = set(plan.seeds[: look.seeds])
        parts = (
            replace(condition, seeds=tuple(seed for seed in condition.seeds if seed in own))
            for condition in composed.conditions
        )
        yield replace(composed, conditions=tuple(part for part in parts if part.seeds))


@dataclass(frozen=True)
class CheckedSweep:
    """A sweep that has passed all checks; nothing of it is on the disk yet."""

    composed: Composed
    sweep: Sweep
    infos: dict[str, ModelInfo]
    runner: Runner
    notes: list[str]

    def create(self) -> SweepFolder:
        """Create the folder of the sweep, or continue the existing one."""
        target = self.composed.settings["output"]["dir"]
        ensure_writable(Path(target) if target else OUTPUTS)
        path = Path(target) if target else fresh_folder(OUTPUTS)
        folder = SweepFolder.create(path, self.sweep, self.settings, model_lines(self.infos))
        folder.write_multirun(self.composed.multirun)
        return folder

    @property
    def settings(self) -> dict[str, Any]:
        """The settings that say where and how the sweep runs, with the final address of the answer cache."""
        settings = self.composed.settings
        return {**settings, "cache": {"path": settled(settings["cache"]["path"])}}


def checked(composed: Composed, place: Callable[[Sweep], Sweep] = lambda sweep: sweep) -> CheckedSweep:
    """Check everything that can be wrong with a sweep. The function `place` puts paths of this machine into it."""
    if composed.settings.get(UNTIL) is not None:
        raise InputError(
            f"{UNTIL}={composed.settings[UNTIL]} only works with the command foundry -m. Leave it out here."
        )
    sweep = composed.sweep
    folder = composed.settings["output"]["dir"]
    there = SweepFolder.open(folder) if folder and is_sweep(Path(folder)) else None
    growing = [] if there is None else growth(there.sweep, sweep).notes(folder)
    runner = runner_of(composed.settings, composed.launch)
    here = place(sweep if there is None else there.with_scenes(sweep))
    if there is not None:
        check_begun(there, sweep)
    infos = check(here)
    if there is None:
        infos = identified(sweep, infos, composed.settings["cache"]["path"])
    sweep = declare(sweep, here)
    return CheckedSweep(composed, sweep, infos, runner, [*growing, *notes_of(here)])


def job_of(folder: SweepFolder, settings: Mapping[str, Any], infos: Mapping[str, ModelInfo]) -> SweepJob:
    """Return the input of a runner: the sweep's folder, its settings, and facts about its models."""
    check_reachable(settings["cache"]["path"])
    repeated = settings.get(SETTING, 0)
    recorded = {line["name"]: line for line in folder.models}
    begun = {key: _as_begun(info, recorded) for key, info in infos.items()}
    remember(folder, begun, settings["cache"]["path"])
    return SweepJob(
        folder=folder,
        infos=begun,
        cache=settings["cache"]["path"],
        frame_every=settings["record"]["frames"],
        after_model=partial(repeat_calls, folder, repeated) if repeated else None,
    )


def _as_begun(info: ModelInfo, recorded: Mapping[str, Mapping[str, Any]]) -> ModelInfo:
    """Return a model's facts, with the digest that was recorded when the sweep began, so cached answers stay valid."""
    digest = recorded.get(info.name, {}).get("digest") or info.digest
    same = with_weights(info, digest or "")
    return replace(same, digest=digest, members=tuple(_as_begun(member, recorded) for member in info.members))


def model_lines(infos: Mapping[str, ModelInfo]) -> list[dict[str, Any]]:
    """Return what a sweep records about its models and the members of populations."""
    return [
        {"name": model.name, "digest": model.digest, "server_version": model.server_version}
        | {name: value for name in ("weights", "remote") if (value := getattr(model, name)) is not None}
        for info in infos.values()
        for model in (info, *info.members)
    ]


def runner_of(settings: Mapping[str, Any], launch: Launch | None = None) -> Runner:
    """Return the runner of a sweep: one of Hydra's launchers if one is named."""
    runner: Runner = build(settings["runner"]) if launch is None else LauncherRunner(launch)
    return runner


def local_runner(recorded: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of the runner that plays a sweep's baselines on this machine.

    Args:
        recorded: the settings of the sweep's runner. If it is local too, its number of workers applies here.

    Returns:
        The settings in `conf/runner/local.yaml`, with FOUNDRY_WORKERS if the sweep leaves the number open.
    """
    file = conf_dir() / "runner" / "local.yaml"
    settings = resolved(read_config(file), file)
    if recorded["_target_"] == settings["_target_"] and recorded.get("workers") is not None:
        settings["workers"] = recorded["workers"]
    return settings
