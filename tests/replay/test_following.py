"""A viewer keeps up with a run that is going on, and plays one that is over."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from foundry.errors import InputError
from foundry.replay.following import Follower
from foundry.storing.store import RunFolder, find_run


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


def test_a_run_that_is_over_is_played_from_its_start_step_by_step(camera_runs: list[RunFolder]):
    follower = Follower(camera_runs[0])
    seen = [follower.step]
    while follower.tick():
        seen.append(follower.step)
    assert seen == [0, 1, 2]


def test_a_run_that_is_going_on_is_shown_where_it_is(growing: RunFolder, camera_runs: list[RunFolder]):
    follower = Follower(growing)
    assert (follower.step, follower.tick()) == (1, False)
    go_on(growing, camera_runs[0])
    assert follower.tick()
    assert follower.step == 2 and follower.frame().caption.startswith("Step 2")
    assert len(follower.frame().trail) == 3


def test_whoever_chose_a_step_stays_there(growing: RunFolder, camera_runs: list[RunFolder]):
    follower = Follower(growing)
    follower.go(-3)
    go_on(growing, camera_runs[0])
    assert (follower.tick(), follower.step, follower.last) == (False, 0, 2)
    follower.go(99)
    assert follower.step == 2


def test_following_writes_nothing(growing: RunFolder):
    before = growing.stamp()
    files = sorted(growing.path.rglob("*"))
    Follower(growing).frame()
    assert (growing.stamp(), sorted(growing.path.rglob("*"))) == (before, files)


def test_a_2d_run_has_no_window(grid_runs: list[RunFolder]):
    with pytest.raises(InputError, match="is not one of a 3D world"):
        Follower(grid_runs[0])
