"""The command `foundry`: the only entry point.

Hydra parses the overrides of `foundry [overrides]` and `foundry -m [overrides]`, such as `world=bar`. Typer parses the
subcommands, such as `foundry view`; the package `foundry.commands` defines them.
"""

import contextlib
import errno
import importlib
import os
import pkgutil
import sys
from collections.abc import Sequence
from copy import copy
from functools import cache
from typing import Any

import typer
from typer.main import get_command
from typer.models import CommandInfo

from foundry import commands
from foundry.commands.application import EXIT_FAILED, EXIT_INPUT, EXIT_INTERRUPTED, EXIT_OK, app
from foundry.commands.printing import as_loud_as_asked, fail
from foundry.commands.sweeps import run_overrides
from foundry.errors import FoundryError, InputError, RecordError, not_found
from foundry.own_code import folders_last
from foundry.running.cores import leave_all_to_the_system
from foundry.texts import WithoutSecrets, one_line

COMPLETE = "_FOUNDRY_COMPLETE"
"""The environment variable by which a shell asks for completions."""
_UsageError: type[typer.BadParameter] = typer.BadParameter.__mro__[1]
"""Typer's error for an invalid command line, which has no public name."""
RENAMED = {
    "power": "plan --pilot DIR",
    "label --human": "play DIR --label NAME",
    "grow": "resume DIR OVERRIDES",
    "card": "report --model MODEL DIR...",
    "interpret": "scene read TEXT",
    "models": "doctor",
    "prompt": "plan --prompt",
    "validate": "check --known [WORLD...]",
    "threshold": "-m +sweep=critical_mass model=MODEL",
    "fetch": "status URL --fetch DIR",
}
"""The present command for each command of version 0.1."""
DISK_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO})
"""Error numbers of a disk that is full or no longer writable."""

for _found in pkgutil.iter_modules(commands.__path__):
    importlib.import_module(f"{commands.__name__}.{_found.name}")


def main() -> None:
    """Run the command line and exit."""
    code = run(sys.argv[1:])
    leave_all_to_the_system()
    sys.exit(code)


def run(argv: Sequence[str]) -> int:
    """Run a command line and return the exit code: 0 complete, 2 bad input, 3 runs failed, 130 interrupted."""
    streams: tuple[Any, Any] = (WithoutSecrets(sys.stdout), WithoutSecrets(sys.stderr))
    with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
        return _run(argv)


def _run(argv: Sequence[str]) -> int:
    try:
        with as_loud_as_asked(argv) as asked:
            given = folders_last(asked)
            return _run_app(given) if _is_typer(given) else run_overrides(given)
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
        return fail(f"nothing more can be written ({error}): free some space, then repeat the command.", EXIT_FAILED)
    except KeyboardInterrupt:
        return fail("interrupted", EXIT_INTERRUPTED)


def _in_the_way(error: ImportError) -> FoundryError:
    """Return the error that names the other package that Python finds instead of foundry's package `analysis`."""
    from foundry.own_code import ours

    try:
        ours("analysis")
    except InputError as refused:
        return refused
    raise error


def _is_typer(argv: Sequence[str]) -> bool:
    """Return True if Typer reads this command line, False if Hydra does; reject a mistyped command."""
    if COMPLETE in os.environ:
        return True
    first = argv[0] if argv else ""
    names = [_name_of(command) for command in app.registered_commands]
    options = {argument.partition("=")[0] for argument in argv}
    for old, new in RENAMED.items():
        command, *flags = old.split()
        if command == first and options.issuperset(flags):
            raise InputError(f"'foundry {old}' is now: foundry {new}")
    if first in names or first in ("--help", "-h", "--version", "--install-completion", "--show-completion"):
        return True
    if first and not first.startswith(("-", "~")) and "=" not in first:
        raise not_found("Command", first, names, "Overrides have the form key=value.")
    return False


def _name_of(command: CommandInfo) -> str:
    return str(getattr(command.callback, "__name__", ""))


@cache
def _reader(first: str) -> Any:
    """Return Typer's parser for one command only, because a parser for all commands takes long to make."""
    alone = copy(app)
    named = [command for command in app.registered_commands if _name_of(command) == first]
    alone.registered_commands = named or app.registered_commands
    return get_command(alone)


def _run_app(argv: Sequence[str]) -> int:

    arguments = ["--help" if argument == "-h" else argument for argument in argv]
    try:
        reader = _reader(arguments[0] if arguments else "")
        code = reader(args=arguments, prog_name="foundry", standalone_mode=False)
    except SystemExit as stop:
        code = stop.code
    except typer.Abort as error:
        raise KeyboardInterrupt from error
    except _UsageError as error:
        raise InputError(_usage(error)) from error
    return code if isinstance(code, int) else EXIT_OK


def _usage(error: typer.BadParameter) -> str:
    message = one_line(error.format_message()).rstrip(".")
    if error.ctx is None:
        return f"{message}."
    usage = one_line(error.ctx.get_usage())
    return f"{message}. {usage}; for more, use {error.ctx.command_path} --help."
