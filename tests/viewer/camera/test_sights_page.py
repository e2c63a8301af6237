"""The target is marked in the image that the model saw, and below it stands what was read of the reply."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from viewer_pages import go

pytestmark = pytest.mark.browser

GREEN = "([red, green, blue]) => green > 200 && red < 120 && blue < 200"
INK = "([red, green, blue]) => red === 16 && green === 22 && blue === 29"
AMBER = "([red, green, blue]) => red > 230 && green > 180 && blue < 120"


MARKS = "Foundry.page.image.marks"
TAKEN_AWAY = "Foundry.page.moment.picture([new Map()])"


def marked(page: Any, colour: str, canvas: str = MARKS) -> list[float] | None:
    """Return where a drawing has a colour: left, top, right and bottom as shares of it, or None where it has none."""
    found: list[float] | None = page.evaluate(
        f"""() => {{
          const drawing = {canvas}, {{width, height}} = drawing, is = {colour};
          const {{data}} = drawing.getContext("2d").getImageData(0, 0, width, height);
          const inked = (i) => data[4 * i + 3] > 200 && is(data.slice(4 * i, 4 * i + 3));
          const at = [...Array(width * height).keys()].filter(inked);
          const x = at.map((i) => (i % width) / width), y = at.map((i) => Math.floor(i / width) / height);
          const ends = (all) => [all.reduce((a, b) => Math.min(a, b)), all.reduce((a, b) => Math.max(a, b))];
          return at.length ? [ends(x)[0], ends(y)[0], ends(x)[1], ends(y)[1]] : null;
        }}"""
    )
    return found


def test_from_a_file_the_target_is_boxed_where_it_is_seen_and_pointed_at_where_it_is_not(
    page: Any, rooms: SweepFolder, tmp_path: Path
):
    exported = export(rooms.path, tmp_path / "page").page.as_uri()
    beside, behind = rooms.runs()
    go(page, exported, f"run/{rooms.path.name}/{beside.id}")
    page.wait_for_selector(".read >> text=px in view, in line of sight")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector(".read >> text=/not in the picture, \\d+° right, \\d+° down, nothing in between/")
    arrow = marked(page, AMBER)
    assert arrow is not None and arrow[2] > 0.9 and marked(page, GREEN) is None
    page.keyboard.press("End")
    page.wait_for_selector(".read >> text=px in view, in line of sight")
    page.wait_for_function("() => Foundry.page.image.sight?.boxes.length")
    (((left, top), (right, bottom)),) = page.evaluate("() => Foundry.page.image.sight.boxes")
    found = marked(page, GREEN)
    assert (
        found is not None and found[2] == pytest.approx(right, abs=0.02) and found[3] == pytest.approx(bottom, abs=0.02)
    )
    assert found[0] == pytest.approx(left, abs=0.02) and found[1] <= top
    page.get_by_role("button", name="picture (PNG)").click()
    page.wait_for_selector(".moment >> text=No picture can be taken here")
    assert marked(page, AMBER) is None
    page.uncheck(".marking input")
    assert marked(page, GREEN) is None
    go(page, exported, f"run/{rooms.path.name}/{behind.id}")
    page.wait_for_selector(".read >> text=says it sees it, and it is not in view")
    assert marked(page, AMBER) is not None and marked(page, GREEN) is None


def test_a_picture_that_is_taken_away_holds_the_marks_and_what_was_read(page: Any, rooms: SweepFolder):
    with serving(rooms.path) as server:
        go(page, server.url, f"run/{rooms.path.name}/{rooms.runs()[0].id}?step=8")
        page.wait_for_function("() => Foundry.page.image.sight?.boxes.length && Foundry.page.image.image.naturalWidth")
        assert marked(page, GREEN, TAKEN_AWAY) is not None
        page.uncheck(".marking input")
        assert marked(page, GREEN, TAKEN_AWAY) is None
        read = marked(page, INK, TAKEN_AWAY)
        assert read is not None and read[3] - read[1] < 0.06, "one line, on ink"
