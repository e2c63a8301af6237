"""The command that shows recorded runs in a browser."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import Mine, Trusted, app
from foundry.errors import InputError


@app.command()
def view(
    folder: Annotated[
        Path | None,
        typer.Argument(
            help="A sweep's folder, or a folder of sweeps; by default the newest sweep in outputs/.", show_default=False
        ),
    ] = None,
    export: Annotated[Path | None, typer.Option(help="Write the page as files into this folder instead.")] = None,
    host: Annotated[
        str, typer.Option(help="Address to listen on; others than this machine's let others in.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port to listen on; 0 takes a free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the browser.")] = True,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Look at what happened: runs step by step, prompts and replies, runs side by side."""
    root = folder if folder is not None else _newest()
    if export is not None:
        _export(root, export, trust_targets or ())
    else:
        _serve(root, host=host, port=port, browser=browser, trusted=trust_targets or ())


def check_view(asked: object) -> None:
    """Refuse a setting `view` that is not known, before anything is written.

    Raises:
        InputError: it is neither null nor live.
    """
    if asked not in (None, "live"):
        raise InputError(f"view={asked} is neither null nor live: add view=live to watch, or look with: foundry view.")


@contextmanager
def watched(folder: Path, asked: object) -> Iterator[None]:
    """Serve the page of a sweep while it runs, if asked."""
    if asked is None:
        yield
        return
    from foundry.viewer.live import serve_live
    from foundry.viewer.server import open_in_browser

    with serve_live(folder) as url:
        print(f"watch at {url}", flush=True)
        open_in_browser(url)
        yield


def _newest() -> Path:
    from foundry.storing.store import sweeps_in

    outputs = Path("outputs")
    if not outputs.is_dir():
        raise InputError("There is no folder outputs/ here: name a sweep's folder, as in foundry view outputs/<sweep>.")
    return sweeps_in(outputs)[0]


def _export(root: Path, out: Path, trusted: Sequence[str]) -> None:
    from foundry.viewer.export import export

    exported = export(root, out, trusted)
    print(f"{exported.runs} runs in {exported.files} files, {exported.size / 1e6:,.1f} MB: open {exported.page}")


def _serve(root: Path, *, host: str, port: int, browser: bool, trusted: Sequence[str]) -> None:
    from foundry.viewer.server import ViewServer, is_loopback, open_in_browser

    server = ViewServer(root, host=host, port=port, trusted=trusted)
    if not is_loopback(host):
        print(f"Warning: whoever reaches {host} can read every prompt and reply in '{root}'.")
    print(f"{root} is shown at {server.url} (Ctrl-C ends)", flush=True)
    if browser:
        open_in_browser(server.url)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        print("ended")
    finally:
        server.server_close()
