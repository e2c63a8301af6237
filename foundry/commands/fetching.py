"""The command that brings the runs of a sweep from a URL to this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXIT_FAILED, Mine, app, folder_argument


@app.command()
def fetch(
    url: Annotated[str, typer.Argument(help="The URL that was runner.remote.", show_default=False)],
    folder: Annotated[Path, folder_argument("The sweep's folder on this machine.")],
    config_dir: Mine = None,
) -> None:
    """Fetch the runs that have ended from a URL, to analyse or go on with the sweep here.

    foundry fetch s3://bucket/prefix outputs/mine
    """
    from foundry.running.remote import fetch as fetch_runs

    fetched = fetch_runs(url, folder)
    runs = fetched.folder.runs()
    ended = sum(run.ended for run in runs)
    print(f"{len(fetched.runs)} runs fetched; {ended} of {len(runs)} ended in {fetched.folder.path}")
    if fetched.damaged:
        print(f"  not whole at {url}, and left out: {', '.join(fetched.damaged)}")
        raise typer.Exit(EXIT_FAILED)
