"""A viewer keeps up with a run that is going on, and plays one that is over."""

from __future__ import annotations

import io
import shutil
from pathlib import Path

import numpy as np
import pytest
import pyvista
from PIL import Image

from foundry.replay.following import Follower
from foundry.replay.pictures import pictures
from foundry.replay.recording import read_recording
from foundry.replay.window import SIZE, window_of
from foundry.storing.store import RunFolder, find_run
from foundry.viewer.any.any_window import CAPTION_PX


@pytest.fixture
def growing(camera_runs: list[RunFolder], tmp_path: Path) -> RunFolder:
    """A run that has made its first decision of two."""
    source = camera_runs[0].path
    shutil.copytree(source.parent.parent, tmp_path / "copy")
    run = find_run(tmp_path / "copy" / "runs" / source.name)
    (run.path / "run.json").unlink()
    lines = run.steps_bytes().splitlines(keepends=True)
    (run.path / "steps.jsonl").write_bytes(lines[0])
    return run


def go_on(run: RunFolder, source: RunFolder) -> None:
    (run.path / "steps.jsonl").write_bytes(source.steps_bytes())


@pytest.mark.slow
def test_a_run_that_is_over_is_played_from_its_start_step_by_step(camera_runs: list[RunFolder]):
    follower = Follower(camera_runs[0])
    seen = [follower.step]
    while follower.tick():
        seen.append(follower.step)
    assert seen == [0, 1, 2]


@pytest.mark.slow
def test_a_run_that_is_going_on_is_shown_where_it_is_and_left_alone(growing: RunFolder, camera_runs: list[RunFolder]):
    follower = Follower(growing)
    first = follower.picture()
    assert (follower.step, follower.tick()) == (1, False)
    go_on(growing, camera_runs[0])
    assert follower.tick()
    assert follower.step == 2 and follower.picture() != first
    before = growing.stamp()
    files = sorted(growing.path.rglob("*"))
    Follower(growing).picture()
    assert (growing.stamp(), sorted(growing.path.rglob("*"))) == (before, files)


@pytest.mark.slow
def test_whoever_chose_a_step_stays_there(growing: RunFolder, camera_runs: list[RunFolder]):
    follower = Follower(growing)
    follower.go(-3)
    go_on(growing, camera_runs[0])
    assert (follower.tick(), follower.step, follower.last) == (False, 0, 2)
    follower.go(99)
    assert follower.step == 2


def seen(run: RunFolder, monkeypatch: pytest.MonkeyPatch, trusted: tuple[str, ...] = ()) -> np.ndarray:
    """Return what a window shows after the first step, (h, w, 3); it is drawn where nobody sees it."""
    monkeypatch.setattr(pyvista, "OFF_SCREEN", True)
    window = window_of(run, trusted)
    window._go(1)
    return window.seen().astype(int)


@pytest.mark.slow
def test_the_window_of_a_3d_run_shows_its_scene_and_what_the_agent_sees(
    camera_runs: list[RunFolder], monkeypatch: pytest.MonkeyPatch
):
    shown = seen(camera_runs[0], monkeypatch)
    red = (shown[..., 0] > 120) & (shown[..., 1] < 90)
    assert red.any(), "the agent is red"
    inset = shown[-100:-12, -300:-12]
    assert (inset != 255).any(axis=2).mean() > 0.9, "what it sees fills the corner"


@pytest.mark.slow
def test_the_window_of_any_other_run_shows_its_pictures(grid_runs: list[RunFolder], monkeypatch: pytest.MonkeyPatch):
    shown = seen(grid_runs[0], monkeypatch)
    (drawn,) = pictures([read_recording(grid_runs[0])], [1], workers=1)
    height, width = SIZE[1] - CAPTION_PX, SIZE[1] - CAPTION_PX  # the pictures of a grid are square
    wanted = np.asarray(Image.open(io.BytesIO(drawn.png)).convert("RGB").resize((width, height)), int)
    left = (SIZE[0] - width) // 2
    assert np.abs(shown[-height:, left : left + width] - wanted).mean() < 2
    assert (shown[-height:, : left - 2] == 255).all()
