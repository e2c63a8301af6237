"""What is drawn again from the records is what the run saved, byte for byte."""

import dataclasses
import io
import string
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from matplotlib.font_manager import fontManager
from PIL import Image

from fonts import write_font
from foundry.palette.fonts import families, letters_by_file
from foundry.replay import pictures as drawing
from foundry.replay.pictures import Picture, pictures
from foundry.replay.recording import Recording, read_recording, redrawing_of
from foundry.replay.telling import band, band_height, boxes_note, said_by_step, width_of
from foundry.storing.store import RunFolder, frame_name
from foundry.worlds.camera.eye.overview import TEXT_PX


def saved(run: RunFolder) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in (run.path / "frames").iterdir()}


def redrawn(run: RunFolder, steps: list[int]) -> dict[str, bytes]:
    drawn = pictures([read_recording(run)], steps, workers=1)
    return {f"step_{picture.step:04d}.png": picture.png for picture in drawn}


def pixels(picture: Picture) -> Any:
    return np.asarray(Image.open(io.BytesIO(picture.png)).convert("RGB"))


@pytest.mark.slow
def test_a_2d_run_is_redrawn_as_it_was_saved(grid_runs: list[RunFolder]):
    run = grid_runs[0]
    assert b'"fires":["fire' in run.steps_bytes() and run.messages_bytes()
    assert redrawn(run, [0, 3, 6]) == saved(run)


@pytest.mark.slow
def test_a_3d_run_is_redrawn_as_it_was_saved_whether_its_images_were_kept_or_not(camera_runs: list[RunFolder]):
    run, unkept = camera_runs
    assert (run.path / "images").is_dir() and not (unkept.path / "images").exists()
    assert redrawn(run, [0, 1, 2]) == saved(run)
    assert redrawn(unkept, [0, 1, 2]) == saved(unkept)


@pytest.mark.slow
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
    corner = pixels(drawn)[-100:-20, -200:-20]
    assert (corner == [0, 0, 255]).all()


@pytest.mark.slow
def test_a_film_of_a_3d_run_says_below_its_pictures_what_was_replied(camera_runs: list[RunFolder]):
    recording = read_recording(camera_runs[0])
    told = redrawing_of(recording).told(1)
    assert told == (f"reply (chosen): {msgspec.json.decode(recording.steps.splitlines()[0])['reply']}",)
    first, second = (
        Image.open(io.BytesIO(picture.png)) for picture in pictures([recording], [0, 1], workers=1, film=True)
    )
    assert first.size == second.size
    lower = (0, first.height - band_height(2), first.width, first.height)
    inks = [np.asarray(picture.crop(lower).convert("L")).min() for picture in (first, second)]
    assert inks[0] > 200 > inks[1], "nothing was replied before the first step"


@pytest.mark.slow
def test_other_processes_draw_the_same_pictures_in_order(grid_runs: list[RunFolder], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(drawing, "CHUNK", 1)
    monkeypatch.setattr(drawing, "ALONE", 0)
    steps = [6, 0]
    elsewhere = [(picture.step, picture.png) for picture in pictures([read_recording(grid_runs[0])], steps, workers=2)]
    assert elsewhere == [(step, saved(grid_runs[0])[f"step_{step:04d}.png"]) for step in steps]


@pytest.mark.slow
def test_runs_stand_side_by_side_below_their_captions_and_one_that_is_over_keeps_its_last_state(
    grid_runs: list[RunFolder],
):
    longer, other = (read_recording(run) for run in grid_runs[:2])
    early, late = map(pixels, pictures([longer, cut(other, 4)], [4, 6], workers=1))
    assert late.shape == (860, 1600, 3) and late[:60].min() < 80
    assert (late[60:, :800] == np.asarray(Image.open(grid_runs[0].path / frame_name(6)).convert("RGB"))).all()
    assert (early[60:, 800:] == late[60:, 800:]).all()
    assert (early[:60, 800:] != late[:60, 800:]).any()


@pytest.mark.slow
def test_a_film_says_whose_run_it_is_at_which_step_and_what_was_said_to_whom(grid_runs: list[RunFolder]):
    talking = next(run for run in grid_runs if run.messages_bytes())
    recording = read_recording(talking)
    first = msgspec.json.decode(recording.messages.splitlines()[0])
    heard = [
        one["recipient"]
        for one in map(msgspec.json.decode, recording.messages.splitlines())
        if (one["step"], one["sender"]) == (first["step"], first["sender"])
    ]
    said = said_by_step(recording)[first["step"]]
    assert said[0] == f"agent {first['sender']} to {', '.join(map(str, heard))}: {first['text']}"
    assert [one for one in said if "to nobody" in one] == said[-sum("to nobody" in one for one in said) :]
    (frame,) = pictures([recording], [first["step"]], workers=1, film=True)
    (plain,) = pictures([recording], [first["step"]], workers=1)
    whole, state = pixels(frame), pixels(plain)
    assert (whole[60:860] == state).all()
    assert whole[:60].min() < 80 and whole[860:].min() < 80


@pytest.fixture
def squares(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A fallback font whose letters, two of them rare, are black squares."""
    monkeypatch.setattr(fontManager, "ttflist", list(fontManager.ttflist))
    monkeypatch.setattr("foundry.palette.fonts.FALLBACK_FONTS", ("Squares",))
    fontManager.addfont(write_font(tmp_path / "squares.ttf", "Squares", f"{string.ascii_lowercase}1:𓀀𓀁"))
    forget_fonts()
    yield
    forget_fonts()


def forget_fonts() -> None:
    for kept in (families, letters_by_file):
        kept.cache_clear()


def test_letters_that_the_usual_font_lacks_are_drawn_in_one_that_has_them_and_told_where_none_has(squares: None):
    line = np.asarray(band(["𓀀𓀁"], 200, 1).convert("L"))
    assert (line == line.min()).sum() > 2 * 0.9 * TEXT_PX**2, "two whole squares"
    assert width_of("𓀀𓀁") == 2 * TEXT_PX
    assert boxes_note(["agent 1: 𓀀", "𓀁"]) == ""
    said = boxes_note(["agent 1: 𓀀𓀂", "𓁀𓀂"])
    assert said.startswith("No font here has 𓀂𓁀, so they are drawn as boxes. Install one of ")


def cut(recording: Recording, last: int) -> Recording:
    lines = recording.steps.splitlines(keepends=True)
    agents = len(lines) // recording.last
    return dataclasses.replace(recording, steps=b"".join(lines[: agents * last]), last=last)
