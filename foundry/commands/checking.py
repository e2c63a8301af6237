"""The commands that check a user's own parts, and begin new ones."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import (
    EXIT_INPUT,
    EXIT_OK,
    OVERRIDES,
    AsJson,
    Mine,
    Overrides,
    app,
    console,
    given,
    is_quiet,
    only_json,
    print_json,
    say,
)


@app.command(context_settings=OVERRIDES)
def check(
    overrides: Overrides = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Check worlds, prompts, models, edits and signatures as our own are checked; the exit code is 2 where one fails.

    foundry check world=mine prompt=mine --config-dir mine

    foundry check greed world=mine --config-dir mine: the signature mine/signatures/greed.py, on runs of that world
    """
    from foundry.conformance.checking import check_asked
    from foundry.conformance.finding import failed
    from foundry.display import frame_table

    with only_json(json):
        found = check_asked(given(overrides, config_dir))
    if json:
        print_json({"findings": found})
    else:
        rows = [(one.part, one.check, one.status.value, one.note) for one in (failed(found) if is_quiet() else found)]
        console().print(frame_table(rows, ("of", "check", "status", "what to do")))
        passed = sum(one.status == "passed" for one in found)
        print(f"{passed} of {len(found)} checks passed, {len(failed(found))} failed")
    raise typer.Exit(EXIT_INPUT if failed(found) else EXIT_OK)


@app.command()
def new(
    kind: Annotated[str, typer.Argument(help="world, signature, prompt, model or policy.", show_default=False)],
    name: Annotated[str, typer.Argument(help="What it is to be called, such as bar.", show_default=False)],
    into: Annotated[Path, typer.Option("--into", "--config-dir", "-cd", help="The folder of your own parts.")] = Path(
        "mine"
    ),
) -> None:
    """Begin a part of your own: files that run as they are, with a test.

    foundry new world bar, then: foundry --config-dir mine world=bar model=scripted/random
    """
    from foundry.composing.beginning import begin

    begun = begin(kind, name, into)
    for file in begun.files:
        print(f"wrote {file}")
    say(f"try it with: {begun.try_it}")
