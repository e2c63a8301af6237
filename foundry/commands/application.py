"""The common parts of all commands: the Typer application, exit codes, the console."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import msgspec
import typer
from typer.core import TyperGroup

from foundry.errors import InputError
from foundry.own_code import use
from foundry.texts import visible
from foundry.version import __version__

if TYPE_CHECKING:
    from rich.console import Console

T = TypeVar("T")
EXIT_OK, EXIT_INPUT, EXIT_FAILED, EXIT_INTERRUPTED = 0, 2, 3, 130

_HELP = """Compare language models in the same small worlds, with the same seeds and prompts.

foundry [OVERRIDES]       one run:   foundry model=scripted/random seed=3

foundry -m [OVERRIDES]    a sweep:   foundry -m model=qwen3:4b,llama3.2 seed=0-9

Overrides are Hydra's: world=..., prompt=..., world.steps=20, +sweep=cross_model. --hydra-help explains them.

With every command, -q prints only results and errors, and -v more, such as each run as it ends.
"""

RUN, LOOK, TRUST, EXTEND = "Run", "Look", "Trust", "Extend"
"""The groups of commands, in the order of `foundry --help`."""


class _Grouped(TyperGroup):
    """Lists the commands by group in `foundry --help`, as plain text."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        width = max(map(len, self.commands))
        for group in (RUN, LOOK, TRUST, EXTEND):
            lines = [
                (f"{command.name:<{width}}", command.get_short_help_str(formatter.width - width - 6))
                for command in self.commands.values()
                if getattr(command, "rich_help_panel", None) == group
            ]
            with formatter.section(group):
                formatter.write_dl(lines)


app = typer.Typer(
    cls=_Grouped,
    name="foundry",
    help=_HELP,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=False,
)
FILE_WIDTH = 200
"""Width of a table that is written to a file or a pipe, characters."""
OVERRIDES = {"ignore_unknown_options": True}
"""For commands that take the same overrides as `foundry`, among them flags of Hydra."""


def folder_text(text: str) -> str:
    """Return the folder of a sweep, given as DIR or as output.dir=DIR."""
    return text.removeprefix("output.dir=")


def folder_path(text: str) -> Path:
    """Return the path of a sweep's folder, given as DIR or as output.dir=DIR."""
    return Path(folder_text(text))


def folder_argument(help: str, metavar: str = "DIR") -> Any:
    """Return an argument for a sweep's folder, which users may also write as output.dir=DIR."""
    return typer.Argument(help=help, metavar=metavar, parser=folder_path)


Folder = Annotated[Path, folder_argument("A sweep's folder, or output.dir=DIR.")]
Folders = Annotated[list[Path], folder_argument("Sweeps' folders.")]
OneRun = Annotated[Path, folder_argument("A run's folder: DIR/runs/<run>.", "RUN")]
Overrides = Annotated[
    list[str] | None,
    typer.Argument(metavar="OVERRIDES", help="Overrides as for `foundry`: -m, key=value, ..."),
]

Trusted = Annotated[
    list[str] | None,
    typer.Option(
        "--trust-targets",
        help="Also use classes of this package if a record names them; default: FOUNDRY_TRUST_TARGETS.",
    ),
]


def _use(folders: list[Path] | None) -> list[Path]:

    for folder in folders or ():
        if not folder.is_dir():
            raise InputError(f"--config-dir {folder}: folder not found.")
    use(folders or ())
    return folders or []


Mine = Annotated[
    list[Path] | None,
    typer.Option("--config-dir", "-cd", help="A folder with your own parts.", callback=_use),
]
"""The option of every command that may import the user's code; its callback registers the folders of this code."""


def given(overrides: list[str] | None, folders: list[Path] | None) -> list[str]:
    """Return a command line with these overrides, and with --config-dir for each of the user's folders."""
    return [*(overrides or ()), *(part for folder in folders or () for part in ("--config-dir", str(folder)))]


TrustedServers = Annotated[
    bool,
    typer.Option("--trust-servers", help="Use the servers and the cluster that a record names, also with your keys."),
]
Noted = Annotated[bool, typer.Option("--notes", help="Include the notes that people wrote about runs and moments.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print only one JSON object; messages go to standard error.")]


class Loudness(IntEnum):
    """The amount of text that a command prints besides its result."""

    QUIET = -1
    NORMAL = 0
    VERBOSE = 1


_FLAGS = {"-q": Loudness.QUIET, "--quiet": Loudness.QUIET, "-v": Loudness.VERBOSE, "--verbose": Loudness.VERBOSE}
_loudness: ContextVar[Loudness] = ContextVar("loudness", default=Loudness.NORMAL)


@contextlib.contextmanager
def as_loud_as_asked(argv: Sequence[str]) -> Iterator[list[str]]:
    """Set the loudness by `-q` or `-v`, which may stand anywhere before `--`; yield the command line without them."""
    end = argv.index("--") if "--" in argv else len(argv)
    levels = {_FLAGS[one] for one in argv[:end] if one in _FLAGS}
    if len(levels) > 1:
        raise InputError("-q and -v cannot be used together. Give one of them.")
    token = _loudness.set(levels.pop() if levels else Loudness.NORMAL)
    try:
        yield [*(one for one in argv[:end] if one not in _FLAGS), *argv[end:]]
    finally:
        _loudness.reset(token)


def check_belongs(flag: str, options: Mapping[str, object]) -> None:
    """Reject options that only work with another flag, when this flag was not given."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"--{name} only works with {flag}. Add {flag}, or leave out --{name}.")


def is_quiet() -> bool:
    """Return whether the user asked for results and errors only (`-q`)."""
    return _loudness.get() is Loudness.QUIET


def is_verbose() -> bool:
    """Return whether the user asked for more output than usual (`-v`)."""
    return _loudness.get() is Loudness.VERBOSE


def say(text: str) -> None:
    """Print a hint, such as a folder or the next command, unless the user asked for results only."""
    if not is_quiet():
        print(text)


def say_notes(sweeps: Iterable[Path], *, taken: bool) -> None:
    """Print the number of people's notes, and whether they were included."""
    from foundry.storing.notes import notes_of

    notes = sum(len(notes_of(sweep).notes) for sweep in sweeps)
    if notes:
        say(f"Notes {'included' if taken else 'left out; add --notes to include them'}: {notes}.")


@contextlib.contextmanager
def only_json(asked: bool) -> Iterator[None]:
    """If JSON is asked for, send everything that is printed in this context to standard error."""
    with contextlib.redirect_stdout(sys.stderr) if asked else contextlib.nullcontext():
        yield


def print_json(value: Any) -> None:
    """Print a value as one JSON object: NaN as null, a path as text, a NumPy number as its value."""
    encoded = msgspec.json.encode(value, enc_hook=lambda one: one.item() if hasattr(one, "item") else str(one))
    print(msgspec.json.format(encoded).decode())


def fail(error: object, code: int) -> int:
    """Print an error in one line, and return the given exit code."""
    print(f"foundry: {visible(str(error))}", file=sys.stderr)
    return code


def for_screen(text: str) -> str:
    """Return a text of unknown origin; if it goes to a terminal, its control characters are escaped."""
    return visible(text) if sys.stdout.isatty() else text


def console() -> Console:
    """Return the console on which tables are printed."""
    from rich.console import Console

    return Console(markup=False) if sys.stdout.isatty() else Console(markup=False, width=FILE_WIDTH)


def bars() -> Console:
    """Return the console for progress bars, which shows nothing if the user asked for results only."""
    screen = console()
    screen.quiet = is_quiet()
    return screen


def with_bar(items: Iterable[T], doing: str, total: int) -> Iterator[T]:
    """Yield the items; on a terminal, a bar such as "verifying" counts them."""
    from rich.progress import track

    screen = bars()
    yield from track(items, doing, total=total, console=screen, transient=True, disable=not screen.is_terminal)


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
