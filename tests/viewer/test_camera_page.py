"""The page of a 3D run, of records made up here: no scene's file, so that the way is shown alone."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import msgspec
import pytest
from PIL import Image

from foundry.declared import Declared, keys_of
from foundry.expansion import Condition, expand
from foundry.records import CameraEpisode, CameraStep, Outcome, Pose, SeenImage
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from made_up_runs import HOSTILE, summary
from viewer_pages import go

pytestmark = pytest.mark.browser

CAMERA = Declared(form="camera", streams=keys_of((CameraStep, CameraEpisode, SeenImage)))
WORLD = {"name": "hall", "steps": 3, "scene": None, "camera": {}, "body": {}, "targets": []}


def pose(number: int) -> Pose:
    return Pose(x=float(number), y=0.0, z=0.0, yaw=90.0, pitch=0.0)


def episode() -> CameraEpisode:
    return CameraEpisode(
        scene="hall", scene_sha256="0" * 64, renderer="none", target="door <b>", target_prims=("/Door",),
        target_label=None, radius=1.0, start=pose(0), shortest_path=[], shortest_m=None, walkable_cells=9, cell_m=0.1,
    )  # fmt: skip


def step(number: int, **changes: Any) -> CameraStep:
    fields: dict[str, Any] = {
        "step": number, "agent": 0, "pose": pose(number - 1), "pose_next": pose(number), "reply": f"I go on, {number}.",
        "command": {"translate": {"bearing": 0.0, "distance": 1.0}, "turn": None, "gaze": None, "stay": False},
        "notes": ("translate: 'go on'",), "outcome": Outcome.CHOSEN, "boundary": None, "travelled": 1.0,
        "image": f"images/step_{number:04d}.png", "image_sha256": "1" * 64, "inference_s": 0.5, "distance_before": None,
        "distance_to_goal": 2.0, "visited_cells": number, "target_visible_px": 0, "visible_px": {"wall": 10},
        "line_of_sight": False, "success": False,
    }  # fmt: skip
    return CameraStep(**(fields | changes))


def png(number: int) -> bytes:
    file = BytesIO()
    Image.new("RGB", (8, 6), (80 * number, 0, 0)).save(file, "PNG")
    return file.getvalue()


def begin(folder: RunFolder) -> RunWriter:
    writer = RunWriter(folder, msgspec.json.encode(folder.config()).decode())
    writer.append([episode()])
    return writer


def play(writer: RunWriter, number: int, **changes: Any) -> None:
    writer.append([SeenImage(path=f"images/step_{number:04d}.png", content=png(number)), step(number, **changes)])


@pytest.fixture
def hall(tmp_path: Path) -> SweepFolder:
    conditions = [
        Condition(
            factors={"model": model}, seeds=(0,), declared=CAMERA,
            config={"world": WORLD, "model": {"name": model}, "prompt": {"name": "paper3d"}, "sampling_seed": None},
        )
        for model in ("first", "second")
    ]  # fmt: skip
    return SweepFolder.create(tmp_path / "hall", expand(["-m"], conditions), {}, [])


def whole(folder: RunFolder, **changes: Any) -> None:
    writer = begin(folder)
    play(writer, 1)
    play(writer, 2, **changes)
    play(writer, 3, image=None, boundary="wall")
    writer.close()
    write_run_summary(folder, summary(folder, writer.counts, None))


def test_a_decision_is_shown_beside_the_image_that_the_model_saw(page: Any, hall: SweepFolder):
    whole(hall.runs()[0], outcome=Outcome.UNREADABLE, reply=HOSTILE)
    with serving(hall.path) as server:
        go(page, server.url, f"run/hall/{hall.runs()[0].id}")
        page.wait_for_function("() => document.querySelector('.seen').naturalWidth === 8")
        page.wait_for_function("() => document.querySelector('.scene').childElementCount > 0")
        assert "Find door <b> in hall" in page.text_content(".goal")
        assert "translate 1 m towards 0°" in page.text_content(".decision")
        page.wait_for_function("() => Foundry.page.data.marked === 3")
        page.keyboard.press("x")
        page.wait_for_selector(".decision .is-unreadable")
        assert "<script>window.hacked = 1</script>" in page.text_content(".decision .reply")
        page.click("[data-jump=boundary]")
        page.wait_for_selector("text=The image of this step was not kept.")
        assert page.text_content(".where") == "step 3 of 3"
        assert page.evaluate("() => window.hacked") is None


def test_a_page_follows_a_3d_run_while_it_is_written(page: Any, hall: SweepFolder):
    writer = begin(hall.runs()[0])
    play(writer, 1)
    with serving(hall.path) as server:
        go(page, server.url, f"run/hall/{hall.runs()[0].id}")
        play(writer, 2)
        page.wait_for_function("() => document.querySelector('.where').textContent === 'step 1 of 2'")
        page.keyboard.press("ArrowRight")
        page.wait_for_function("() => document.querySelector('.seen').src.endsWith('step_0002.png')")
        writer.close()
        page.goto("about:blank")


def test_3d_runs_are_compared_and_exported(page: Any, hall: SweepFolder, tmp_path: Path):
    whole(hall.runs()[0])
    whole(hall.runs()[1], command={"translate": None, "turn": 30.0, "gaze": None, "stay": False}, reply="I turn.")
    exported = export(hall.path, tmp_path / "page")
    runs = "/".join(run.id for run in hall.runs())
    go(page, exported.page.as_uri(), f"compare/hall/{runs}")
    page.wait_for_selector(".verdict .go")
    assert "First action or position that differs: step 2" in page.text_content(".verdict")
    page.click(".verdict .go >> nth=0")
    page.wait_for_function("() => document.querySelectorAll('.column')[1]?.textContent.includes('turn 30°')")
    page.wait_for_function("() => [...document.querySelectorAll('.seen')].every((one) => one.naturalWidth === 8)")
