"""Commands that run sweeps or say how they stand."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import (
    EXIT_FAILED,
    EXIT_INTERRUPTED,
    EXIT_OK,
    OVERRIDES,
    Folder,
    Mine,
    Trusted,
    TrustedServers,
    app,
    console,
    fail,
)
from foundry.commands.showing import analyze_and_show
from foundry.commands.view import check_view, watched
from foundry.composing.settings import BASELINES
from foundry.errors import InputError

if TYPE_CHECKING:
    from foundry.composing.compose import Composed
    from foundry.composing.preparing import Checked
    from foundry.expansion import Sweep
    from foundry.models.answers.base import Answers
    from foundry.models.base import ModelInfo
    from foundry.running.local import Runner
    from foundry.storing.store import SweepFolder


def run_overrides(argv: Sequence[str]) -> int:
    """Compose what the overrides ask for and run it; returns the exit code."""
    from foundry.composing.compose import compose

    composed = compose(argv)
    return EXIT_OK if composed is None else run_composed(composed)


def run_composed(composed: Composed, prepare: Callable[[SweepFolder], None] = lambda folder: None) -> int:
    """Check everything, then run what is asked for in its folder, once that is prepared."""
    from foundry.composing.preparing import checked

    check_view(composed.settings["view"])
    return run_checked(checked(composed), prepare)


def run_checked(found: Checked, prepare: Callable[[SweepFolder], None] = lambda folder: None) -> int:
    """Run what was checked in its folder, once that is prepared."""
    for line in found.notes:
        print(line)
    folder = found.create()
    prepare(folder)
    return run_folder(folder, found.settings, found.infos, found.runner)


def run_folder(folder: SweepFolder, settings: Any, infos: dict[str, ModelInfo], runner: Runner) -> int:
    """Run what has not ended, then say how it went; the exit code says it too."""
    from foundry.composing.preparing import job_of
    from foundry.display import ProgressDisplay
    from foundry.running.local import SweepInterrupted, SweepStopped

    job = job_of(folder, settings, infos)
    screen = console()
    print(f"{len(folder.runs())} runs in {folder.path}")
    try:
        with watched(folder, settings.get("view")), ProgressDisplay(folder, screen):
            runner.run(job)
    except SweepInterrupted:
        _report_end(folder)
        return fail(f"interrupted; go on with: foundry resume {folder.path}", EXIT_INTERRUPTED)
    except SweepStopped as error:
        _report_end(folder)
        return fail(f"the sweep was stopped: {error}", EXIT_FAILED)
    code = _report_end(folder)
    if settings["analyze"] == BASELINES:
        code = max(code, _run_beside(folder))
    if settings["analyze"]:
        analyze_and_show([folder.path], brief=True)
    return code


def run_baselines(path: Path, trusted: Sequence[str] = ()) -> int:
    """Run the scripted baselines of a sweep into the folder beside its runs; those that are there stay.

    Returns:
        The exit code: that of a sweep in which a run failed, or which was stopped, where that happened.

    Raises:
        typer.Exit: the user interrupted them.
    """
    from foundry.storing.store import SweepFolder
    from foundry.trust.targets import check_sweep_targets

    opened = SweepFolder.open(path)
    if opened.moments_file.exists():
        raise InputError(f"'{path}' is a probe, which has no baselines: name them among its models.")
    check_sweep_targets(opened.sweep, {}, trusted)
    return _run_beside(opened)


def _run_beside(opened: SweepFolder) -> int:
    from foundry.composing.baselines import baselines_of
    from foundry.composing.preflight import check
    from foundry.composing.preparing import runner_of
    from foundry.storing.store import SweepFolder

    sweep = baselines_of(opened.sweep)
    if not sweep.runs:
        print(f"{opened.path} compares every baseline itself")
        return EXIT_OK
    local = {"_target_": "foundry.running.local.LocalRunner"}
    settings = {"runner": local, "cache": {"path": ""}, "analyze": False, "view": None, "record": {"frames": 0}}
    folder = SweepFolder.create(opened.baselines_dir, sweep, settings, [])
    code = run_folder(folder, settings, check(sweep), runner_of(settings))
    if code == EXIT_INTERRUPTED:
        raise typer.Exit(code)
    return code


def _report_end(folder: SweepFolder) -> int:
    from foundry.display import failures

    summaries = [run.summary() for run in folder.runs()]
    complete = sum(one is not None and one.status == "complete" for one in summaries)
    lines = failures(folder)
    print(f"{complete} of {len(summaries)} runs complete in {folder.path}")
    for line in lines:
        print(f"  failed {line}")
    if complete < len(summaries) and lines:
        print(f"  try the failed runs again with: foundry resume {folder.path}")
    _print_unread(folder)
    _print_determinism(folder)
    return EXIT_OK if complete == len(summaries) else EXIT_FAILED


def _print_unread(folder: SweepFolder) -> None:
    """Say which models' replies could not be read, where that is more than a few."""
    from foundry.storing.unread import unread

    for one in unread(folder.runs()):
        print("\n".join(one.lines()))


def _print_determinism(folder: SweepFolder) -> None:
    """Say whether the servers repeat themselves."""
    from foundry.storing.determinism import told_of

    for one in told_of(folder):
        print(one.line())


@app.command(context_settings=OVERRIDES)
def plan(
    context: typer.Context,
    output_dir: Annotated[Path | None, typer.Option(help="Take the runs of this sweep's folder into account.")] = None,
) -> None:
    """Show what a sweep would do, and what it would send, without doing it.

    Takes what `foundry` takes: foundry plan -m model=llama3.2 seed=0-9
    """
    from foundry.composing.compose import compose
    from foundry.composing.planning import plan as plan_runs
    from foundry.composing.planning import repeats
    from foundry.composing.preflight import notes_of
    from foundry.composing.preparing import sweep_of
    from foundry.display import plan_table
    from foundry.storing.determinism import SETTING
    from foundry.storing.store import SweepFolder

    composed = compose(context.args)
    if composed is None:
        return
    sweep = sweep_of(composed)
    infos, note = known_models(sweep)
    asked = output_dir or (Path(composed.settings["output"]["dir"]) if composed.settings["output"]["dir"] else None)
    folders = {run.id: run for run in SweepFolder.open(asked).runs()} if asked and asked.exists() else {}
    planned = plan_runs(sweep, infos, existing_answers(composed), folders)
    console().print(plan_table(planned))
    to_send = sum(one.to_send for one in planned)
    complete = sum(one.complete for one in planned)
    print(f"{len(planned)} runs, {complete} complete; at most {to_send:,} calls would be sent")
    twice = repeats(sweep, planned, composed.settings[SETTING])
    if twice.again:
        print(
            f"determinism: {twice.again:,} of them would be made once more at the end, half of these beside as many "
            f"others as are then in flight, at most {twice.beside:,}"
        )
    for line in [*notes_of(sweep), *filter(None, [note])]:
        print(line)


def existing_answers(composed: Composed) -> Answers | None:
    """Return the answer cache, or None when there is none yet."""
    from foundry.models.answers import opening as answers

    return answers.existing_answers(composed.settings["cache"]["path"])


def known_models(sweep: Sweep) -> tuple[dict[str, ModelInfo], str]:
    """Return what the servers say, or nothing and the reason, since a plan needs no server."""
    from foundry.composing.preflight import check

    try:
        return check(sweep), ""
    except InputError as error:
        return {}, f"The sweep could not start now: {error}"


@app.command()
def resume(
    folder: Folder, trust_targets: Trusted = None, trust_servers: TrustedServers = False, config_dir: Mine = None
) -> None:
    """Go on with a sweep: complete runs are skipped, answered calls are not asked again.

    OLLAMA_HOST and OPENAI_BASE_URL, where they are set, replace the servers that the sweep began with.
    """
    from foundry.composing.preflight import check, declare
    from foundry.composing.preparing import model_lines, runner_of
    from foundry.composing.settings import checked_settings
    from foundry.storing.store import SweepFolder, check_declared, check_digests
    from foundry.trust import reaching
    from foundry.trust.targets import check_sweep_targets

    opened = SweepFolder.open(folder)
    opened.check_runnable()
    check_sweep_targets(opened.sweep, opened.settings, trust_targets or ())
    opened.sweep = reached_now(opened.sweep)
    if not trust_servers:
        reaching.check_models(condition.config["model"] for condition in opened.sweep.conditions)
        reaching.check_settings(opened.settings)
    settings = checked_settings(opened.settings)
    runner = runner_of(settings)
    infos = check(opened.sweep_here())
    check_digests(opened, model_lines(infos))
    check_declared(opened, declare(opened.sweep_here()))
    raise typer.Exit(run_folder(opened, settings, infos, runner))


def reached_now(sweep: Sweep) -> Sweep:
    """Return a recorded sweep with its models at the servers that the environment names, where it names any."""
    from foundry.expansion import with_hosts

    for variable, key in (("OLLAMA_HOST", "hosts"), ("OPENAI_BASE_URL", "base_url")):
        if variable in os.environ:
            sweep = with_hosts(sweep, os.environ[variable], key)
    return sweep


@app.command()
def status(folder: Folder, config_dir: Mine = None) -> None:
    """Show how far a sweep is, and why runs failed."""
    from foundry.display import failures, status_table
    from foundry.storing.store import SweepFolder

    opened = SweepFolder.open(folder)
    console().print(status_table(opened))
    for line in failures(opened):
        print(f"failed {line}")
    _print_unread(opened)
    _print_determinism(opened)
