"""The command that tells what would go wrong."""

from __future__ import annotations

from typing import Annotated

import typer

from foundry.commands.application import EXIT_FAILED, EXIT_OK, OVERRIDES, app, console


@app.command(context_settings=OVERRIDES)
def doctor(
    context: typer.Context,
    json: Annotated[bool, typer.Option("--json", help="One JSON object a finding, instead of the table.")] = False,
    calls: Annotated[bool, typer.Option(help="Send about twenty calls to every model to measure it.")] = True,
) -> None:
    """Tell what would go wrong with a sweep: servers, models, context, parallel slots, seeds, drawing, disk.

    Takes what `foundry` takes: foundry doctor -m model=qwen3:4b,llama3.2 seed=0-9
    """
    import msgspec

    from foundry.commands.sweeps import sweep_of
    from foundry.composing.compose import compose
    from foundry.display import frame_table
    from foundry.doctor import Status, examine

    composed = compose(context.args)
    if composed is None:
        return
    found = []
    for finding in examine(sweep_of(composed), composed.settings, calls=calls):
        found.append(finding)
        if json:
            print(msgspec.json.encode(finding).decode())
    if not json:
        rows = [(one.check, one.subject, one.status.value, one.found, one.advice) for one in found]
        console().print(frame_table(rows, ("check", "of", "status", "found", "what to do")))
    failed = any(finding.status is Status.PROBLEM for finding in found)
    raise typer.Exit(EXIT_FAILED if failed else EXIT_OK)
