"""The Typer application to which every command belongs, and the exit codes."""

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from foundry.version import __version__

EXIT_OK, EXIT_INPUT, EXIT_FAILED, EXIT_INTERRUPTED = 0, 2, 3, 130

_HELP = """Compare language models in the same small worlds, with the same seeds and prompts.

foundry [OVERRIDES]       one run:   foundry model=scripted/random seed=3

foundry -m [OVERRIDES]    a sweep:   foundry -m model=qwen3:4b,llama3.2 seed=0-9

Overrides are Hydra's: world=..., prompt=..., world.steps=20, +sweep=cross_model. --hydra-help explains them.

With every command, -q prints only results and errors, and -v more, such as each run as it ends.
"""

RUN, LOOK, TRUST, EXTEND = "Run", "Look", "Trust", "Extend"
"""The groups of commands, in the order of `foundry --help`."""


_WHOLE = 1_000
"""More characters than the first sentence of any command has, so that it is wrapped and never cut."""


class _Grouped(TyperGroup):
    """Lists the commands by group in `foundry --help`, as plain text."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        width = max(map(len, self.commands))
        for group in (RUN, LOOK, TRUST, EXTEND):
            lines = [
                (f"{command.name:<{width}}", command.get_short_help_str(_WHOLE))
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
OVERRIDES = {"ignore_unknown_options": True}
"""Typer's settings for commands that take overrides, as `foundry` does; overrides may contain flags such as -m."""


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
