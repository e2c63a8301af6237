"""Commands about models and what they are asked."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from foundry.commands.application import OVERRIDES, Mine, Overrides, app, console, for_screen, given
from foundry.commands.sweeps import composed_here, existing_answers, known_models


@app.command(context_settings=OVERRIDES)
def prompt(
    overrides: Overrides = None,
    step: Annotated[int, typer.Option(help="The step, from 1.")] = 1,
    agent: Annotated[int, typer.Option(help="The agent, from 0.")] = 0,
    kind: Annotated[
        str | None, typer.Option(help="The kind of question, such as message; by default action, or the world's first.")
    ] = None,
    config_dir: Mine = None,
) -> None:
    """Print the exact prompt of one call: foundry prompt model=scripted/avoid seed=3 --step 7 --agent 3.

    Later steps are reached by playing the episode with the given model, which must be scripted or cached.
    """
    from foundry.composing.prompting import find_prompt

    composed = composed_here(given(overrides, config_dir))
    if composed is None:
        return
    sweep = composed.sweep
    infos, _ = known_models(sweep)
    found = find_prompt(sweep, infos, existing_answers(composed), step=step, agent=agent, kind=kind)
    for message in found.messages:
        if len(found.messages) > 1:
            print(f"[{message.role}]")
        print(for_screen(message.content))
    if found.assumed_silent:
        print(f"{found.assumed_silent} earlier answers are not in the cache: taken as silence", file=sys.stderr)


@app.command()
def models(
    host: Annotated[str | None, typer.Option(help="A server; by default OLLAMA_HOST, else this machine.")] = None,
    pull: Annotated[str | None, typer.Option(help="First have the server fetch this model.")] = None,
    config_dir: Mine = None,
) -> None:
    """List the models that the Ollama server has."""
    import asyncio

    from foundry.display import models_table
    from foundry.models.ollama.info import list_models

    hosts = host or os.environ.get("OLLAMA_HOST") or "127.0.0.1"
    if pull is not None:
        asyncio.run(_pull(pull, hosts))
    console().print(models_table(asyncio.run(list_models(hosts))))


async def _pull(name: str, hosts: str) -> None:
    """Fetch a model; each thing the server does is one line, with its share done on a terminal."""
    from foundry.models.ollama.info import pull_model

    shown = ""
    async for now in pull_model(name, hosts):
        if now.status != shown:
            print(("\n" if shown else "") + for_screen(now.status), end="", flush=True)
            shown = now.status
        if now.total and sys.stdout.isatty():
            print(f"\r{for_screen(now.status)} {now.completed / now.total:4.0%}", end="", flush=True)
    print()
