"""The command that shows what a sweep would do and send, and how many seeds it needs, without doing it."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from foundry.commands.analyzing import Only, Without
from foundry.commands.application import (
    OVERRIDES,
    RUN,
    AsJson,
    Mine,
    Overrides,
    app,
    check_belongs,
    console,
    folder_option,
    for_screen,
    given,
    is_verbose,
    only_json,
    print_json,
    say,
)
from foundry.commands.power import show_seeds
from foundry.commands.sweeps import composed_here, existing_answers, known_models, sweep_reach
from foundry.errors import InputError

if TYPE_CHECKING:
    from analysis.planned.reach import Reach
    from foundry.composing.compose import Composed
    from foundry.composing.planning import PlannedRepeats, PlannedRun


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def plan(
    overrides: Overrides = None,
    prompt: Annotated[bool, typer.Option("--prompt", help="Print the exact prompt of one call instead.")] = False,
    step: Annotated[int | None, typer.Option(help="With --prompt: the step, from 1, which is the default.")] = None,
    agent: Annotated[int | None, typer.Option(help="With --prompt: the agent, from 0, which is the default.")] = None,
    kind: Annotated[
        str | None,
        typer.Option(
            help="With --prompt: the kind of question, such as message; by default action, or the world's first."
        ),
    ] = None,
    pilot: Annotated[
        Path | None,
        folder_option("Also say how many seeds are needed, judged by this sweep or probe; alone without OVERRIDES."),
    ] = None,
    difference: Annotated[
        float | None,
        typer.Option(help="With --pilot: what is to be found, in the measure's unit; else what the pilot shows."),
    ] = None,
    power: Annotated[float | None, typer.Option(help="With --pilot: probability to find it, by default 0.8.")] = None,
    measure: Annotated[
        str | None,
        typer.Option(help="With --pilot: one measure, else the headlines; of a probe one model or edit."),
    ] = None,
    looks: Annotated[
        str | None,
        typer.Option(help="With --pilot: numbers of seeds at which will be tested, such as 8,12,18: what comes of it."),
    ] = None,
    only: Only = None,
    without: Without = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show what a sweep would do, and what it would send, without doing it.

    Takes what `foundry` takes: foundry plan -m model=llama3.2 seed=0-9; what is in output.dir=DIR is counted as done.

    foundry plan --prompt model=scripted/avoid seed=3 --step 7 --agent 3: to reach the step, plays the episode with the
    model, which must be scripted or cached

    foundry plan --pilot outputs/pilot -m model=llama3.2 seed=0-19: also how many seeds the declared measures need
    """
    if not prompt:
        check_belongs("--prompt", {"step": step, "agent": agent, "kind": kind})
    if pilot is None:
        judging = {"difference": difference, "power": power, "measure": measure, "looks": looks}
        check_belongs("--pilot DIR", {**judging, "only": only or None, "without": without or None})
    else:
        if prompt or json:
            raise InputError("--pilot prints tables of seeds: leave out --prompt and --json.")
        show_seeds(
            pilot, difference=difference, power=0.8 if power is None else power, measure=measure, looks=looks or "",
            only=only or (), without=without or (),
        )  # fmt: skip
        if not overrides:
            return
    composed = composed_here(given(overrides, config_dir))
    if composed is None:
        return
    if prompt:
        _print_prompt(composed, 1 if step is None else step, agent or 0, kind, json=json)
    else:
        _print_calls(composed, json=json)


def _print_prompt(composed: Composed, step: int, agent: int, kind: str | None, *, json: bool) -> None:
    """Print the exact prompt of one call."""
    from foundry.composing.prompting import find_prompt

    sweep = composed.sweep
    with only_json(json):
        infos, _ = known_models(sweep)
        call = find_prompt(sweep, infos, existing_answers(composed), step=step, agent=agent, kind=kind)
    if json:
        print_json({"messages": call.messages, "taken_as_silence": call.assumed_silent})
        return
    for message in call.messages:
        if len(call.messages) > 1:
            print(f"[{message.role}]")
        print(for_screen(message.content))
    if call.assumed_silent:
        print(f"{call.assumed_silent} earlier answers are not in the cache: taken as silence", file=sys.stderr)


def _print_calls(composed: Composed, *, json: bool) -> None:
    """Print the runs of a sweep, the calls that it would send, their time, and what its tests can find."""
    from foundry.composing.planning import plan as plan_runs
    from foundry.composing.planning import repeats
    from foundry.composing.preflight import missing_arms, notes_of
    from foundry.doctor.hours import prompt_tokens, time_line
    from foundry.doctor.speeds import speeds
    from foundry.storing.determinism import SETTING, repeats_of
    from foundry.storing.growing import growth
    from foundry.storing.store import SweepFolder

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
        if reach is not None and not note:
            command = shlex.join(composed.asked)
            say(f"next: foundry {command}; for a claim, before it: foundry preregister {command} --family MEASURE")


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
    reach_found = reach and {**asdict(reach), "effect": reach.effect}
    sums = {"to_send": sum(one.to_send for one in planned), "prompt_tokens": tokens}
    print_json({"runs": runs, **sums, "determinism": twice, "reach": reach_found, "notes": notes})


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
