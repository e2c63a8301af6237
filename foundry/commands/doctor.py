"""Commands that tell what holds, and what would go wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from foundry.commands.application import (
    EXIT_FAILED,
    EXIT_OK,
    OVERRIDES,
    AsJson,
    Mine,
    Overrides,
    app,
    console,
    given,
    is_quiet,
    is_verbose,
    only_json,
    print_json,
    say,
)
from foundry.commands.sweeps import composed_here, existing_answers, known_models, sweep_reach

if TYPE_CHECKING:
    from analysis.planned.reach import Reach
    from foundry.composing.planning import PlannedRepeats, PlannedRun
    from foundry.doctor import Finding
    from foundry.expansion import Sweep


@app.command(context_settings=OVERRIDES)
def doctor(
    overrides: Overrides = None,
    json: AsJson = False,
    calls: Annotated[bool, typer.Option(help="Send about twenty calls to every model to measure it.")] = True,
    config_dir: Mine = None,
) -> None:
    """Tell what would go wrong with a sweep: servers, models, context, parallel slots, seeds, drawing, disk.

    Takes what `foundry` takes: foundry doctor -m model=qwen3:4b,llama3.2 seed=0-9
    """
    from foundry.display import frame_table
    from foundry.doctor import Status, examine

    composed = composed_here(given(overrides, config_dir))
    if composed is None:
        return
    with only_json(json):
        found = [*examine(composed.sweep, composed.settings, calls=calls), *_tests(composed.sweep)]
    if json:
        print_json({"findings": found})
    else:
        shown = [one for one in found if one.status is not Status.OK] if is_quiet() else found
        rows = [(one.check, one.subject, one.status.value, one.found, one.advice) for one in shown]
        console().print(frame_table(rows, ("check", "of", "status", "found", "what to do")))
    failed = any(finding.status is Status.PROBLEM for finding in found)
    raise typer.Exit(EXIT_FAILED if failed else EXIT_OK)


def _tests(sweep: Sweep) -> Iterator[Finding]:
    """Yield what the tests of a sweep can find."""
    from foundry.doctor import Finding, Status

    reach = sweep_reach(sweep)
    if reach is not None:
        advice = "" if reach.is_enough else f"Ask for {reach.fewest} seeds or more."
        yield Finding("tests", "this sweep", Status.OK if reach.is_enough else Status.WARNING, reach.line(), advice)


@app.command(context_settings=OVERRIDES)
def plan(
    overrides: Overrides = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show what a sweep would do, and what it would send, without doing it.

    Takes what `foundry` takes: foundry plan -m model=llama3.2 seed=0-9; what is in output.dir=DIR is counted as done.
    """
    from foundry.composing.planning import plan as plan_runs
    from foundry.composing.planning import repeats
    from foundry.composing.preflight import missing_arms, notes_of
    from foundry.doctor.hours import prompt_tokens, time_line
    from foundry.doctor.speeds import speeds
    from foundry.storing.determinism import SETTING, repeats_of
    from foundry.storing.growing import growth
    from foundry.storing.store import SweepFolder

    composed = composed_here(given(overrides, config_dir))
    if composed is None:
        return
    sweep = composed.sweep
    asked = Path(composed.settings["output"]["dir"]) if composed.settings["output"]["dir"] else None
    there = SweepFolder.open(asked) if asked and asked.exists() else None
    growing = [] if there is None else growth(there.sweep, sweep).notes(asked)
    with only_json(json):
        infos, note = known_models(sweep)
    folders = {} if there is None else {run.id: run for run in there.runs()}
    cache = composed.settings["cache"]["path"]
    planned = plan_runs(sweep, infos, existing_answers(composed), folders)
    tokens = prompt_tokens(sweep, planned)
    time = time_line(planned, speeds(cache))
    reach = sweep_reach(sweep)
    twice = repeats(sweep, planned, composed.settings[SETTING], () if there is None else repeats_of(there))
    notes = [*growing, *notes_of(sweep), *missing_arms(sweep), *filter(None, [note])]
    if json:
        _print_plan(planned, twice, notes, tokens, reach)
    else:
        size = f"prompts: about {_rounded(tokens)} tokens" if tokens else ""
        found = reach.line() if reach is not None else ""
        _show_plan(planned, twice, [*filter(None, [size, time, found]), *notes])


def _print_plan(
    planned: Sequence[PlannedRun],
    twice: PlannedRepeats,
    notes: Sequence[str],
    tokens: int | None,
    reach: Reach | None,
) -> None:
    runs = [
        {"run": one.run.id, "model": one.model, "prompt": one.prompt, "world": one.world, "seed": one.run.seed,
         "calls": one.calls, "served": one.served, "cached": one.cached, "to_send": one.to_send,
         "complete": one.complete, "new": one.new}
        for one in planned
    ]  # fmt: skip
    sums = {"to_send": sum(one.to_send for one in planned), "prompt_tokens": tokens}
    print_json({"runs": runs, **sums, "determinism": twice, "reach": reach, "notes": notes})


def _show_plan(planned: Sequence[PlannedRun], twice: PlannedRepeats, notes: Sequence[str]) -> None:
    from foundry.display import plan_table

    console().print(plan_table(planned, None) if is_verbose() else plan_table(planned))
    to_send = sum(one.to_send for one in planned)
    complete = sum(one.complete for one in planned)
    print(f"{len(planned)} runs, {complete} complete; at most {to_send:,} calls would be sent")
    if twice.again:
        say(f"determinism: at most {twice.again + twice.beside:,} recorded calls would be made again at the end")
    for line in notes:
        say(line)


def _rounded(count: int) -> str:
    """Return a number with two digits that matter."""
    digits = len(str(count)) - 2
    return f"{round(count, -digits) if digits > 0 else count:,}"


_SHOWN = 60
"""Characters of a value in the table."""


@app.command()
def config(
    overrides: Annotated[
        list[str] | None, typer.Argument(help="Settings to show, such as model.server, and overrides.")
    ] = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show every setting with its value and where it comes from: command line, environment, your own file or default.

    Defaults of your own stand in a file that it names: foundry config cache model.server
    """
    from foundry import paths
    from foundry.composing.compose import compose
    from foundry.composing.defaults import read_defaults
    from foundry.composing.origins import chosen, environment, settings_of
    from foundry.display import frame_table

    file, wanted = paths.user_config_file(), [one for one in overrides or () if "=" not in one]
    argv = given([one for one in overrides or () if "=" in one], config_dir)
    composed = compose(argv, read_defaults(argv))
    assert composed is not None, "only flags, which are refused, are answered by Hydra itself"
    found = chosen(settings_of(composed), wanted)
    variables = [] if wanted else list(environment())
    if json:
        print_json({"file": file, "exists": file.is_file(), "settings": found, "environment": variables})
        return
    rows = [(one.setting, _shown(one.value), one.origin) for one in [*found, *variables]]
    console().print(frame_table(rows, ("setting", "value", "from")))
    say(f"your own defaults: {file}" + ("" if file.is_file() else " (not there)"))


def _shown(value: object) -> str:
    text = " ".join(str(value).split())
    return text if is_verbose() or len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
