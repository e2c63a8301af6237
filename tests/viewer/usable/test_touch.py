"""The pages under fingers, as on a telephone."""

from collections.abc import Iterator, Sequence
from typing import Any

import pytest

from browser import browser_page
from viewer.usable.conftest import Forms
from viewer_pages import go

pytestmark = pytest.mark.browser

Place = tuple[float, float]
SEEN = """wanted => {
  const {zoom, centre} = Foundry.page.grid;
  return [zoom, ...centre].every((one, index) => Math.abs(one - wanted[index]) < 0.2);
}"""


@pytest.fixture(scope="module")
def telephone(forms: Forms) -> Iterator[Any]:
    with browser_page(width=400, height=800, touch=True) as page:
        go(page, forms.server.url, f"{forms.run('grid')}?step=2")
        page.wait_for_function("() => Foundry.page.grid.spots && Foundry.page.data.marked === 6")
        page.session = page.context.new_cdp_session(page)
        yield page


def in_sight(page: Any, selector: str) -> dict[str, float]:
    page.locator(selector).scroll_into_view_if_needed()
    return dict(page.locator(selector).bounding_box())


def swipe(page: Any, *ways: Sequence[Place]) -> None:
    """Move fingers over the page at once, each from place to place."""
    touch = page.session.send
    for number, places in enumerate(zip(*ways, strict=True)):
        points = [{"x": x, "y": y, "id": finger} for finger, (x, y) in enumerate(places)]
        touch("Input.dispatchTouchEvent", {"type": "touchMove" if number else "touchStart", "touchPoints": points})
    touch("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_a_tap_chooses_an_agent(telephone: Any):
    box = in_sight(telephone, "canvas.grid")
    x, y = telephone.evaluate("() => Foundry.page.grid.spots[2]")
    telephone.touchscreen.tap(box["x"] + x, box["y"] + y)
    telephone.wait_for_function("() => Foundry.page.agent === 2")
    telephone.wait_for_selector(".inspector .facts")


def sees(page: Any, zoom: float, x: float, y: float) -> None:
    """Wait until the map is seen so; fingers are followed frame by frame."""
    page.wait_for_function(SEEN, arg=[zoom, x, y])


def test_two_fingers_zoom_where_they_are_and_one_then_shifts(telephone: Any):
    box = in_sight(telephone, "canvas.grid")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    swipe(telephone, *([(x + side * away, y) for away in (20, 40, 60, 80)] for side in (-1, 1)))
    sees(telephone, 4, 0, 0)
    cell = telephone.evaluate("() => Foundry.page.grid.cell")
    before = telephone.evaluate("() => scrollY")
    swipe(telephone, [(x, y), (x, y - 30), (x, y - 60)])
    sees(telephone, 4, 0, -60 / cell)
    assert telephone.evaluate("() => scrollY") == before, "the map moves, not the page"
    telephone.click("[aria-label='Whole grid']")  # a tap that a busy machine draws out is a long press
    sees(telephone, 1, 0, 0)
