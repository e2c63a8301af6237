"""Runs of any form are drawn again by the world that they were in, if it says how and may be built."""

from __future__ import annotations

from pathlib import Path

import imageio_ffmpeg
import pytest
from PIL import Image

import made_up_rounds as rounds
from commands import foundry
from foundry.replay.recording import read_recording
from foundry.storing.store import RunFolder

TRUST = ("--trust-targets", "made_up_rounds")


def bar_run(folder: Path, world: str = "Bar", steps: int = 3) -> RunFolder:
    target = {"_target_": f"made_up_rounds.{world}"}
    made = rounds.sweep(folder / "bar", models=("first",), world=target, steps=steps)
    rounds.whole_run(made.runs()[0])
    return made.runs()[0]


def test_pictures_and_films_are_drawn_by_the_runs_world(workspace: Path):
    run = bar_run(workspace)
    done = foundry("replay", str(run.path), "--steps", "0,3", "--out", "pictures", *TRUST, cwd=workspace)
    assert (done.returncode, done.stderr) == (0, "")
    for step in (0, 3):
        with Image.open(workspace / "pictures" / f"step_{step:04d}.png") as picture:
            assert picture.size == (300, 120)
    done = foundry("replay", str(run.path), "--video", "run.mp4", *TRUST, cwd=workspace)
    assert done.returncode == 0, done.stderr
    assert imageio_ffmpeg.count_frames_and_secs(str(workspace / "run.mp4"))[0] == 4


@pytest.mark.parametrize("film", ["run.mp4", "run.gif"])
def test_pictures_that_grow_are_fitted_into_the_first_ones_size(workspace: Path, film: str):
    run = bar_run(workspace, "Growing")
    done = foundry("replay", str(run.path), "--video", film, *TRUST, cwd=workspace)
    assert done.returncode == 0, done.stderr
    if film.endswith(".gif"):
        with Image.open(workspace / film) as picture:
            picture.seek(3)
            assert (picture.size, picture.n_frames) == ((300, 60 + 120 + 60), 4)
            beside, within = picture.convert("RGB").getpixel((20, 80)), picture.convert("RGB").getpixel((117, 80))
        assert min(beside) > 250 > min(within), "the whole picture is there, with white on both sides"
    else:
        assert imageio_ffmpeg.count_frames_and_secs(str(workspace / film))[0] == 4


@pytest.mark.parametrize(
    ("world", "arguments", "said"),
    [
        ("Bar", (), "the recorded target 'made_up_rounds.Bar' is refused"),
        ("Undrawn", TRUST, "World 'bar' does not say how to draw its runs again: give its Scenario a `redraw`."),
        ("Spoilt", TRUST, "cannot draw run"),
    ],
)
def test_what_cannot_be_drawn_is_said_in_one_line(workspace: Path, world: str, arguments: tuple[str, ...], said: str):
    run = bar_run(workspace, world)
    done = foundry("replay", str(run.path), "--steps", "0", "--out", "pictures", *arguments, cwd=workspace)
    assert done.returncode == 2
    assert said in done.stderr and done.stderr.count("\n") == 1


def test_the_last_step_of_a_complete_run_may_be_shorter_than_the_first(workspace: Path):
    run = bar_run(workspace)
    lines = run.steps_bytes().splitlines(keepends=True)
    run.stream_path("steps").write_bytes(b"".join(lines[:-4]))
    assert read_recording(run).last == 3
    (run.path / "run.json").unlink()
    assert read_recording(run).last == 2, "of a run that is not complete, a crash may have cut it"
