"""Commands that draw runs from their records alone, and that show the scenes of 3D worlds."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer

from foundry.commands.application import EXTEND, LOOK, app
from foundry.commands.options import Mine, Trusted, folder_argument
from foundry.commands.printing import for_screen, with_bar
from foundry.errors import InputError, not_found
from foundry.storing.store import RunFolder, find_run

if TYPE_CHECKING:
    from foundry.replay.pictures import Picture
    from foundry.replay.recording import Recording

_PART = re.compile(r"(\d+)(?:-(\d+))?")


@app.command(rich_help_panel=LOOK)
def replay(
    runs: Annotated[list[Path], folder_argument("Folders of runs: DIR/runs/<run>.", "RUN")],
    steps: Annotated[
        str | None, typer.Option(help="Only these steps, such as 0,5,10-20; 0 is the initial state.")
    ] = None,
    every: Annotated[int | None, typer.Option(help="Only every n-th step.")] = None,
    video: Annotated[Path | None, typer.Option(help="Write a film into this file (.mp4, .gif).")] = None,
    fps: Annotated[float, typer.Option(help="Steps per second of the film.")] = 5.0,
    svg: Annotated[Path | None, typer.Option(help="Write one figure of these steps, by default of all steps.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the pictures; default: analysis/replay in the sweep.")
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Number of processes; default: one per core.", min=1)] = None,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Draw runs from their records: pictures, a film, or a figure.

    foundry replay outputs/pilot/runs/<run> --steps 0,10-20

    Several runs are drawn side by side: foundry replay RUN RUN RUN --video comparison.mp4
    """
    from foundry.replay.film import check_film, write_film
    from foundry.replay.pictures import film_texts, pictures
    from foundry.replay.recording import read_recording
    from foundry.replay.telling import boxes_note

    folders = [find_run(path) for path in runs]
    recordings = [read_recording(run, trust_targets or ()) for run in folders]
    for recording in recordings:
        if recording.note:
            print(for_screen(f"{recording.id}: {recording.note}"))
    chosen = chosen_steps(steps, every, max(recording.last for recording in recordings))
    if svg is not None:
        _sketch(svg, folders, recordings, None if steps is None and every is None else chosen)
        return
    if video is not None:
        check_film(video, fps)
        if note := boxes_note(film_texts(recordings, chosen)):
            print(for_screen(note))
    drawn = with_bar(pictures(recordings, chosen, workers=workers, film=video is not None), "drawing", len(chosen))
    if video is None or out is not None:
        folder = out or _folder(folders)
        drawn = _written(drawn, folder)
    if video is not None:
        write_film(video, drawn, fps)
        print(f"wrote {video}: {len(chosen)} pictures, {fps:g} a second")
    else:
        print(f"wrote {sum(1 for _ in drawn)} pictures to {folder}")


def chosen_steps(text: str | None, every: int | None, last: int) -> list[int]:
    """Return the steps to show, ascending; 0 is the initial state.

    Args:
        text: numbers and ranges such as "0,5,10-20", or None for all steps.
        every: n, for the initial state and every n-th step after it, or None.
        last: number of the last step.

    Raises:
        InputError: the text cannot be read, or names a missing step.
    """
    if text is not None and every is not None:
        raise InputError("--steps and --every exclude each other. Give one of them.")
    if every is not None:
        if every < 1:
            raise InputError(f"--every {every} is not a valid number of steps. Give a number of at least 1.")
        return list(range(0, last + 1, every))
    if text is None:
        return list(range(last + 1))
    return sorted({step for part in text.split(",") for step in _steps_of(part.strip(), last)})


def _steps_of(part: str, last: int) -> range:
    match = _PART.fullmatch(part)
    if match is None:
        raise InputError(f"--steps: '{part}' is neither a step nor a range such as 10-20.")
    first, final = int(match[1]), int(match[2] or match[1])
    if first > final:
        raise InputError(f"--steps: the range '{part}' begins after its end. Write {final}-{first}.")
    if final > last:
        raise InputError(f"--steps: there is no step {final}; the records end with step {last}.")
    return range(first, final + 1)


def _sketch(
    file: Path, runs: Sequence[RunFolder], recordings: Sequence[Recording], steps: Sequence[int] | None
) -> None:

    from analysis.figures.sketch import sketch
    from foundry.replay.tiling import captions

    if unfinished := next((recording for recording in recordings if recording.note), None):
        raise InputError(f"--svg only draws complete runs, but {unfinished.id} is not complete: {unfinished.note}.")
    file.write_text(sketch(dict(zip(captions(recordings), runs, strict=True)), steps), encoding="utf-8")
    print(f"wrote {file}")


def _folder(runs: Sequence[RunFolder]) -> Path:
    first = runs[0].replay_dir
    return first if len(runs) == 1 else first.with_name(f"{first.name}_and_{len(runs) - 1}_more")


def _written(drawn: Iterator[Picture], folder: Path) -> Iterator[Picture]:
    folder.mkdir(parents=True, exist_ok=True)
    for picture in drawn:
        (folder / f"step_{picture.step:04d}.png").write_bytes(picture.png)
        yield picture


@app.command(rich_help_panel=EXTEND)
def scene(
    what: Annotated[
        str, typer.Argument(help="info: list the content; shot: draw a picture; read: show how foundry reads a reply.")
    ],
    subject: Annotated[
        str,
        typer.Argument(
            metavar="FILE|TEXT",
            help="A USD file; for read, a reply, or - to read one JSON string per line from standard input.",
        ),
    ],
    out: Annotated[Path, typer.Option(help="The picture's file.")] = Path("shot.png"),
    exclude: Annotated[list[str] | None, typer.Option(help="Leave out prims: a pattern such as /World/Earth*.")] = None,
    root: Annotated[
        Path | None, typer.Option(help="The scene may read files in this folder; default: its own folder.")
    ] = None,
    pose: Annotated[
        str | None, typer.Option(help="x,y,z,yaw,pitch of the camera, metres and degrees; default: an overview.")
    ] = None,
    limits: Annotated[
        bool, typer.Option("--limits", help="With read: apply the limits on moves of the shipped 3D worlds.")
    ] = False,
    config_dir: Mine = None,
) -> None:
    """List the content of a USD file, or draw a picture of it.

    Lists the parts that cannot be drawn.

    foundry scene read "Turn right by 30 degrees." prints how 3D worlds read a reply, one JSON object per reply.
    """
    what = what.lower()
    if what not in ("info", "shot", "read"):
        raise not_found("Subcommand of scene", what, ("info", "shot", "read"))
    if limits and what != "read":
        raise InputError(f"--limits only works with foundry scene read. Leave it out of foundry scene {what}.")
    if what == "read":
        from foundry.worlds.camera.language.interpreter import read_replies

        replies = sys.stdin if subject == "-" else [msgspec.json.encode(subject).decode()]
        for line in read_replies(replies, limited=limits):
            print(line)
        return
    from foundry.worlds.camera.showing import describe_scene, shoot_scene

    if what == "info":
        for line in describe_scene(Path(subject), exclude or [], root):
            print(for_screen(line))
    else:
        out.write_bytes(shoot_scene(Path(subject), exclude or [], pose, root))
        print(f"wrote {out}")
