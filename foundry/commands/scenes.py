"""Commands about what only 3D worlds have: scenes, and replies in plain language."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import Mine, app, for_screen
from foundry.errors import not_found


@app.command()
def interpret(
    text: Annotated[str, typer.Argument(help="A reply; - reads one JSON string a line from standard input.")],
    limits: Annotated[bool, typer.Option("--limits", help="Clamp to the limits of the shipped 3D worlds.")] = False,
    config_dir: Mine = None,
) -> None:
    """Print what the interpreter of the 3D worlds reads from a reply, one JSON object a reply."""
    import msgspec

    from foundry.worlds.camera.language.interpreter import read_replies

    lines = sys.stdin if text == "-" else [msgspec.json.encode(text).decode()]
    for line in read_replies(lines, limited=limits):
        print(line)


@app.command()
def scene(
    what: Annotated[str, typer.Argument(help="info: what is in it; shot: a picture of it.")],
    path: Annotated[Path, typer.Argument(help="A USD file.", show_default=False)],
    out: Annotated[Path, typer.Option(help="The picture's file.")] = Path("shot.png"),
    exclude: Annotated[list[str] | None, typer.Option(help="Leave out prims: a pattern such as /World/Earth*.")] = None,
    root: Annotated[Path | None, typer.Option(help="Let the scene read all below this folder, not its own.")] = None,
    pose: Annotated[
        str | None, typer.Option(help="x,y,z,yaw,pitch of the eye, metres and degrees; else an overview.")
    ] = None,
    config_dir: Mine = None,
) -> None:
    """Show what is in a USD file, and what will not be drawn, or make a picture of it."""
    from foundry.worlds.camera.showing import describe_scene, shoot_scene

    what = what.lower()
    if what not in ("info", "shot"):
        raise not_found("Subcommand of scene", what, ("info", "shot"))
    if what == "info":
        for line in describe_scene(path, exclude or [], root):
            print(for_screen(line))
        return
    out.write_bytes(shoot_scene(path, exclude or [], pose, root))
    print(f"wrote {out}")
