"""What the page is told of the target in the pictures of a run is what is in them."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from foundry.storing.store import RunFolder, SweepFolder
from foundry.viewer.export import export
from foundry.viewer.resources import Resources


def told(folder: Path, run: RunFolder, what: str) -> dict[str, Any]:
    resources = Resources(folder)
    found: dict[str, Any] = json.loads(resources.get(f"run/{folder.name}/{run.id}/{what}").content)
    resources.close()
    return found


def test_a_target_in_view_is_marked_on_its_pixels_and_elsewhere_its_direction_is_told(rooms: SweepFolder):
    beside = rooms.runs()[0]
    steps, sights = told(rooms.path, beside, "frames/0")["steps"], told(rooms.path, beside, "sights/0")["sights"]
    assert len(steps) == len(sights) == 8
    places = [sight["place"] for sight in sights]
    assert places == ["seen" if step["target_visible_px"] else "outside" for step in steps]
    assert {"seen", "outside"} <= set(places)
    for step, sight in zip(steps, sights, strict=True):
        assert (sight["spot"] is not None) == (sight["place"] == "seen")
        if sight["spot"]:
            image = np.asarray(Image.open(beside.path / step["image"]).convert("RGB"), int)
            column, row = (np.array(sight["spot"]) * (96, 72)).astype(int)
            red, green, _ = image[row, column]
            assert red > 1.5 * green
    turns = [sight["turn"] for sight in sights]
    assert np.allclose(np.diff(np.unwrap(turns, period=360)), -45)


def test_behind_a_wall_it_is_hidden_and_that_a_reply_claims_to_see_it_is_told(rooms: SweepFolder):
    beside, behind = (told(rooms.path, run, "sights/0")["sights"] for run in rooms.runs())
    assert {sight["place"] for sight in behind} == {"hidden", "outside"}
    assert all(sight["spot"] is None for sight in behind)
    assert all(sight["claimed"] for sight in behind) and not any(sight["claimed"] for sight in beside)


def test_the_plan_is_that_of_the_walls_and_of_what_is_half_as_high_as_the_body(rooms: SweepFolder):
    walls = np.array(told(rooms.path, rooms.runs()[0], "plan")["walls"])
    between = walls[(walls[..., 0] == 3.9).all(axis=1), :, 1]
    assert np.ptp(between, axis=1).sum() == 4 and (between.min(), between.max()) == (0, 4)
    box = walls[((walls >= (6.8, 0.6)) & (walls <= (7.4, 1.2))).all(axis=(1, 2))]
    assert np.hypot(*np.ptp(box, axis=1).T).sum() == pytest.approx(4 * 0.6)
    assert not ((walls > (2.0, 2.6)) & (walls < (2.3, 2.9))).all(axis=2).any(), "a stool is low"


def test_a_run_that_begins_at_another_height_has_a_plan_of_its_own(rooms: SweepFolder, tmp_path: Path):
    folder = SweepFolder.open(shutil.copytree(rooms.path, tmp_path / "rooms"))
    first, second = folder.runs()
    facts = json.loads(second.stream_path("episode").read_text(encoding="utf-8"))
    facts["start"]["z"] += 100
    second.stream_path("episode").write_text(json.dumps(facts) + "\n", encoding="utf-8")
    assert told(folder.path, first, "plan")["walls"] != told(folder.path, second, "plan")["walls"]


def test_without_the_scenes_file_it_is_told_why_nothing_is_marked(rooms: SweepFolder, tmp_path: Path):
    moved = SweepFolder.open(shutil.copytree(rooms.path, tmp_path / "moved"))
    scene = Path(str(moved.runs()[0].config()["world"]["scene"]["asset"]))
    scene.rename(tmp_path / "rooms.usda")
    try:
        found = told(moved.path, moved.runs()[1], "sights/0")
    finally:
        (tmp_path / "rooms.usda").rename(scene)
    assert found["target"] is None and str(scene) in found["why"]
    assert found["sights"] == [{"claimed": True}] * 8


def test_an_export_holds_the_sights(rooms: SweepFolder, tmp_path: Path):
    exported = export(rooms.path, tmp_path / "page")
    runs = exported.page.parent / "data" / "run" / rooms.path.name
    parts = ("plan.js", "sights/0.js")
    assert all((runs / run.id / part).is_file() for run in rooms.runs() for part in parts)
