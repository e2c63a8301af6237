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


def test_a_group_has_its_mean_interval_and_a_stroke_for_each_seed_without_scrolling(page: Any, groups: ViewServer):
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
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector(".groups")
    hidden = page.eval_on_selector(".summary .table-box", "box => box.scrollHeight - box.clientHeight")
    assert hidden == 0


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


def wait_rows(page: Any, count: int) -> None:
    page.wait_for_function("count => document.querySelectorAll('tbody tr[data-run]').length === count", arg=count)


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
