"""What is drawn again from the records is what the run saved, byte for byte."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from foundry.replay.pictures import CHUNK, Picture, pictures
from foundry.replay.recording import Recording, read_recording
from foundry.storing.store import RunFolder


def saved(run: RunFolder) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in (run.path / "frames").iterdir()}


def redrawn(run: RunFolder, steps: list[int]) -> dict[str, bytes]:
    drawn = pictures([read_recording(run)], steps, workers=1)
    return {f"step_{one.step:04d}.png": one.png for one in drawn}


def size(picture: Picture) -> tuple[int, int]:
    return Image.open(io.BytesIO(picture.png)).size


def test_every_2d_world_and_prompt_is_redrawn_as_the_run_saved_it(grid_runs: list[RunFolder]):
    assert len(grid_runs) >= 5
    for run in grid_runs:
        assert b'"fires":["fire' in run.steps_bytes() or "fires" not in run.config()["world"], run.id
        assert redrawn(run, [0, 3, 6]) == saved(run), run.id
    assert any(run.messages_bytes() for run in grid_runs)


def test_a_3d_run_is_redrawn_as_it_was_saved_whether_its_images_were_kept_or_not(camera_runs: list[RunFolder]):
    kept, unkept = camera_runs
    assert (kept.path / "images").is_dir() and not (unkept.path / "images").exists()
    assert redrawn(kept, [0, 1, 2]) == saved(kept)
    assert redrawn(unkept, [0, 1, 2]) == saved(unkept)


def test_the_inset_is_the_image_that_the_model_was_shown(camera_runs: list[RunFolder]):
    run = camera_runs[0]
    image = next((run.path / "images").glob("*0002*"))
    before = image.read_bytes()
    blank = io.BytesIO()
    Image.new("RGB", (512, 384), (0, 0, 255)).save(blank, "PNG")
    try:
        image.write_bytes(blank.getvalue())
        (drawn,) = pictures([read_recording(run)], [1], workers=1)
    finally:
        image.write_bytes(before)
    corner = np.asarray(Image.open(io.BytesIO(drawn.png)))[-100:-20, -200:-20]
    assert (corner == [0, 0, 255]).all()


@pytest.mark.slow
def test_worlds_in_which_agents_come_and_go_are_redrawn_as_they_were_saved(furnished_runs: list[RunFolder]):
    assert any(b'"left":"' in run.steps_bytes() for run in furnished_runs)
    for run in furnished_runs:
        kept = saved(run)
        assert redrawn(run, [int(name[5:9]) for name in kept]) == kept, run.id


def test_other_processes_draw_the_same_pictures_in_order(grid_runs: list[RunFolder]):
    recording = read_recording(grid_runs[0])
    steps = [0, 1, 2, 3, 4, 5, 6] * 2
    assert len(steps) > CHUNK
    here, elsewhere = (list(pictures([recording], steps, workers=count)) for count in (1, 2))
    assert here == elsewhere
    assert [one.step for one in here] == steps


def test_several_runs_are_tiled_each_below_its_caption(grid_runs: list[RunFolder]):
    recordings = [read_recording(run) for run in grid_runs[:3]]
    (sheet,) = pictures(recordings, [6], workers=1)
    (single,) = pictures(recordings[:1], [6], workers=1)
    assert size(sheet) == (1600, 2 * 862)
    tile = np.asarray(Image.open(io.BytesIO(sheet.png)))[:862, :800]
    assert (tile[62:] == np.asarray(Image.open(io.BytesIO(single.png)).convert("RGB"))).all()
    assert tile[:62].min() < 80


def test_a_run_that_is_over_keeps_its_last_state_beside_longer_ones(grid_runs: list[RunFolder]):
    longer, other = (read_recording(run) for run in grid_runs[:2])
    shorter = cut(other, 4)
    early, late = (
        np.asarray(Image.open(io.BytesIO(one.png))) for one in pictures([longer, shorter], [4, 6], workers=1)
    )
    assert (early[62:, 800:] == late[62:, 800:]).all()
    assert (early[:62, 800:] != late[:62, 800:]).any()


def cut(recording: Recording, last: int) -> Recording:
    lines = recording.steps.splitlines(keepends=True)
    agents = len(lines) // recording.last
    values = {name: getattr(recording, name) for name in ("id", "folder", "config", "episode", "note", "identity")}
    return Recording(**values, steps=b"".join(lines[: agents * last]), last=last)
