"""The command `foundry`: the only entry point.

`foundry [overrides]` and `foundry -m [overrides]` are read by Hydra, the subcommands of `foundry.commands` by Typer.
"""

from __future__ import annotations

import errno
import importlib
import os
import pkgutil
import sys
from collections.abc import Sequence

from typer.models import CommandInfo

from foundry import commands
from foundry.commands.application import EXIT_FAILED, EXIT_INPUT, EXIT_INTERRUPTED, EXIT_OK, app, fail
from foundry.commands.sweeps import run_overrides
from foundry.composing.compose import folders_last
from foundry.errors import FoundryError, InputError, RecordError, not_found

DISK_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO})
"""What the system says when a disk is full, or no longer a disk that can be written to."""

for _found in pkgutil.iter_modules(commands.__path__):
    importlib.import_module(f"{commands.__name__}.{_found.name}")


def main() -> None:
    """Run the command line and exit."""
    sys.exit(run(sys.argv[1:]))


def run(argv: Sequence[str]) -> int:
    """Run a command line and return the exit code: 0 complete, 2 bad input, 3 runs failed, 130 interrupted."""
    try:
        argv = folders_last(argv)
        if _is_typer(argv):
            return _run_typer(argv)
        return run_overrides(argv)
    except (InputError, RecordError) as error:
        return fail(error, EXIT_INPUT)
    except FoundryError as error:
        return fail(error, EXIT_FAILED)
    except ImportError as error:
        if (error.name or "").partition(".")[0] != "analysis":
            raise
        return fail(_in_the_way(error), EXIT_INPUT)
    except OSError as error:
        if error.errno not in DISK_ERRORS:
            raise
        return fail(f"nothing more can be written ({error}): make room, then say it again.", EXIT_FAILED)
    except KeyboardInterrupt:
        return fail("interrupted", EXIT_INTERRUPTED)


def _in_the_way(error: ImportError) -> FoundryError:
    """Return the error for a package of the name of ours that was imported instead of it."""
    from foundry.own_code import ours

    try:
        ours("analysis")
    except InputError as told:
        return told
    raise error


def _is_typer(argv: Sequence[str]) -> bool:
    """Return whether Typer reads this command line; refuses a word that is no command and no override."""
    if "_FOUNDRY_COMPLETE" in os.environ:
        return True
    first = argv[0] if argv else ""
    names = [_name_of(command) for command in app.registered_commands]
    if first in names or first in ("--help", "-h", "--version", "--install-completion", "--show-completion"):
        return True
    if first and not first.startswith(("-", "~")) and "=" not in first:
        raise not_found("Command", first, names, "An override has the form key=value.")
    return False


def _name_of(command: CommandInfo) -> str:
    return str(getattr(command.callback, "__name__", ""))


def _run_typer(argv: Sequence[str]) -> int:
    arguments = ["--help" if argument == "-h" else argument for argument in argv]
    try:
        app(args=arguments, prog_name="foundry")
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else EXIT_OK
    return EXIT_OK
