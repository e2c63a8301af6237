"""What all compared models saw at one step stands in one row, whatever their number and the page's width."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from foundry.viewer.server import serving
from made_up_camera import sweep, whole
from viewer_pages import go

pytestmark = pytest.mark.browser

PLACES = "() => [...document.querySelectorAll('.pictures .seen')].map((one) => one.getBoundingClientRect().toJSON())"


def test_twelve_pictures_stand_in_one_row_of_which_a_click_makes_one_large(page: Any, tmp_path: Path):
    runs = sweep(tmp_path / "hall", [f"model {number}" for number in range(12)]).runs()
    for run in runs:
        whole(run)
    with serving(tmp_path / "hall") as server:
        go(page, server.url, f"compare/hall/{'/'.join(run.id for run in runs)}")
        page.wait_for_function("() => [...document.querySelectorAll('.seen')].every((one) => one.naturalWidth === 8)")
        page.keyboard.press("ArrowRight")
        page.wait_for_function(
            "() => [...document.querySelectorAll('.seen')].every((one) => one.src.endsWith('2.png'))"
        )
        places = page.evaluate(PLACES)
        assert len(places) == 12 and {place["top"] for place in places} == {places[0]["top"]}
        assert all(place["width"] > 80 and place["right"] <= 1280 for place in places)
        large = page.get_by_role("button", name="Large picture: model 3 ")
        large.click()
        assert large.get_attribute("aria-pressed") == "true"
        places = page.evaluate(PLACES)
        assert [place["width"] > 600 for place in places] == [number == 3 for number in range(12)]
        large.click()
        page.set_viewport_size({"width": 400, "height": 800})
        assert all(place["width"] > 140 for place in page.evaluate(PLACES))
        assert page.evaluate("() => document.querySelector('.pictures').scrollWidth > 1000")
        assert page.evaluate("() => document.documentElement.scrollWidth <= 400")
