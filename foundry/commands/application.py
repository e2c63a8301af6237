"""What all commands share: the Typer application, exit codes, the console."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from foundry import __version__
from foundry.errors import InputError
from foundry.texts import visible, without_secrets

if TYPE_CHECKING:
    from rich.console import Console

EXIT_OK, EXIT_INPUT, EXIT_FAILED, EXIT_INTERRUPTED = 0, 2, 3, 130

_HELP = """Put language models into the same small world, the same seeds and prompts, and compare what they do.

foundry [OVERRIDES]       one run:   foundry model=scripted/random seed=3

foundry -m [OVERRIDES]    a sweep:   foundry -m model=qwen3:4b,llama3.2 seed=0-9

Overrides are Hydra's: world=..., prompt=..., world.steps=20, +sweep=cross_model; --hydra-help tells more.
"""

app = typer.Typer(
    name="foundry", help=_HELP, rich_markup_mode=None, pretty_exceptions_enable=False, no_args_is_help=False
)
FILE_WIDTH = 200
"""Columns of a table that is written to a file or a pipe."""
OVERRIDES = {"allow_extra_args": True, "ignore_unknown_options": True}
Folder = Annotated[Path, typer.Argument(help="A sweep's folder.", show_default=False)]

Trusted = Annotated[
    list[str] | None,
    typer.Option(
        "--trust-targets",
        help="Also build the classes of this package that the record names; else FOUNDRY_TRUST_TARGETS.",
        show_default=False,
    ),
]


def _use(folders: list[Path] | None) -> list[Path]:
    """Make a user's own folders known, before the command begins."""
    from foundry.own_code import use

    for folder in folders or ():
        if not folder.is_dir():
            raise InputError(f"--config-dir {folder}: there is no such folder.")
    use(folders or ())
    return folders or []


Mine = Annotated[
    list[Path] | None,
    typer.Option(
        "--config-dir", "-cd", help="A folder of your own parts, and of the code that they name.", callback=_use,
        show_default=False,
    ),
]  # fmt: skip
"""For every command that may import what a user wrote; the callback has done all that is to do."""
TrustedServers = Annotated[
    bool, typer.Option("--trust-servers", help="Also send keys to the servers that the record names, use its cluster.")
]


def fail(error: object, code: int) -> int:
    """Print an error in one line, without the passwords of addresses, and return its exit code."""
    print(f"foundry: {visible(without_secrets(str(error)))}", file=sys.stderr)
    return code


def for_screen(text: str) -> str:
    """Return a text of unknown origin: to the letter for a file or a pipe, without commands for a terminal."""
    return visible(text) if sys.stdout.isatty() else text


def console() -> Console:
    """Return the console that tables are printed on."""
    from rich.console import Console

    return Console(markup=False) if sys.stdout.isatty() else Console(markup=False, width=FILE_WIDTH)


def _print_version(value: bool) -> None:
    if value:
        print(f"foundry {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass
