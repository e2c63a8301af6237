"""The command `foundry`: the only entry point, and the only code that prints.

`foundry [overrides]` and `foundry -m [overrides]` are read by Hydra, subcommands by Typer.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry import __version__
from foundry.errors import FoundryError, InputError, RecordError, not_found

if TYPE_CHECKING:
    from rich.console import Console

    from foundry.compose import Composed
    from foundry.models.answers import Answers
    from foundry.models.base import ModelInfo
    from foundry.store import SweepFolder
    from foundry.sweep import Sweep

EXIT_OK, EXIT_INPUT, EXIT_FAILED, EXIT_INTERRUPTED = 0, 2, 3, 130

_HELP = """Put language models into the same small world, the same seeds and prompts, and compare what they do.

foundry [OVERRIDES]       one run:   foundry model=scripted/random seed=3

foundry -m [OVERRIDES]    a sweep:   foundry -m model=qwen3:4b,llama3.2 seed=0-9

Overrides are Hydra's: world=..., prompt=..., world.steps=20, +sweep=cross_model; --hydra-help tells more.
"""

app = typer.Typer(
    name="foundry", help=_HELP, rich_markup_mode=None, pretty_exceptions_enable=False, no_args_is_help=False
)
_FILE_WIDTH = 200
"""Columns of a table that is written to a file or a pipe."""
_OVERRIDES = {"allow_extra_args": True, "ignore_unknown_options": True}
Folder = Annotated[Path, typer.Argument(help="A sweep's folder.", show_default=False)]


def main() -> None:
    """Run the command line and exit."""
    sys.exit(run(sys.argv[1:]))


def run(argv: Sequence[str]) -> int:
    """Run a command line and return the exit code: 0 complete, 2 bad input, 3 runs failed, 130 interrupted."""
    try:
        if _is_typer(argv):
            return _run_typer(argv)
        return _run_overrides(argv)
    except (InputError, RecordError) as error:
        return _fail(error, EXIT_INPUT)
    except FoundryError as error:
        return _fail(error, EXIT_FAILED)
    except KeyboardInterrupt:
        return _fail("interrupted", EXIT_INTERRUPTED)


def _fail(error: object, code: int) -> int:
    print(f"foundry: {error}", file=sys.stderr)
    return code


def _is_typer(argv: Sequence[str]) -> bool:
    """Return whether Typer reads this command line; refuses a word that is no command and no override."""
    if "_FOUNDRY_COMPLETE" in os.environ:
        return True
    first = argv[0] if argv else ""
    names = [str(getattr(command.callback, "__name__", "")) for command in app.registered_commands]
    if first in names or first in ("--help", "-h", "--version", "--install-completion", "--show-completion"):
        return True
    if first and not first.startswith(("-", "~")) and "=" not in first:
        raise not_found("Command", first, names, "An override has the form key=value.")
    return False


def _run_typer(argv: Sequence[str]) -> int:
    arguments = ["--help" if argument == "-h" else argument for argument in argv]
    try:
        app(args=arguments, prog_name="foundry")
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else EXIT_OK
    return EXIT_OK


def _console() -> Console:
    from rich.console import Console

    return Console() if sys.stdout.isatty() else Console(width=_FILE_WIDTH)


def _print_version(value: bool) -> None:
    if value:
        print(f"foundry {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


def _run_overrides(argv: Sequence[str]) -> int:
    from foundry.compose import compose

    composed = compose(argv)
    return EXIT_OK if composed is None else _run_sweep(composed)


def _sweep_of(composed: Composed) -> Sweep:
    from foundry.sweep import expand

    return expand(composed.asked, composed.conditions)


def _run_sweep(composed: Composed) -> int:
    """Check everything, then run what is asked for in its folder."""
    from foundry.preflight import check
    from foundry.store import SweepFolder, ensure_writable, fresh_folder

    sweep = _sweep_of(composed)
    infos = check(sweep)
    asked = composed.settings["output"]["dir"]
    ensure_writable(Path(asked) if asked else Path("outputs"))
    path = Path(asked) if asked else fresh_folder(Path("outputs"))
    settings = {
        **composed.settings,
        "cache": {"path": str(Path(composed.settings["cache"]["path"]).absolute())},
    }
    folder = SweepFolder.create(path, sweep, settings, [_model_line(info) for info in infos.values()])
    folder.write_multirun(composed.multirun)
    return _run_folder(folder, settings, infos)


def _model_line(info: ModelInfo) -> dict[str, Any]:
    return {"name": info.name, "digest": info.digest, "server_version": info.server_version}


def _run_folder(folder: SweepFolder, settings: Any, infos: dict[str, ModelInfo]) -> int:
    """Run what has not ended, then say how it went; the exit code says it too."""
    from foundry.build import build
    from foundry.display import ProgressDisplay
    from foundry.runner import SweepInterrupted, SweepJob, SweepStopped

    job = SweepJob(
        folder=folder,
        infos=infos,
        cache_path=Path(settings["cache"]["path"]),
        frame_every=_frame_every(settings["record"]["frames"]),
    )
    console = _console()
    print(f"{len(folder.runs())} runs in {folder.path}")
    try:
        with ProgressDisplay(folder, console):
            build(settings["runner"]).run(job)
    except SweepInterrupted:
        _report_end(folder)
        return _fail(f"interrupted; go on with: foundry resume {folder.path}", EXIT_INTERRUPTED)
    except SweepStopped as error:
        _report_end(folder)
        return _fail(f"the sweep was stopped: {error}", EXIT_FAILED)
    code = _report_end(folder)
    if settings["analyze"]:
        _analyze([folder.path])
    return code


def _frame_every(frames: object) -> int:
    if isinstance(frames, int) and frames >= 0:
        return int(frames)
    raise InputError(f"record.frames={frames} is neither true, false nor a number of steps.")


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
    return EXIT_OK if complete == len(summaries) else EXIT_FAILED


@app.command(context_settings=_OVERRIDES)
def plan(
    context: typer.Context,
    output_dir: Annotated[Path | None, typer.Option(help="Take the runs of this sweep's folder into account.")] = None,
) -> None:
    """Show what a sweep would do, and what it would send, without doing it.

    Takes what `foundry` takes: foundry plan -m model=llama3.2 seed=0-9
    """
    from foundry.compose import compose
    from foundry.display import plan_table
    from foundry.planning import plan as plan_runs
    from foundry.store import SweepFolder

    composed = compose(context.args)
    if composed is None:
        return
    sweep = _sweep_of(composed)
    infos, note = _known_models(sweep)
    asked = output_dir or (Path(composed.settings["output"]["dir"]) if composed.settings["output"]["dir"] else None)
    folders = {run.id: run for run in SweepFolder.open(asked).runs()} if asked and asked.exists() else {}
    planned = plan_runs(sweep, infos, _existing_answers(composed), folders)
    _console().print(plan_table(planned))
    to_send = sum(one.to_send for one in planned)
    complete = sum(one.complete for one in planned)
    print(f"{len(planned)} runs, {complete} complete; at most {to_send:,} calls would be sent")
    if note:
        print(note)


def _existing_answers(composed: Composed) -> Answers | None:
    from foundry.models.answers import Answers

    path = Path(composed.settings["cache"]["path"])
    return Answers(path) if path.exists() else None


def _known_models(sweep: Sweep) -> tuple[dict[str, ModelInfo], str]:
    """Return what the servers say, or nothing and the reason, since a plan needs no server."""
    from foundry.preflight import check

    try:
        return check(sweep), ""
    except InputError as error:
        return {}, f"The sweep could not start now: {error}"


@app.command()
def resume(folder: Folder) -> None:
    """Go on with a sweep: complete runs are skipped, answered calls are not asked again.

    OLLAMA_HOST, where it is set, replaces the hosts that the sweep began with.
    """
    from foundry.preflight import check
    from foundry.store import SweepFolder, check_digests
    from foundry.sweep import with_hosts

    opened = SweepFolder.open(folder)
    if "OLLAMA_HOST" in os.environ:
        opened.sweep = with_hosts(opened.sweep, os.environ["OLLAMA_HOST"])
    infos = check(opened.sweep)
    check_digests(opened, [_model_line(info) for info in infos.values()])
    raise typer.Exit(_run_folder(opened, opened.settings, infos))


@app.command()
def status(folder: Folder) -> None:
    """Show how far a sweep is, and why runs failed."""
    from foundry.display import failures, status_table
    from foundry.store import SweepFolder

    opened = SweepFolder.open(folder)
    _console().print(status_table(opened))
    for line in failures(opened):
        print(f"failed {line}")


@app.command()
def analyze(
    folders: Annotated[list[Path], typer.Argument(help="Sweep folders.", show_default=False)],
) -> None:
    """Compute the signatures of every run, compare the models, draw the plots."""
    _analyze(folders)


def _analyze(folders: Sequence[Path]) -> None:
    from analysis import analyze as analyze_folders
    from foundry.display import frame_table

    analysis = analyze_folders(folders)
    headline = analysis.headline()
    _console().print(frame_table(headline.rows, headline.columns))
    for note in analysis.notes:
        print(note)
    print(f"tables and plots in {analysis.path}")


@app.command(context_settings=_OVERRIDES)
def prompt(
    context: typer.Context,
    step: Annotated[int, typer.Option(help="The step, from 1.")] = 1,
    agent: Annotated[int, typer.Option(help="The agent, from 0.")] = 0,
    kind: Annotated[str, typer.Option(help="The kind of question, such as message or action.")] = "action",
) -> None:
    """Print the exact prompt of one call: foundry prompt model=scripted/avoid seed=3 --step 7 --agent 3.

    Later steps are reached by playing the episode with the given model, which must be scripted or cached.
    """
    from foundry.compose import compose
    from foundry.prompting import find_prompt

    composed = compose(context.args)
    if composed is None:
        return
    sweep = _sweep_of(composed)
    infos, _ = _known_models(sweep)
    found = find_prompt(sweep, infos, _existing_answers(composed), step=step, agent=agent, kind=kind)
    for message in found.messages:
        if len(found.messages) > 1:
            print(f"[{message.role}]")
        print(message.content)
    if found.assumed_silent:
        print(f"{found.assumed_silent} earlier answers are not in the cache: taken as silence", file=sys.stderr)


@app.command()
def interpret(
    text: Annotated[str, typer.Argument(help="A reply; - reads one JSON string a line from standard input.")],
    limits: Annotated[bool, typer.Option("--limits", help="Clamp to the limits of the shipped 3D worlds.")] = False,
) -> None:
    """Print what the interpreter of the 3D worlds reads from a reply, one JSON object a reply."""
    import msgspec

    from foundry.worlds.usd.reading import read_replies

    lines = sys.stdin if text == "-" else [msgspec.json.encode(text).decode()]
    for line in read_replies(lines, limited=limits):
        print(line)


@app.command()
def scene(
    what: Annotated[str, typer.Argument(help="info: what is in it; shot: a picture of it.")],
    path: Annotated[Path, typer.Argument(help="A USD file.", show_default=False)],
    out: Annotated[Path, typer.Option(help="The picture's file.")] = Path("shot.png"),
    exclude: Annotated[list[str] | None, typer.Option(help="Leave out prims: a pattern such as /World/Earth*.")] = None,
    pose: Annotated[
        str | None, typer.Option(help="x,y,z,yaw,pitch of the eye, metres and degrees; else an overview.")
    ] = None,
) -> None:
    """Show what is in a USD file, and what will not be drawn, or make a picture of it."""
    from foundry.worlds.usd.showing import describe_scene, shoot_scene

    what = what.lower()
    if what not in ("info", "shot"):
        raise not_found("Subcommand of scene", what, ("info", "shot"))
    if what == "info":
        for line in describe_scene(path, exclude or []):
            print(line)
        return
    out.write_bytes(shoot_scene(path, exclude or [], pose))
    print(f"wrote {out}")


@app.command()
def models(
    host: Annotated[str | None, typer.Option(help="A server; by default OLLAMA_HOST, else this machine.")] = None,
    pull: Annotated[str | None, typer.Option(help="First have the server fetch this model.")] = None,
) -> None:
    """List the models that the Ollama server has."""
    import asyncio

    from foundry.display import models_table
    from foundry.models.ollama_info import list_models

    hosts = host or os.environ.get("OLLAMA_HOST") or "127.0.0.1"
    if pull is not None:
        asyncio.run(_pull(pull, hosts))
    _console().print(models_table(asyncio.run(list_models(hosts))))


async def _pull(name: str, hosts: str) -> None:
    """Fetch a model; each thing the server does is one line, with its share done on a terminal."""
    from foundry.models.ollama_info import pull_model

    shown = ""
    async for now in pull_model(name, hosts):
        if now.status != shown:
            print(("\n" if shown else "") + now.status, end="", flush=True)
            shown = now.status
        if now.total and sys.stdout.isatty():
            print(f"\r{now.status} {now.completed / now.total:4.0%}", end="", flush=True)
    print()
