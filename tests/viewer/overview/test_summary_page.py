"""What was found of each group, above the runs of a sweep."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer, serving
from made_up_runs import Playing, sweep, whole_run
from viewer_pages import go

pytestmark = pytest.mark.browser

FOUND = """measure,model,baseline,runs,n,mean,sd,low,high,interval,note
path.success,first,False,2,2,0.5,0.1,0.25,0.75,t,
path.success,second,False,2,2,0.125,0.0,,,,no variation
path.success,random,True,2,2,0.1,0.1,0,0.2,t,
"""
VALUES = "run,model,path.length,path.success\n{},first,9,0.4\n{},first,8,0.6\n{},second,7,0.125\n{},second,6,0.125\n"


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Two models and two seeds with a table of groups; one measure of claims, one of none."""
    made = sweep(tmp_path_factory.mktemp("groups") / "groups")
    for run in made.runs():
        whole_run(run)
    write_tables(made)
    return made


def write_tables(made: SweepFolder) -> None:
    made.analysis_dir.mkdir()
    made.signatures_path.write_text(VALUES.format(*(run.id for run in made.runs())), encoding="utf-8")
    for name, text in {"comparison": FOUND, "contrasts": "measure,headline\npath.success,True\n"}.items():
        (made.analysis_dir / f"{name}.csv").write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def groups(analysed: SweepFolder) -> Iterator[ViewServer]:
    with serving(analysed.path) as running:
        yield running


def texts(page: Any, selector: str) -> list[str]:
    found: list[str] = page.locator(selector).all_text_contents()
    return found


def test_a_click_on_a_group_leaves_its_runs_and_another_brings_all_back(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.click(".groups button >> text=second")
    wait_rows(page, 2)
    assert page.url.endswith("?group=second")
    assert page.locator(".groups [aria-pressed=true]").count() == 1
    page.click(".groups [aria-pressed=true]")
    wait_rows(page, 4)


def test_a_group_has_its_mean_interval_and_a_stroke_for_each_seed(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector(".groups")
    assert texts(page, ".groups tbody td") == ["0.5 n = 2 0.25 to 0.75", "0.125 n = 2", "0.1 n = 2 0 to 0.2"]
    assert texts(page, ".groups tbody th")[2] == "random (baseline)"
    strokes = page.eval_on_selector_all(".strip", "all => all.map((one) => one.querySelectorAll('.seed').length)")
    assert strokes == [2, 1, 0]
    places = page.eval_on_selector_all(".strip circle", "all => all.map((one) => Number(one.getAttribute('cx')))")
    assert places[2] < places[1] < places[0]
    colours = page.eval_on_selector_all(".strip circle", "all => all.map((one) => one.getAttribute('fill'))")
    assert len(set(colours)) == 3


def test_measures_that_claims_rest_on_are_columns_at_first(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector("[data-sort='path.success']")
    assert page.locator("[data-sort='path.length']").count() == 0
    page.click("summary >> text=columns")
    page.locator("label", has_text="path.length").locator("input").check()
    page.wait_for_selector("[data-sort='path.length']")
    page.go_back()
    page.wait_for_selector("[data-sort='path.length']", state="detached")


def test_groups_are_there_once_the_analysis_is(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "later")
    for run in made.runs():
        whole_run(run)
    with serving(made.path) as server:
        go(page, server.url, "sweep/later")
        page.wait_for_selector("tbody tr[data-run]")
        assert page.locator(".groups").count() == 0
        write_tables(made)
        page.evaluate("() => Foundry.page.load()")
        page.wait_for_selector(".groups")
        page.goto("about:blank")


def test_a_box_around_points_leaves_their_runs(page: Any, groups: ViewServer, analysed: SweepFolder):
    go(page, groups.url, "sweep/groups?x=path.length&y=path.success")
    page.click("summary >> text=two measures")
    page.wait_for_selector("canvas[aria-label^='path.success against path.length: 4 runs, 4']")
    page.locator("canvas.scatter").scroll_into_view_if_needed()
    box = page.locator("canvas.scatter").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] - 2, box["y"] + box["height"] * 0.7)
    page.mouse.up()
    page.wait_for_selector("canvas[aria-label$='2 of them in the table']")
    assert rows(page) == [run.id for run in analysed.runs()[:2]]
    page.reload()
    page.wait_for_selector("canvas[aria-label$='2 of them in the table']")
    page.click("text=All runs ✕")
    page.wait_for_selector("canvas[aria-label$='4 of them in the table']")


def test_the_keyboard_moves_and_sizes_the_box_and_escape_ends_it(page: Any, groups: ViewServer, analysed: SweepFolder):
    go(page, groups.url, "sweep/groups?x=path.length&y=path.success")
    page.click("summary >> text=two measures")
    page.wait_for_selector("canvas[aria-label$='4 of them in the table']")
    page.focus("canvas.scatter")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("canvas[aria-label$='0 of them in the table']")
    for _ in range(5):
        page.keyboard.press("ArrowUp")
    left, right, low, high = box_of(page)
    for _ in range(10):
        page.keyboard.press("Shift+ArrowRight")
    wider = box_of(page)
    assert wider[0] == left and wider[1] > right and wider[2:] == [low, high]
    page.wait_for_selector("canvas[aria-label$='2 of them in the table']")
    assert rows(page) == [run.id for run in analysed.runs()[:2]]
    assert page.evaluate("() => document.activeElement.className") == "scatter"
    page.keyboard.press("Escape")
    page.wait_for_selector("canvas[aria-label$='4 of them in the table']")
    page.go_back()
    page.wait_for_selector("canvas[aria-label$='2 of them in the table']")


def box_of(page: Any) -> list[float]:
    found: list[float] = page.evaluate("() => Foundry.Scatter.box(Foundry.address.read().get('box'))")
    return found


def test_a_click_on_a_point_ticks_its_run_and_a_tick_frames_the_point(
    page: Any, groups: ViewServer, analysed: SweepFolder
):
    go(page, groups.url, "sweep/groups?x=path.length&y=path.success")
    page.click("summary >> text=two measures")
    page.wait_for_selector("canvas[aria-label$='4 of them in the table']")
    before, x, y = page.evaluate(FRAMED)
    assert before == 0
    page.locator("canvas.scatter").click(position={"x": x, "y": y})
    tick = f"[aria-label='Compare {analysed.runs()[2].id}']"
    page.wait_for_function("tick => document.querySelector(tick).checked", arg=tick)
    assert page.evaluate(FRAMED)[0] > 0
    page.uncheck(tick)
    page.wait_for_function(f"() => ({FRAMED})()[0] === 0")


def test_points_have_the_colour_of_their_model_and_the_shape_of_their_world(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups?x=path.length&y=path.success&box=0,10,0,1")
    page.wait_for_selector(".scatter-box .sign")
    page.evaluate("() => { Foundry.page.rows[0].world = 'elsewhere'; Foundry.page.drawScatter(); }")
    assert texts(page, ".scatter-box .sign")[:2] == [" first", " second"]
    marks = "all => all.map((one) => [one.getAttribute('d'), one.getAttribute('fill')])"
    first, second, here, elsewhere = page.eval_on_selector_all(".scatter-box .sign path", marks)
    assert first[1] != second[1] and first[0] == second[0] == here[0] != elsewhere[0]


FRAMED = """() => {
  const {points, scales, canvas} = Foundry.page.scatter, {a, b} = points[2];
  const [x, y] = [scales.x.place(a), scales.y.place(b)];
  return [canvas.getContext('2d').getImageData(x - 8, y, 1, 1).data[3], x, y];
}"""


SUCCESS = "[aria-label='Values of path.success']"


def rows(page: Any) -> list[str]:
    found: list[str] = page.eval_on_selector_all("tbody tr[data-run]", "all => all.map((one) => one.dataset.run)")
    return found


def wait_rows(page: Any, count: int) -> None:
    page.wait_for_function("count => document.querySelectorAll('tbody tr[data-run]').length === count", arg=count)


def test_bars_of_a_column_that_are_dragged_over_leave_their_runs(page: Any, groups: ViewServer, analysed: SweepFolder):
    first, second = [run.id for run in analysed.runs()[:2]], [run.id for run in analysed.runs()[2:]]
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector(SUCCESS)
    heights = f"{SUCCESS} rect.all"
    assert page.eval_on_selector_all(heights, "all => all.map((one) => Number(one.getAttribute('height')))") == [
        18,
        9,
        9,
    ]
    page.locator(SUCCESS).click(position={"x": 2, "y": 9})
    wait_rows(page, 2)
    assert rows(page) == second and page.url.endswith("?range.path.success=0.125%2C0.125")
    assert page.locator(f"{SUCCESS} rect.matching").count() == 1
    page.reload()
    wait_rows(page, 2)
    page.locator(SUCCESS).click(position={"x": 2, "y": 9})
    wait_rows(page, 4)
    page.go_back()
    wait_rows(page, 2)
    page.click("[aria-label='Every path.success']")
    wait_rows(page, 4)
    box = page.locator(SUCCESS).bounding_box()
    page.mouse.move(box["x"] + 30, box["y"] + 9)
    page.mouse.down()
    page.mouse.move(box["x"] + 79, box["y"] + 9)
    page.mouse.up()
    wait_rows(page, 2)
    assert rows(page) == first and page.url.endswith("?range.path.success=0.4%2C0.6")


def test_arrows_move_and_size_a_range_of_a_column(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.focus(SUCCESS)
    for keys, count in (("ArrowRight", 1), (5 * "Shift+ArrowRight ", 2), (5 * "ArrowLeft ", 3), ("Escape", 4)):
        for key in keys.split():
            page.keyboard.press(key)
        wait_rows(page, count)
    assert page.evaluate("() => document.activeElement.ariaLabel") == "Values of path.success"


def test_whole_numbers_have_a_bar_each_and_an_unknown_column_leaves_all(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups?range.seed=1,1&range.nothing=0,1&range.calls=a,b")
    wait_rows(page, 2)
    bars = "[aria-label='Values of seed'] rect.all"
    assert page.eval_on_selector_all(bars, "all => all.map((one) => Number(one.getAttribute('width')))") == [40, 40]
    assert page.locator("[aria-label='Values of calls']").count() == 0, "all runs made as many"


def test_few_groups_are_shown_without_scrolling(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector(".groups")
    hidden = page.eval_on_selector(".summary .table-box", "box => box.scrollHeight - box.clientHeight")
    assert hidden == 0


@pytest.mark.parametrize("tones", ["light", "dark"])
def test_groups_fit_a_telephone(page: Any, groups: ViewServer, tones: str):
    page.set_viewport_size({"width": 400, "height": 800})
    page.emulate_media(color_scheme=tones)
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector(".groups")
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


def test_a_long_cause_of_a_failure_leaves_room_for_measures(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "failed")
    first, *others = made.runs()
    Playing(first).end("the server at http://127.0.0.1:11434 refused the call: " + 9 * "check the context, ")
    for run in others:
        whole_run(run)
    write_tables(made)
    with serving(made.path) as running:
        go(page, running.url, "")
        page.wait_for_selector("td .cause")
        assert page.locator("td .cause").get_attribute("title").count("check the context") == 9
        head = page.locator("table.runs:not(.groups) thead th", has_text="status").bounding_box()
    assert head["width"] < 280
