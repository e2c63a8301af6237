"""Prints results, hints, errors, tables and bars on the terminal: less with `-q`, more with `-v`."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from foundry.errors import InputError
from foundry.texts import visible

if TYPE_CHECKING:
    from rich.console import Console

T = TypeVar("T")
FILE_WIDTH = 200
"""Width of a table that is written to a file or a pipe, characters."""


_FLAGS = {"-q": -1, "--quiet": -1, "-v": 1, "--verbose": 1}
_loudness: ContextVar[int] = ContextVar("loudness", default=0)
"""The amount of text besides the result: none (-1), the usual amount (0) or more (1)."""


@contextlib.contextmanager
def as_loud_as_asked(argv: Sequence[str]) -> Iterator[list[str]]:
    """Print less with `-q` and more with `-v`, anywhere before `--`; yield the command line without these flags."""
    end = argv.index("--") if "--" in argv else len(argv)
    levels = {_FLAGS[argument] for argument in argv[:end] if argument in _FLAGS}
    if len(levels) > 1:
        raise InputError("-q and -v cannot be used together. Give one of them.")
    token = _loudness.set(levels.pop() if levels else 0)
    try:
        yield [*(argument for argument in argv[:end] if argument not in _FLAGS), *argv[end:]]
    finally:
        _loudness.reset(token)


def is_quiet() -> bool:
    """Return whether the user asked for results and errors only (`-q`)."""
    return _loudness.get() < 0


def is_verbose() -> bool:
    """Return whether the user asked for more output than usual (`-v`)."""
    return _loudness.get() > 0


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
    """Print a value as one JSON object; NaN becomes null, a path becomes a text, and a NumPy number a JSON number."""
    encoded = msgspec.json.encode(
        value, enc_hook=lambda number: number.item() if hasattr(number, "item") else str(number)
    )
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
    """Yield the items, and show on a terminal a progress bar with the text `doing`, such as "verifying"."""
    from rich.progress import track

    screen = bars()
    yield from track(items, doing, total=total, console=screen, transient=True, disable=not screen.is_terminal)
