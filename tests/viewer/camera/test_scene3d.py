"""The scene of a 3D run in a real browser."""

import asyncio
import contextlib
import io
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
import pytest
from PIL import Image

from browser import browser_page, put_aside, taken_up
from episodes import composed, recorded
from foundry.records import CameraStep
from foundry.storing.store import RunFolder
from foundry.viewer.server import ViewServer, serving
from viewer_pages import go

pytestmark = pytest.mark.browser

TRAIL, BLOCKED, CLEAR = (242, 115, 0), (216, 27, 122), (10, 157, 88)
NO_SCENE = "() => { Foundry.source.bytes = async () => new ArrayBuffer(0); }"
NO_WEBGL = """() => {
  const {getContext} = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function(kind, ...more) {
    return kind.startsWith('webgl') ? null : getContext.call(this, kind, ...more);
  };
}"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    folder = tmp_path_factory.mktemp("scene") / "sweep"
    return asyncio.run(recorded(folder, [composed("kibo", "oracle", "seed=0")])).runs()[0]


@pytest.fixture(scope="module")
def served(run: RunFolder) -> Iterator[ViewServer]:
    with serving(run.path.parent.parent) as server:
        yield server


@contextlib.contextmanager
def opened(run: RunFolder, served: ViewServer, before: str = "() => null") -> Iterator[Any]:
    with browser_page(width=1000, height=800) as page:
        go(page, served.url, f"run/sweep/{run.id}")
        page.evaluate(before)
        page.keyboard.press("v")
        page.wait_for_function("() => Foundry.page.scene.mounted")
        yield page
        page.goto("about:blank")


@pytest.fixture(scope="module")
def mounted(run: RunFolder, served: ViewServer) -> Iterator[Any]:
    """A page with the scene, for all tests that need no other: drawing it without a graphics card takes long."""
    with opened(run, served) as page, put_aside():
        yield page


@pytest.fixture
def page(mounted: Any) -> Iterator[Any]:
    with taken_up():
        yield mounted


def shot(page: Any, step: int) -> Any:
    """Return what is in the scene after a step as (h, w, 3), after the frame that is due is drawn."""
    page.evaluate(f"Foundry.page.scene.mounted.seek({step})")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return np.asarray(Image.open(io.BytesIO(page.locator(".scene").screenshot())).convert("RGB"), int)


def near(image: Any, colour: tuple[int, int, int], tolerance: int = 12) -> int:
    return int((np.abs(image - colour).max(axis=2) <= tolerance).sum())


def test_seeking_and_new_records_show_the_way_so_far(page: Any, run: RunFolder):
    last = run.summary().counts.calls
    images = [shot(page, step) for step in (0, last // 2, last)]
    trails = [near(image, TRAIL) for image in images]
    assert trails[0] < trails[1] < trails[2]
    red, green, blue = np.moveaxis(images[-1], 2, 0)
    assert ((green > red + 60) & (green > blue + 25)).sum() > 10  # the target's box and pin
    assert (images[-1].max(axis=2) < 200).sum() > 8_000  # the scene itself
    page.evaluate("Foundry.page.scene.mounted.update(Foundry.page.scene.steps.slice(0, 2))")
    assert trails[0] < near(shot(page, 99), TRAIL) < trails[2]
    page.evaluate("Foundry.page.scene.mounted.update(Foundry.page.scene.steps)")


def test_the_line_of_sight_to_the_target_is_whole_where_nothing_is_in_between_and_else_broken(
    page: Any, run: RunFolder
):
    seen = [msgspec.json.decode(line, type=CameraStep).line_of_sight for line in run.steps_bytes().splitlines()]
    assert not seen[0]
    broken, whole = shot(page, 0), shot(page, seen.index(True))
    assert near(broken, BLOCKED) > 5 and near(whole, BLOCKED) == 0
    assert near(whole, CLEAR) > near(broken, CLEAR)


def test_without_a_scene_the_way_is_shown_alone(run: RunFolder, served: ViewServer):
    with opened(run, served, NO_SCENE) as page:
        assert near(shot(page, 3), TRAIL) > 40
        assert page.locator(".scene3d-cut").count() == 0


def test_a_browser_without_webgl_gets_a_plain_message(run: RunFolder, served: ViewServer):
    with opened(run, served, NO_WEBGL) as page:
        assert "offers no WebGL 2" in page.inner_text(".scene3d-note")
        page.evaluate("Foundry.page.scene.mounted.seek(1)")
