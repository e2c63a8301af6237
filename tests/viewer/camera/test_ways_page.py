"""What 3D runs saw in one row, their ways in one plan, where the target was, what was told and asked."""

from pathlib import Path
from typing import Any

import pytest

from browser import put_aside
from foundry.cli import run
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from labelled_rooms import TINY, write_rooms
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


def test_from_a_file_it_is_told_where_the_target_is_and_what_a_reply_claims_of_it(
    page: Any, rooms: SweepFolder, tmp_path: Path
):
    exported = export(rooms.path, tmp_path / "page").page.as_uri()
    beside, behind = rooms.runs()
    go(page, exported, f"run/{rooms.path.name}/{beside.id}")
    page.wait_for_selector(".read >> text=px in view, in line of sight")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector(".read >> text=/not in the picture, \\d+° right, \\d+° down, nothing in between/")
    page.keyboard.press("End")
    page.wait_for_selector(".read >> text=px in view, in line of sight")
    page.wait_for_function("() => Foundry.page.image.sight?.boxes.length")
    go(page, exported, f"run/{rooms.path.name}/{behind.id}")
    page.wait_for_selector(".read >> text=claims to see the target, but the target is not in view")


def played(rooms: Path, world: str, model: str) -> SweepFolder:
    scene = write_rooms(rooms / "rooms.usda")
    asked = [f"world={world}", f"scene='{scene}'", f"model=scripted/{model}", "seed=1", *TINY]
    with put_aside():
        assert run([*asked, "output.dir=sweep", "analyze=false", "runner.workers=1"]) == 0
    return SweepFolder.open(rooms / "sweep")


def test_a_told_way_stands_above_the_run_in_both_languages(page: Any, workspace: Path):
    sweep = played(workspace, "follow", "oracle")
    with serving(sweep.path) as server:
        go(page, server.url, f"run/sweep/{sweep.runs()[0].id}")
        page.wait_for_selector(".told-way")
        shown = page.text_content(".goal")
        assert "Told in english: " in shown and "Told in japanese: " in shown and "Stop at the " in shown
        page.wait_for_function("() => document.querySelector('.seen').naturalWidth === 96")


def test_a_question_is_shown_with_its_choices_and_answers_and_its_walk_is_exported(page: Any, workspace: Path):
    sweep = played(workspace, "map_probe", "knower")
    with serving(sweep.path) as server:
        go(page, server.url, f"run/sweep/{sweep.runs()[0].id}")
        page.wait_for_selector(".decision .question")
        shown = page.text_content(".decision")
        assert "Question: nearer" in shown and "Which of the two is nearer" in shown and "A: " in shown
        assert "right answer" in shown and "answer " in shown
        assert "Questions after a walk in rooms." in page.text_content(".goal")
        loaded = (
            "() => [...document.querySelectorAll('.walk img')].filter((one) => one.naturalWidth === 96).length === 8"
        )
        page.wait_for_function(loaded)
        page.wait_for_function("() => document.querySelector('.seen').naturalWidth === 96")
    exported = export(sweep.path, workspace / "page")
    kept = sorted(file.name for file in exported.page.parent.rglob("walk_*.png"))
    assert kept == [f"walk_{number:04d}.png" for number in range(1, 9)]
