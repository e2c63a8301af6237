"""Commands that tell what holds, and what would go wrong."""

from __future__ import annotations

from typing import Annotated

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
from foundry.commands.sweeps import composed_here


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
        found = list(examine(composed.sweep, composed.settings, calls=calls))
    if json:
        print_json({"findings": found})
    else:
        shown = [one for one in found if one.status is not Status.OK] if is_quiet() else found
        rows = [(one.check, one.subject, one.status.value, one.found, one.advice) for one in shown]
        console().print(frame_table(rows, ("check", "of", "status", "found", "what to do")))
    failed = any(finding.status is Status.PROBLEM for finding in found)
    raise typer.Exit(EXIT_FAILED if failed else EXIT_OK)


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
