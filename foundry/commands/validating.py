"""The command that holds worlds against closed forms."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXIT_FAILED, EXIT_OK, Mine, app, console


@app.command()
def validate(
    worlds: Annotated[
        list[str] | None, typer.Argument(help="Worlds; by default all of which something is known.", show_default=False)
    ] = None,
    write: Annotated[Path | None, typer.Option(help="Write the page here, as Markdown.")] = None,
    config_dir: Mine = None,
) -> None:
    """Play scripted policies whose results are known in closed form; the exit code is 3 where one is not met."""
    from analysis.validation.facts import all_facts
    from foundry.display import frame_table
    from foundry.validating.page import COLUMNS, page, row
    from foundry.validating.playing import hold

    known = list(all_facts(tuple(worlds or ())))
    with tempfile.TemporaryDirectory(prefix="foundry-validate-") as folder:
        held = [one for facts in known for one in hold(facts, Path(folder), config_dir or ())]
    console().print(frame_table(map(row, held), COLUMNS))
    if write is not None:
        write.write_text(page(held), encoding="utf-8", newline="\n")
        print(f"wrote {write}")
    missed = [one for one in held if not one.holds]
    print(f"{len(held) - len(missed)} of {len(held)} closed forms hold")
    raise typer.Exit(EXIT_FAILED if missed else EXIT_OK)
