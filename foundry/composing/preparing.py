"""From what was composed to a sweep that is checked, has its folder and can be run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from foundry.composing.compose import Composed
from foundry.composing.defaults import resolved
from foundry.composing.launching import LauncherRunner
from foundry.composing.points import Launch
from foundry.composing.preflight import check, check_begun, declare, notes_of
from foundry.composing.settings import UNTIL
from foundry.errors import InputError
from foundry.expansion import Sweep
from foundry.models.answers.addresses import settled
from foundry.models.answers.opening import check_reachable
from foundry.models.base import ModelInfo
from foundry.paths import conf_dir
from foundry.running.build import build
from foundry.running.local import Runner, SweepJob
from foundry.storing.determinism import SETTING
from foundry.storing.growing import growth
from foundry.storing.plain import read_config
from foundry.storing.store import SweepFolder, ensure_writable, fresh_folder, is_sweep
from foundry.trust.repeating import repeat_calls

OUTPUTS = Path("outputs")
"""Where sweeps go that name no folder."""


@dataclass(frozen=True)
class Checked:
    """A sweep in which nothing was found that could be wrong, and of which nothing is written yet.

    Attributes:
        composed: what was asked for.
        sweep: its runs.
        infos: what is known of each model, by `expansion.settings_key`.
        runner: what runs it.
        notes: what is to be known before it starts, one line each.
    """

    composed: Composed
    sweep: Sweep
    infos: dict[str, ModelInfo]
    runner: Runner
    notes: list[str]

    def create(self) -> SweepFolder:
        """Create its folder, or take up the one that is there.

        Raises:
            InputError: it cannot be written, or holds something else.
        """
        asked = self.composed.settings["output"]["dir"]
        ensure_writable(Path(asked) if asked else OUTPUTS)
        path = Path(asked) if asked else fresh_folder(OUTPUTS)
        folder = SweepFolder.create(path, self.sweep, self.settings, model_lines(self.infos))
        folder.write_multirun(self.composed.multirun)
        return folder

    @property
    def settings(self) -> dict[str, Any]:
        """Where and how it is run, the answer cache at the place that it has from now on."""
        settings = self.composed.settings
        return {**settings, "cache": {"path": settled(settings["cache"]["path"])}}


def _as_it_is(sweep: Sweep) -> Sweep:
    return sweep


def checked(composed: Composed, place: Callable[[Sweep], Sweep] = _as_it_is) -> Checked:
    """Check everything that can be wrong with a sweep.

    Args:
        composed: what was asked for.
        place: returns the sweep with what its folder is to hold for it at some other place, since it has none yet.

    Raises:
        InputError: something is.
    """
    if composed.settings.get(UNTIL) is not None:
        raise InputError(f"{UNTIL}={composed.settings[UNTIL]} belongs to the command foundry -m: leave it out here.")
    sweep = composed.sweep
    asked = composed.settings["output"]["dir"]
    there = SweepFolder.open(asked) if asked and is_sweep(Path(asked)) else None
    growing = [] if there is None else growth(there.sweep, sweep).notes(asked)
    runner = runner_of(composed.settings, composed.launch)
    here = place(sweep if there is None else there.with_scenes(sweep))
    if there is not None:
        check_begun(there, sweep)
    infos = check(here)
    sweep = declare(sweep, here)
    return Checked(composed, sweep, infos, runner, [*growing, *notes_of(here)])


def job_of(folder: SweepFolder, settings: Mapping[str, Any], infos: Mapping[str, ModelInfo]) -> SweepJob:
    """Return what is to be run.

    Raises:
        InputError: the answer cache cannot be reached.
    """
    check_reachable(settings["cache"]["path"])
    repeated = settings.get(SETTING, 0)
    recorded = {line["name"]: line for line in folder.models}
    return SweepJob(
        folder=folder,
        infos={key: _as_begun(info, recorded) for key, info in infos.items()},
        cache=settings["cache"]["path"],
        frame_every=settings["record"]["frames"],
        after_model=partial(repeat_calls, folder, repeated) if repeated else None,
    )


def _as_begun(info: ModelInfo, recorded: Mapping[str, Mapping[str, Any]]) -> ModelInfo:
    """Return what is known of a model with the digest that its sweep began with, so that keys of answers stay."""
    digest = recorded.get(info.name, {}).get("digest") or info.digest
    return replace(info, digest=digest, members=tuple(_as_begun(member, recorded) for member in info.members))


def model_lines(infos: Mapping[str, ModelInfo]) -> list[dict[str, Any]]:
    """Return what a sweep remembers of its models, the members of populations among them."""
    return [
        {"name": model.name, "digest": model.digest, "server_version": model.server_version}
        | {name: value for name in ("weights", "remote") if (value := getattr(model, name)) is not None}
        for info in infos.values()
        for model in (info, *info.members)
    ]


def runner_of(settings: Mapping[str, Any], launch: Launch | None = None) -> Runner:
    """Return what runs a sweep, or one of Hydra's own launchers where that was asked for.

    Raises:
        InputError: it cannot be built from its settings.
    """
    runner: Runner = build(settings["runner"]) if launch is None else LauncherRunner(launch)
    return runner


def local_runner(recorded: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that run a sweep's baselines on this machine.

    Args:
        recorded: the settings of the sweep's own runner. Its number of workers holds if it is local, too; a number of
            a cluster's workers says nothing of this machine.

    Returns:
        The settings of the group `runner/local`, with FOUNDRY_WORKERS where the sweep leaves the number open.

    Raises:
        InputError: FOUNDRY_WORKERS cannot be read.
    """
    file = conf_dir() / "runner" / "local.yaml"
    settings = resolved(read_config(file), file)
    if recorded["_target_"] == settings["_target_"] and recorded.get("workers") is not None:
        settings["workers"] = recorded["workers"]
    return settings
