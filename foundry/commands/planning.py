"""Commands that you use before a sweep: doctor, config and plan."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import EXIT_FAILED, EXIT_OK, EXTEND, OVERRIDES, RUN, app
from foundry.commands.options import AsJson, Mine, Only, Overrides, Without, check_belongs, folder_path, given
from foundry.commands.power import show_labels, show_seeds
from foundry.commands.printing import console, for_screen, is_quiet, is_verbose, only_json, print_json, say
from foundry.commands.sweeps import composed_here, existing_answers, known_models, sweep_reach
from foundry.errors import InputError
from foundry.expansion import Sweep, settings_key
from foundry.storing.determinism import SETTING, repeats_of
from foundry.storing.growing import growth
from foundry.storing.store import SweepFolder
from foundry.texts import counted, one_line

if TYPE_CHECKING:
    from rich.table import Table

    from analysis.planned.reach import Reach
    from foundry.composing.compose import Composed
    from foundry.composing.planning import PlannedRepeats, PlannedRun
    from foundry.doctor import Finding
    from foundry.models.ollama.info import InstalledModel

_SHOWN = 60
"""Maximum number of characters of a setting's value in the table of `foundry config`."""


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def doctor(
    overrides: Overrides = None,
    json: AsJson = False,
    calls: Annotated[bool, typer.Option(help="Measure every model with about twenty calls.")] = True,
    pull: Annotated[
        str | None,
        typer.Option(help="Let the Ollama servers download this model and list their models, and check nothing."),
    ] = None,
    config_dir: Mine = None,
) -> None:
    """Find problems of servers, models and disk before a sweep.

    Checks context lengths, parallel slots of servers, seeds and the drawing of 3D worlds. Lists the models of Ollama
    servers. Takes the same overrides as foundry:

    foundry doctor -m model=qwen3:4b,llama3.2 seed=0-9

    foundry doctor --pull llama3.2
    """
    import asyncio

    from foundry.display import models_table
    from foundry.doctor import Status, examine

    composed = composed_here(given(overrides, config_dir))
    if composed is None:
        return
    hosts = _ollama_hosts(composed.sweep)
    if pull is not None:
        with only_json(json):
            asyncio.run(_pull(pull, hosts))
    with only_json(json):
        findings = (
            [] if pull is not None
            else [*examine(composed.sweep, composed.settings, calls=calls), *_tests(composed.sweep)]
        )  # fmt: skip
        installed, unlisted = asyncio.run(_installed(hosts))
        failed_servers = {finding.subject for finding in findings if finding.check == "server"}
        findings += [finding for finding in unlisted if finding.subject not in failed_servers]
    if json:
        print_json({"findings": findings, "models": installed})
    else:
        shown = [finding for finding in findings if finding.status is not Status.OK] if is_quiet() else findings
        if shown:
            console().print(_findings_table(shown, console().width))
        if installed and not is_quiet():
            console().print(models_table(installed, console().width))
    failed = any(finding.status is Status.PROBLEM for finding in findings)
    if composed.asked and not (failed or json or pull):
        say(f"next: foundry plan {shlex.join(composed.asked)}")
    raise typer.Exit(EXIT_FAILED if failed else EXIT_OK)


def _findings_table(findings: Sequence[Finding], width: int) -> Table:
    """Return the table of findings; on a narrow terminal, advice stands below what was found."""
    from foundry.display import WIDE, frame_table

    rows = [[check.check, check.subject, check.status.value, check.found, check.advice] for check in findings]
    if width >= WIDE:
        return frame_table(rows, ("check", "of", "status", "found", "what to do"))
    below = [[*row, result + (f"\n-> {advice}" if advice else "")] for *row, result, advice in rows]
    return frame_table(below, ("check", "of", "status", "found -> what to do"))


def _ollama_hosts(sweep: Sweep) -> list[str]:

    from foundry.models.ollama.ollama_model import OllamaModel
    from foundry.running.build import build, members_of

    configs = {settings_key(condition.config["model"]): condition.config["model"] for condition in sweep.conditions}
    models = [model for config in configs.values() for model in members_of(build(config))]
    return list(dict.fromkeys(host for model in models if isinstance(model, OllamaModel) for host in model.hosts))


async def _installed(hosts: Sequence[str]) -> tuple[list[InstalledModel], list[Finding]]:
    from foundry.doctor import Finding, Status
    from foundry.models.ollama.info import list_models

    models: list[InstalledModel] = []
    unlisted: list[Finding] = []
    for host in hosts:
        try:
            models += await list_models(host)
        except InputError as error:
            result = f"the server does not list its models: {error.problem}"
            unlisted.append(Finding("models", host, Status.SKIPPED, result, error.advice))
    return models, unlisted


async def _pull(name: str, hosts: Sequence[str]) -> None:
    """Let servers download a model; print a line for each step of a download, on a terminal with its progress."""
    from foundry.models.ollama.info import pull_model

    if not hosts:
        raise InputError(f"--pull {name} needs an Ollama server, and these models use none. Leave out model=.")
    status = ""
    async for progress in pull_model(name, hosts):
        if progress.status != status:
            print(("\n" if status else "") + for_screen(progress.status), end="", flush=True)
            status = progress.status
        if progress.total and sys.stdout.isatty():
            share = progress.completed / progress.total
            print(f"\r{for_screen(progress.status)} {share:4.0%}", end="", flush=True)
    print()


def _tests(sweep: Sweep) -> Iterator[Finding]:

    from foundry.doctor import Finding, Status

    reach = sweep_reach(sweep)
    if reach is not None:
        advice = "" if reach.is_enough else f"Ask for {reach.fewest} seeds or more."
        yield Finding("tests", "this sweep", Status.OK if reach.is_enough else Status.WARNING, reach.line(), advice)


@app.command(rich_help_panel=EXTEND)
def config(
    overrides: Annotated[
        list[str] | None,
        typer.Argument(metavar="SETTINGS", help="Settings to show, such as model.server; and overrides."),
    ] = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show every setting with its value and origin.

    A value comes from the command line, the environment, your own file or the default. The first table shows the
    settings that affect answers. The second table shows the settings for where and how a sweep runs.

    foundry config cache model.server
    """
    from foundry import paths
    from foundry.composing.compose import compose
    from foundry.composing.defaults import read_defaults
    from foundry.composing.shown import chosen, decides_answers, environment, settings_of
    from foundry.display import frame_table

    file, wanted = paths.user_config_file(), [word for word in overrides or () if "=" not in word]
    argv = given([word for word in overrides or () if "=" in word], config_dir)
    composed = compose(argv, read_defaults())
    assert composed is not None, "Hydra itself only answers flags, and these have no '='"
    settings_shown = chosen(settings_of(composed), wanted)
    variables = [] if wanted else list(environment())
    if json:
        print_json({"file": file, "exists": file.is_file(), "settings": settings_shown, "environment": variables})
        return
    tables = {
        "decides answers": [setting for setting in settings_shown if decides_answers(setting.setting)],
        "where and how": [setting for setting in settings_shown if not decides_answers(setting.setting)],
        "environment": variables,
    }
    for title, settings in tables.items():
        if settings:
            rows = [(setting.setting, _shown(setting.value), setting.origin) for setting in settings]
            console().print(frame_table(rows, (title, "value", "from")))
    say(f"your own defaults: {file}" + ("" if file.is_file() else " (not there)"))


def _shown(value: object) -> str:
    in_yaml = "null" if value is None else str(value).lower() if isinstance(value, bool) else value
    text = one_line(in_yaml)
    return text if is_verbose() or len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


Pilot = Annotated[
    Path | None,
    typer.Option(
        help="Also print how many seeds the measures need, given this sweep or probe; without OVERRIDES only this.",
        metavar="DIR",
        parser=folder_path,
    ),
]
Kind = Annotated[
    str | None,
    typer.Option(help="With --prompt: kind of the question, such as message; default: action, or the first kind."),
]
ToTime = Annotated[
    bool, typer.Option("--time", help="Send about twenty calls to each server to estimate hours, tokens and cost.")
]
LabelToPlan = Annotated[
    str | None,
    typer.Option(help="With --pilot: also print how many texts people must label to find a difference in this label."),
]
Looks = Annotated[
    str | None, typer.Option(help="With --pilot: the power of interim looks after so many seeds, such as 8,12,18.")
]


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def plan(
    overrides: Overrides = None,
    prompt: Annotated[bool, typer.Option("--prompt", help="Instead, print the exact prompt of one call.")] = False,
    step: Annotated[int | None, typer.Option(help="With --prompt: the step, from 1; default 1.")] = None,
    agent: Annotated[int | None, typer.Option(help="With --prompt: the agent, from 0; default 0.")] = None,
    kind: Kind = None,
    time: ToTime = False,
    pilot: Pilot = None,
    difference: Annotated[
        float | None,
        typer.Option(help="With --pilot: the difference to find, in the measure's unit; default: the pilot's."),
    ] = None,
    power: Annotated[
        float | None, typer.Option(help="With --pilot: the probability of finding the difference; default 0.8.")
    ] = None,
    measure: Annotated[
        str | None,
        typer.Option(help="With --pilot: one measure; in a probe, one model or edit; default: the main measures."),
    ] = None,
    looks: Looks = None,
    labels: LabelToPlan = None,
    only: Only = None,
    without: Without = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show the runs, calls and hours of a sweep before it runs.

    foundry plan -m model=llama3.2 seed=0-9: takes the same overrides as foundry; runs in output.dir=DIR count as done

    foundry plan --prompt model=scripted/avoid seed=3 --step 7 --agent 3: print the prompt of one call; plays the
    episode up to that step, so the model must be scripted or its answers cached

    foundry plan --pilot outputs/pilot -m model=llama3.2 seed=0-19: also print how many seeds the measures need
    """
    if not prompt:
        check_belongs("--prompt", {"step": step, "agent": agent, "kind": kind})
    if pilot is None:
        judging = {"difference": difference, "power": power, "measure": measure, "looks": looks, "labels": labels}
        check_belongs("--pilot DIR", {**judging, "only": only or None, "without": without or None})
    else:
        if prompt or json:
            raise InputError("--pilot prints only tables of seeds. Leave out --prompt and --json.")
        show_seeds(
            pilot, difference=difference, power=0.8 if power is None else power, measure=measure, looks=looks or "",
            only=only or (), without=without or (),
        )  # fmt: skip
        if labels is not None:
            show_labels(pilot, labels, 0.8 if power is None else power)
        if not overrides:
            return
    composed = composed_here(given(overrides, config_dir))
    if composed is None:
        return
    if prompt:
        _print_prompt(composed, 1 if step is None else step, agent or 0, kind, json=json)
    else:
        _print_calls(composed, json=json, time=time)


def _print_prompt(composed: Composed, step: int, agent: int, kind: str | None, *, json: bool) -> None:

    from foundry.composing.planning import find_prompt

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
        missing = f"{call.assumed_silent} earlier answers are not in the cache"
        print(f"{missing}; in this prompt, each of them counts as silence", file=sys.stderr)


def _print_calls(composed: Composed, *, json: bool, time: bool) -> None:

    from foundry.composing.identifying import identified
    from foundry.composing.planning import plan as plan_runs
    from foundry.composing.planning import repeats
    from foundry.composing.preflight import missing_arms, notes_of
    from foundry.doctor.hours import cost_of, prompt_tokens, remember_speed, speeds, time_line
    from foundry.doctor.timing import timed

    sweep = composed.sweep
    folder = Path(composed.settings["output"]["dir"]) if composed.settings["output"]["dir"] else None
    there = SweepFolder.open(folder) if folder and folder.exists() else None
    growing = [] if there is None else growth(there.sweep, sweep).notes(folder)
    with only_json(json):
        infos, note = known_models(sweep)
    folders = {} if there is None else {run.id: run for run in there.runs()}
    cache = composed.settings["cache"]["path"]
    infos = identified(sweep, infos, cache, ask=False)
    planned = plan_runs(sweep, infos, existing_answers(composed), folders)
    by_model = prompt_tokens(sweep, planned)
    tokens = None if by_model is None else by_model.total()
    cost = cost_of(sweep, planned, by_model)
    with only_json(json):
        estimates = [*timed(sweep, planned)] if time else []
    for estimate in estimates:
        remember_speed(cache, estimate.model, estimate.per_call_s)
    hours = time_line(planned, speeds(cache))
    reach = sweep_reach(sweep)
    twice = repeats(sweep, planned, composed.settings[SETTING], () if there is None else repeats_of(there))
    notes = [*growing, *notes_of(sweep), *missing_arms(sweep), *filter(None, [note])]
    if json:
        _print_plan(planned, twice, notes, {"prompt_tokens": tokens, "cost": cost, "timed": estimates}, reach)
    else:
        size = f"prompts: about {_rounded(tokens)} tokens" if tokens else ""
        reachable = reach.line() if reach is not None else ""
        costs = "" if cost is None else cost.line()
        timings = [f"timed: {estimate.model}: {estimate.line()}" for estimate in estimates]
        _show_plan(planned, twice, [*filter(None, [size, hours, *timings, costs, reachable]), *notes])
        if reach is not None and not note:
            command = shlex.join(composed.asked)
            say(f"next: foundry {command}")
            say(f"to make a claim, first: foundry preregister {command} --family MEASURE")


def _print_plan(
    planned: Sequence[PlannedRun],
    twice: PlannedRepeats,
    notes: Sequence[str],
    size: Mapping[str, Any],
    reach: Reach | None,
) -> None:
    runs = [
        {"run": run.run.id, "model": run.model, "prompt": run.prompt, "world": run.world, "seed": run.run.seed,
         "calls": run.calls, "served": run.served, "cached": run.cached, "to_send": run.to_send,
         "complete": run.complete, "new": run.new}
        for run in planned
    ]  # fmt: skip
    reach_found = reach and {**asdict(reach), "effect": reach.effect}
    sums = {"to_send": sum(run.to_send for run in planned), **size}
    print_json({"runs": runs, **sums, "determinism": twice, "reach": reach_found, "notes": notes})


def _show_plan(planned: Sequence[PlannedRun], twice: PlannedRepeats, notes: Sequence[str]) -> None:
    from foundry.display import plan_table, runs_table

    console().print(plan_table(planned))
    if is_verbose():
        console().print(runs_table(planned))
    to_send = sum(run.to_send for run in planned)
    complete = sum(run.complete for run in planned)
    print(f"{counted(len(planned), 'run')}, {complete} complete; at most {to_send:,} calls would be sent")
    if twice.again:
        say(f"determinism check: at most {twice.again + twice.beside:,} calls would be repeated at the end")
    for line in notes:
        say(line)


def _rounded(count: int) -> str:
    digits = len(str(count)) - 2
    return f"{round(count, -digits) if digits > 0 else count:,}"
