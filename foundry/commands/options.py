"""Arguments and options that several commands have."""

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from foundry.errors import InputError
from foundry.own_code import use


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
    list[str] | None, typer.Argument(metavar="OVERRIDES", help="Overrides as for `foundry`: -m, key=value, ...")
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
    list[Path] | None, typer.Option("--config-dir", "-cd", help="A folder with your own parts.", callback=_use)
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


def check_belongs(flag: str, options: Mapping[str, object]) -> None:
    """Reject options that only work together with `flag`, which was not given."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"--{name} only works with {flag}. Add {flag}, or leave out --{name}.")


class Labeller(StrEnum):
    """Decides which messages count as warnings: a rule, or the labels that a model gave."""

    RULE = "rule"
    MODEL = "model"


WhoLabels = Annotated[Labeller, typer.Option(help="Find warnings by the rule, or by the labels of foundry label.")]
Family = Annotated[
    list[str] | None, typer.Option(help="A measure to test; in a probe, a model or an edit. Can be repeated.")
]
Margins = Annotated[
    list[str] | None,
    typer.Option(help="MEASURE=SIZE: smaller differences do not matter. Choose the size before you see the data."),
]
Only = Annotated[
    list[str] | None,
    typer.Option(
        help="KEY=VALUE,...: only these runs, such as model=a,b or seed=0-9; in a probe also edit=no_fire. Can be "
        "repeated."
    ),
]
Without = Annotated[
    list[str] | None, typer.Option(help="KEY=VALUE,...: leave out these runs, such as prompt=japanese.")
]
Host = Annotated[str, typer.Option(help="Address of the page. Other machines can open the page if you change it.")]
Port = Annotated[
    int | None,
    typer.Option(min=0, max=65535, help="Port of the page; default: 8600 or the next free port; 0: any free port."),
]
Browser = Annotated[bool, typer.Option(help="Open the browser.")]
