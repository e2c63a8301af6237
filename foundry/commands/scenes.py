"""The command about 3D worlds: their scenes, and replies in plain language."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXTEND, Mine, app, for_screen
from foundry.errors import InputError, not_found


@app.command(rich_help_panel=EXTEND)
def scene(
    what: Annotated[
        str, typer.Argument(help="info: what is in it; shot: a picture of it; read: how a reply would be read.")
    ],
    subject: Annotated[
        str,
        typer.Argument(
            metavar="FILE|TEXT",
            help="A USD file; for read a reply, or - for one JSON string a line from standard input.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option(help="The picture's file.")] = Path("shot.png"),
    exclude: Annotated[list[str] | None, typer.Option(help="Leave out prims: a pattern such as /World/Earth*.")] = None,
    root: Annotated[Path | None, typer.Option(help="Let the scene read all below this folder, not its own.")] = None,
    pose: Annotated[
        str | None, typer.Option(help="x,y,z,yaw,pitch of the eye, metres and degrees; else an overview.")
    ] = None,
    limits: Annotated[
        bool, typer.Option("--limits", help="With read: clamp to the limits of the shipped 3D worlds.")
    ] = False,
    config_dir: Mine = None,
) -> None:
    """Show what is in a USD file, and what will not be drawn, make a picture of it, or read a reply.

    foundry scene read "Turn right by 30 degrees." prints how 3D worlds read a reply, one JSON object a reply.
    """
    what = what.lower()
    if what not in ("info", "shot", "read"):
        raise not_found("Subcommand of scene", what, ("info", "shot", "read"))
    if limits and what != "read":
        raise InputError(f"--limits belongs to foundry scene read: leave it out of foundry scene {what}.")
    if what == "read":
        _read(subject, limited=limits)
    elif what == "info":
        _describe(Path(subject), exclude or [], root)
    else:
        _shoot(Path(subject), exclude or [], pose, root, out)


def _read(text: str, *, limited: bool) -> None:
    """Print how the 3D worlds read a reply, or each reply of the standard input."""
    import msgspec

    from foundry.worlds.camera.language.interpreter import read_replies

    lines = sys.stdin if text == "-" else [msgspec.json.encode(text).decode()]
    for line in read_replies(lines, limited=limited):
        print(line)


def _describe(path: Path, exclude: Sequence[str], root: Path | None) -> None:
    from foundry.worlds.camera.showing import describe_scene

    for line in describe_scene(path, exclude, root):
        print(for_screen(line))


def _shoot(path: Path, exclude: Sequence[str], pose: str | None, root: Path | None, out: Path) -> None:
    from foundry.worlds.camera.showing import shoot_scene

    out.write_bytes(shoot_scene(path, exclude, pose, root))
    print(f"wrote {out}")
