"""The page of a 3D run, of records made up here: no scene's file, so that the way is shown alone."""

from pathlib import Path
from typing import Any

import pytest

from foundry.records import Outcome
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from made_up_camera import begin, play, sweep, whole
from made_up_runs import HOSTILE
from viewer_pages import go

pytestmark = pytest.mark.browser


@pytest.fixture
def hall(tmp_path: Path) -> SweepFolder:
    return sweep(tmp_path / "hall")


def test_a_decision_is_shown_beside_the_image_that_the_model_saw(page: Any, hall: SweepFolder):
    whole(hall.runs()[0], outcome=Outcome.UNREADABLE, reply=HOSTILE)
    with serving(hall.path) as server:
        go(page, server.url, f"run/hall/{hall.runs()[0].id}")
        page.wait_for_function("() => document.querySelector('.seen').naturalWidth === 8")
        page.wait_for_function("() => Foundry.page.plan.poses[0].length === 4")
        assert page.get_by_label("What the model saw").is_visible() and page.locator("canvas.ways").is_visible()
        assert page.locator(".scene").is_hidden() and page.evaluate("() => !Foundry.page.scene.steps")
        page.keyboard.press("v")
        page.wait_for_function("() => document.querySelector('.scene').childElementCount > 0")
        assert page.locator("canvas.ways").is_hidden()
        assert page.locator(".tabs [aria-pressed=true]").all_text_contents() == ["Whole scene"]
        page.get_by_role("button", name="Image and plan").click()
        assert page.locator(".scene").is_hidden()
        assert "Find door <b> in hall" in page.text_content(".goal")
        assert "move 1 m forward" in page.text_content(".decision")
        page.wait_for_function("() => Foundry.page.data.marked === 3")
        page.keyboard.press("x")
        page.wait_for_selector(".decision .is-unreadable")
        assert "<script>window.hacked = 1</script>" in page.text_content(".decision .reply")
        page.keyboard.press("b")
        page.wait_for_selector("text=The image of this step was not stored.")
        assert page.text_content(".where") == "step 3 of 3"
        assert page.locator("canvas.ways").get_attribute("aria-label").startswith("The route from above, step 3")
        assert page.evaluate("() => window.hacked") is None
        go(page, server.url, f"run/hall/{hall.runs()[0].id}?camera=1,2,3")
        page.wait_for_selector(".scene")


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
    page.wait_for_selector("[data-lane='path so far (m)']", state="attached")
    page.wait_for_function("() => document.querySelector('.sentence').textContent.startsWith('Step 2')")
    page.wait_for_function("() => Foundry.page.overlay.poses.every((poses) => poses.length > 2)")
    assert "read as: turn 30° left" in page.locator(".read").nth(1).text_content()
    assert "first x " in page.text_content("[aria-label='All routes from above']")
    page.wait_for_function("() => document.querySelectorAll('.column')[1]?.textContent.includes('turn 30° left')")
    page.wait_for_function("() => [...document.querySelectorAll('.seen')].every((one) => one.naturalWidth === 8)")
