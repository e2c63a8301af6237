"""All ways of compared runs stand in one plan of their scene, with the target and the line of sight to it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from viewer_pages import go

pytestmark = pytest.mark.browser

INKED = """(place) => {
  const {overlay} = Foundry.page, {canvas} = overlay, [x, y] = overlay.at(place);
  const scale = canvas.width / canvas.clientWidth;
  const {data} = canvas.getContext("2d").getImageData(scale * x - 3, scale * y - 3, 7, 7);
  return [...data].filter((value, index) => index % 4 === 3 && value > 40).length;
}"""


def test_walls_target_and_every_way_are_where_they_are(page: Any, rooms: SweepFolder, tmp_path: Path):
    exported = export(rooms.path, tmp_path / "page").page.as_uri()
    go(page, exported, f"compare/{rooms.path.name}/{'/'.join(run.id for run in rooms.runs())}")
    page.wait_for_function("() => Foundry.page.overlay.walls.length && Foundry.page.overlay.targets.length === 2")
    page.wait_for_selector(".runs-legend >> text=/x 5.5 m, y 2 m, in line of sight of green box/")
    page.wait_for_selector(".runs-legend >> text=/x 2 m, y 2 m, no line of sight to green box/")
    for wall, target, stands in (([3.9, 1], [7.1, 0.9], [5.5, 2]), ([4.1, 2.4], [6.9, 1.1], [2, 2])):
        assert all(page.evaluate(INKED, place) for place in (wall, target, stands))
    assert not page.evaluate(INKED, [3, 0.4])
    across, up, origin = page.evaluate("() => [[1, 0], [0, 1], [0, 0]].map(Foundry.page.overlay.at)")
    assert across[0] > origin[0] and up[1] < origin[1]


def test_the_way_and_the_target_of_a_run_that_begins_later_are_taken_up(page: Any, rooms: SweepFolder, tmp_path: Path):
    folder = Path(shutil.copytree(rooms.path, tmp_path / "sweep"))
    first, second = SweepFolder.open(folder).runs()
    second.path.rename(tmp_path / "later")
    with serving(folder) as server:
        go(page, server.url, f"compare/sweep/{first.id}/{second.id}")
        page.wait_for_function("() => Foundry.page.overlay.targets[0] && !Foundry.page.overlay.targets[1]")
        assert "no record" in page.text_content(".runs-legend li:nth-child(2)")
        (tmp_path / "later").rename(second.path)
        page.wait_for_function("() => Foundry.page.overlay.targets[1]")
        page.keyboard.press("Home")
        page.wait_for_selector(".runs-legend li:nth-child(2) >> text=/x 2 m, y 2 m, no line of sight to green box/")
