"""The 3D part of the viewer in a real browser, under the policy of the viewer's page."""

from __future__ import annotations

import contextlib
import io
import threading
from collections.abc import Iterator
from functools import lru_cache
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import pytest
from PIL import Image

from browser import browser_page, put_aside, taken_up
from episodes import Kept, composed, episode
from foundry.viewer.camera.scene_export import scene_glb
from foundry.viewer.files import static_file

pytestmark = pytest.mark.browser

if TYPE_CHECKING:
    from playwright.sync_api import Page

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'"
)
PAGE = b"""<!doctype html><meta charset="utf-8"><link rel="icon" href="icon.svg"><link rel="stylesheet" href="page.css">
<div id="box"></div><script src="camera/scene3d.js"></script><script src="page.js"></script>"""
STYLE = b"body { margin: 0 } #box { width: 400px; height: 300px }"
SIZE = (400, 300)
SCRIPT = b"""
window.mountScene = async (withScene) => {
  const { episode, steps } = await (await fetch("records.json")).json();
  const glb = withScene ? await (await fetch("scene.glb")).arrayBuffer() : null;
  window.view = await window.FoundryScene.mount(document.getElementById("box"), { glb, episode, steps });
};"""
KINDS = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".html": "text/html"}


@lru_cache(maxsize=1)
def played() -> Kept:
    return episode("kibo", "oracle", seed=0)


@lru_cache(maxsize=1)
def files() -> dict[str, bytes]:
    kept = played()
    records = {"episode": kept.opening, "steps": kept.steps}
    found = {"page.html": PAGE, "page.css": STYLE, "page.js": SCRIPT, "records.json": msgspec.json.encode(records)}
    return found | {"scene.glb": scene_glb(composed("kibo", "oracle").conditions[0].config) or b""}


def served(name: str) -> Path:
    """Return the file that the viewer serves under an address."""
    file = static_file(name)
    assert file is not None, f"the viewer serves no {name}"
    return file


class Handler(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        name = self.path.lstrip("/")
        content = files()[name] if name in files() else served(name).read_bytes()
        self.send_response(200)
        self.send_header("Content-Type", KINDS.get(Path(name).suffix, "application/octet-stream"))
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Content-Security-Policy", POLICY)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing."""


@contextlib.contextmanager
def opened(*, webgl: bool = True) -> Iterator[Page]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        with browser_page(width=SIZE[0], height=SIZE[1]) as page:
            if not webgl:
                page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
            page.goto(f"http://127.0.0.1:{server.server_port}/page.html")
            page.evaluate("mountScene(true)")
            yield page
    finally:
        server.shutdown()
        server.server_close()


@pytest.fixture(scope="module")
def mounted() -> Iterator[Page]:
    """A page with the scene, for all tests that need no other: drawing it without a graphics card takes long."""
    files()
    with opened() as page, put_aside():
        yield page


@pytest.fixture
def page(mounted: Page) -> Iterator[Page]:
    """The page as it was when the scene was mounted."""
    with taken_up():
        mounted.evaluate("window.view.dispose()")
        mounted.evaluate("mountScene(true)")
        yield mounted


def shot(page: Page) -> Any:
    """Return what is on the page as (h, w, 3), after the frame that is due is drawn."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), int)


def near(image: Any, colour: tuple[int, int, int], tolerance: int = 12) -> int:
    return int((np.abs(image - colour).max(axis=2) <= tolerance).sum())


def test_seeking_and_new_records_show_the_way_so_far_and_nothing_of_the_page_is_forbidden(page: Page):
    last = len(played().steps)
    trails = []
    for step in (0, last // 2, last):
        page.evaluate(f"view.seek({step})")
        trails.append(near(shot(page), (242, 115, 0)))
    assert trails[0] < trails[1] < trails[2]
    image = shot(page)
    red, green, blue = np.moveaxis(image, 2, 0)
    assert ((green > red + 60) & (green > blue + 25)).sum() > 10  # the target's box and pin
    assert (image.max(axis=2) < 200).sum() > 8_000  # the scene itself
    page.evaluate(
        "fetch('records.json').then((r) => r.json()).then(({ steps }) => {"
        " view.update(steps.slice(0, 2)); view.seek(99) })"
    )
    assert trails[0] < near(shot(page), (242, 115, 0)) < trails[2]
    page.evaluate("view.dispose()")
    assert page.locator("canvas").count() == 0 and page.locator(".scene3d-controls").count() == 0


def test_the_line_of_sight_to_the_target_is_whole_where_nothing_is_in_between_and_else_broken(page: Page):
    blocked, clear = (216, 27, 122), (10, 157, 88)
    steps = played().steps
    inside = next(index for index, step in enumerate(steps) if step.line_of_sight)
    page.evaluate("view.seek(0)")
    assert not steps[0].line_of_sight
    broken = shot(page)
    page.evaluate(f"view.seek({inside})")
    whole = shot(page)
    assert near(broken, blocked) > 5 and near(whole, blocked) == 0
    assert near(whole, clear) > near(broken, clear)


@pytest.mark.exhaustive
def test_through_the_agents_eyes_the_scene_is_what_the_model_was_shown(page: Page):
    step = 2
    kept = Image.open(io.BytesIO(played().images[step].content)).convert("RGB")
    page.evaluate(f"view.seek({step})")
    page.check(".scene3d-eye")
    seen = Image.fromarray(shot(page).astype(np.uint8)).resize(kept.size, Image.Resampling.BOX)
    below_the_controls = slice(kept.height // 3, None)
    difference = np.abs(np.asarray(kept, int) - np.asarray(seen, int))[below_the_controls]
    assert difference.mean() < 6 and np.percentile(difference, 90) < 20


def test_without_a_scene_the_way_is_shown_alone(page: Page):
    page.evaluate("view.dispose()")
    page.evaluate("mountScene(false)")
    page.evaluate("view.seek(3)")
    assert near(shot(page), (242, 115, 0)) > 40
    assert page.locator(".scene3d-cut").count() == 0


def test_a_browser_without_webgl_gets_a_plain_message():
    with opened(webgl=False) as page:
        assert "offers no WebGL 2" in page.inner_text(".scene3d-note")
        page.evaluate("(view.seek(1), view.resize(), view.dispose())")
        assert page.locator(".scene3d-note").count() == 0
