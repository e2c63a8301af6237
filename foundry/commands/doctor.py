"""Commands that tell what would go wrong, and which settings hold."""

from __future__ import annotations

import asyncio
import shlex
import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from foundry.commands.application import (
    EXIT_FAILED,
    EXIT_OK,
    EXTEND,
    OVERRIDES,
    RUN,
    AsJson,
    Mine,
    Overrides,
    app,
    console,
    for_screen,
    given,
    is_quiet,
    is_verbose,
    only_json,
    print_json,
    say,
)
from foundry.commands.sweeps import composed_here, sweep_reach
from foundry.errors import InputError

if TYPE_CHECKING:
    from foundry.doctor import Finding
    from foundry.expansion import Sweep
    from foundry.models.ollama.info import InstalledModel


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def doctor(
    overrides: Overrides = None,
    json: AsJson = False,
    calls: Annotated[bool, typer.Option(help="Send about twenty calls to every model to measure it.")] = True,
    pull: Annotated[
        str | None, typer.Option(help="Have the Ollama servers fetch this model and list theirs; examine nothing.")
    ] = None,
    config_dir: Mine = None,
) -> None:
    """Tell what would go wrong with a sweep: servers, models, context, parallel slots, seeds, drawing, disk.

    Lists the models of its Ollama servers. Takes what `foundry` takes:

    foundry doctor -m model=qwen3:4b,llama3.2 seed=0-9

    foundry doctor --pull llama3.2
    """
    from foundry.display import frame_table, models_table
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
        findings += unlisted
    if json:
        print_json({"findings": findings, "models": installed})
    else:
        shown = [one for one in findings if one.status is not Status.OK] if is_quiet() else findings
        rows = [(one.check, one.subject, one.status.value, one.found, one.advice) for one in shown]
        if rows:
            console().print(frame_table(rows, ("check", "of", "status", "found", "what to do")))
        if installed and not is_quiet():
            console().print(models_table(installed))
    failed = any(finding.status is Status.PROBLEM for finding in findings)
    if composed.asked and not (failed or json or pull):
        say(f"next: foundry plan {shlex.join(composed.asked)}")
    raise typer.Exit(EXIT_FAILED if failed else EXIT_OK)


def _ollama_hosts(sweep: Sweep) -> list[str]:
    """Return the Ollama servers of a sweep's models, each once."""
    from foundry.expansion import settings_key
    from foundry.models.ollama.model import OllamaModel
    from foundry.running.build import build, members_of

    configs = {settings_key(condition.config["model"]): condition.config["model"] for condition in sweep.conditions}
    models = [model for config in configs.values() for model in members_of(build(config))]
    return list(dict.fromkeys(host for model in models if isinstance(model, OllamaModel) for host in model.hosts))


async def _installed(hosts: Sequence[str]) -> tuple[list[InstalledModel], list[Finding]]:
    """Return the models of servers, and a finding for each server that does not list its own."""
    from foundry.doctor import Finding, Status
    from foundry.models.ollama.info import list_models

    models: list[InstalledModel] = []
    unlisted: list[Finding] = []
    for host in hosts:
        try:
            models += await list_models(host)
        except InputError as error:
            unlisted.append(Finding("models", host, Status.SKIPPED, f"the server does not list its models: {error}"))
    return models, unlisted


async def _pull(name: str, hosts: Sequence[str]) -> None:
    """Fetch a model; each step of a server is one line, on a terminal with the share that is done."""
    from foundry.models.ollama.info import pull_model

    if not hosts:
        raise InputError(f"--pull {name} needs an Ollama server, and no model of this sweep has one: leave out model=.")
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
    """Yield what the tests of a sweep can find."""
    from foundry.doctor import Finding, Status

    reach = sweep_reach(sweep)
    if reach is not None:
        advice = "" if reach.is_enough else f"Ask for {reach.fewest} seeds or more."
        yield Finding("tests", "this sweep", Status.OK if reach.is_enough else Status.WARNING, reach.line(), advice)


_SHOWN = 60
"""Characters of a value in the table."""


@app.command(rich_help_panel=EXTEND)
def config(
    overrides: Annotated[
        list[str] | None, typer.Argument(help="Settings to show, such as model.server, and overrides.")
    ] = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show every setting with its value and where it comes from: command line, environment, your own file or default.

    The first table has the settings that answers depend on, the second those that say where and how a sweep is run.

    Defaults of your own stand in a file that it names: foundry config cache model.server
    """
    from foundry import paths
    from foundry.composing.compose import compose
    from foundry.composing.defaults import read_defaults
    from foundry.composing.origins import chosen, decides_answers, environment, settings_of
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
    tables = {
        "decides answers": [one for one in found if decides_answers(one.setting)],
        "where and how": [one for one in found if not decides_answers(one.setting)],
        "environment": variables,
    }
    for title, settings in tables.items():
        if settings:
            rows = [(one.setting, _shown(one.value), one.origin) for one in settings]
            console().print(frame_table(rows, (title, "value", "from")))
    say(f"your own defaults: {file}" + ("" if file.is_file() else " (not there)"))


def _shown(value: object) -> str:
    text = " ".join(str(value).split())
    return text if is_verbose() or len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
