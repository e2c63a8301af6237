"""The command `replay`: pictures, films, a window where there is a display; any form is drawn by its world."""

import re
import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

import made_up_rounds as rounds
from commands import foundry, refusal, succeeds
from foundry.palette import COLOURS
from foundry.replay.recording import read_recording
from foundry.storing.store import RunFolder


def replay(*arguments: object, cwd: Path, **changes: str) -> subprocess.CompletedProcess[str]:
    return foundry("replay", *map(str, arguments), cwd=cwd, **changes)


def film(path: Path, height: int, width: int) -> np.ndarray:
    """Return the frames of an MP4, (n, height, width, 3)."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    return np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)


def test_pictures_go_beside_the_analysis_and_equal_the_saved_ones(grid_runs: list[RunFolder], workspace: Path):
    run = grid_runs[0]
    done = replay(run.path, "--every", 3, cwd=workspace)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"wrote 3 pictures to {run.replay_dir}\n"
    for file in (run.path / "frames").iterdir():
        assert (run.replay_dir / file.name).read_bytes() == file.read_bytes()


@pytest.mark.slow
def test_an_mp4_shows_the_pictures_at_the_rate_asked_for(grid_runs: list[RunFolder], workspace: Path):
    run = grid_runs[0]
    done = replay(run.path, "--steps", "0,6", "--video", "run.mp4", "--fps", 2, cwd=workspace)
    assert done.stdout == "wrote run.mp4: 2 pictures, 2 a second\n", done.stderr
    frames = film(workspace / "run.mp4", 60 + 800 + 156, 800)
    saved = np.asarray(Image.open(run.path / "frames" / "step_0006.png").convert("RGB"), int)
    assert len(frames) == 2 and np.abs(frames[1][60:860] - saved).mean() < 2
    assert imageio_ffmpeg.count_frames_and_secs(str(workspace / "run.mp4")) == (2, 1.0)
    assert [file.name for file in workspace.iterdir()] == ["run.mp4"]


@pytest.mark.slow
def test_a_gif_of_several_runs_is_tiled(grid_runs: list[RunFolder], workspace: Path):
    done = replay(*(run.path for run in grid_runs[:2]), "--steps", "1-2", "--video", "both.gif", cwd=workspace)
    assert done.returncode == 0, done.stderr
    with Image.open(workspace / "both.gif") as picture:
        assert (picture.n_frames, picture.size, picture.info["duration"]) == (2, (1600, 60 + 800 + 156), 200)


def test_a_run_that_is_not_finished_is_shown_as_far_as_it_goes(
    grid_runs: list[RunFolder], workspace: Path, tmp_path: Path
):
    run = grid_runs[0]
    hidden = tmp_path / "run.json"
    (run.path / "run.json").rename(hidden)
    try:
        done = replay(run.path, "--steps", 0, "--out", "pictures", cwd=workspace)
    finally:
        hidden.rename(run.path / "run.json")
    assert done.stdout.splitlines() == [f"{run.id}: unfinished: recorded up to step 6", "wrote 1 pictures to pictures"]
    assert [file.name for file in (workspace / "pictures").iterdir()] == ["step_0000.png"]


def svg_of(*arguments: object, cwd: Path) -> str:
    done = replay(*arguments, "--svg", "run.svg", cwd=cwd)
    assert done.stdout == "wrote run.svg\n", done.stderr
    text = (cwd / "run.svg").read_text()
    assert str(cwd.parents[1]) not in text and "file:" not in text
    return text


def test_an_svg_shows_steps_or_whole_ways_and_names_no_file_of_this_machine(
    grid_runs: list[RunFolder], workspace: Path
):
    strip = svg_of(grid_runs[0].path, "--steps", "0,6", cwd=workspace)
    assert re.findall(r">step (\d)<", strip) == ["0", "6"] and strip.count(">5<") + strip.count(">×") >= 2
    assert strip.count(COLOURS[0].lower()) and "scripted/echo, seed 0" in strip
    ways = svg_of(*(run.path for run in grid_runs[:2]), cwd=workspace)
    assert "step" not in ways and "prompt japanese" in ways


@pytest.mark.slow
def test_an_svg_of_a_3d_run_shows_its_steps(camera_runs: list[RunFolder], workspace: Path):
    assert ">2<" in svg_of(camera_runs[0].path, "--steps", "0,2", cwd=workspace)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--video", "x.avi"), "Kind of film '.avi' not found"),
        (("--video", "nowhere/x.mp4"), "there is no folder 'nowhere'"),
        (("--video", "x.gif", "--fps", "0"), "--fps must be above 0"),
        (("--steps", "1-900"), "there is no step 900"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    grid_runs: list[RunFolder], workspace: Path, arguments: tuple[str, ...], said: str
):
    done = replay(grid_runs[0].path, *arguments, cwd=workspace)
    assert done.returncode == 2
    assert said in done.stderr and done.stderr.count("\n") == 1
    assert list(workspace.iterdir()) == []


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
    succeeds("replay", str(run.path), "--video", "run.mp4", *TRUST, cwd=workspace)
    assert imageio_ffmpeg.count_frames_and_secs(str(workspace / "run.mp4"))[0] == 4


@pytest.mark.parametrize(
    ("world", "arguments", "said"),
    [
        ("Bar", (), "the recorded target 'made_up_rounds.Bar' is refused"),
        ("Spoilt", TRUST, "cannot redraw run"),
    ],
)
def test_what_cannot_be_drawn_is_said_in_one_line(workspace: Path, world: str, arguments: tuple[str, ...], said: str):
    run = bar_run(workspace, world)
    assert said in refusal("replay", str(run.path), "--steps", "0", "--out", "pictures", *arguments, cwd=workspace)


def test_the_last_step_of_a_complete_run_may_be_shorter_than_the_first(workspace: Path):
    run = bar_run(workspace)
    lines = run.steps_bytes().splitlines(keepends=True)
    run.stream_path("steps").write_bytes(b"".join(lines[:-4]))
    assert read_recording(run).last == 3
    (run.path / "run.json").unlink()
    assert read_recording(run).last == 2, "of a run that is not complete, a crash may have cut it"
