"""The page of a sweep: what was found of each group, and an address that brings back all that is seen."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer, serving
from made_up_runs import sweep, whole_run
from viewer_pages import SHOWN, go, shown

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
    rows = [{"name": name, "groups": [[name]], "cells": []} for name in ("first", "second")]
    overview = {"matrix": {"caption": "", "columns": [], "rows": rows}, "furthest": []}
    (made.analysis_dir / "overview.json").write_text(json.dumps(overview), encoding="utf-8")


@pytest.fixture(scope="module")
def groups(analysed: SweepFolder) -> Iterator[ViewServer]:
    with serving(analysed.path) as running:
        yield running


def test_a_cell_leaves_the_runs_of_its_model_and_world_and_another_click_brings_all_back(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.click(".matrix td button >> nth=1")
    wait_rows(page, 2)
    assert page.url.endswith("?row=second&world=made_up")
    page.click(".matrix [aria-pressed=true]")
    wait_rows(page, 4)


def test_the_name_of_a_model_opens_its_measures_with_a_stroke_for_each_seed(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups?open=first")
    page.wait_for_selector(".strips .strip .seed", state="attached")
    cell = page.locator(".strips tbody td").first.text_content()
    assert cell == "0.5 [0.25, 0.75] n = 2, scale 0 to 0.75baselines: random 0.1"
    assert page.locator(".strips .seed").count() == 2
    page.click(".matrix tbody th button >> nth=0")
    page.wait_for_selector(".strips", state="detached")


def test_without_an_analysis_the_matrix_counts_runs_and_what_they_took(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "later")
    first, *others = made.runs()
    whole_run(first)
    with shown(page, made, "sweep/later"):
        page.wait_for_selector(".matrix td >> text=1 of 2 runs")
        assert page.locator(".matrix tbody tr").count() == 2
        for run in others:
            whole_run(run)
        page.evaluate("() => Foundry.page.load()")
        page.wait_for_selector(".matrix tr:last-child td >> text=2 of 2 runs")


def test_measures_that_claims_rest_on_are_columns_at_first(page: Any, groups: ViewServer):
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector("[data-sort='path.success']")
    assert page.locator("[data-sort='path.length']").count() == 0
    page.click("summary >> text=columns")
    page.fill("[aria-label='Find a measure']", "length")
    page.locator("label", has_text="path.length").locator("input").check()
    page.wait_for_selector("[data-sort='path.length']")
    page.go_back()
    page.wait_for_selector("[data-sort='path.length']", state="detached")


def wait_rows(page: Any, count: int) -> None:
    page.wait_for_function("count => document.querySelectorAll('tbody tr[data-run]').length === count", arg=count)


def rows(page: Any) -> list[str]:
    texts: list[str] = page.eval_on_selector_all("tbody tr[data-run]", "all => all.map((one) => one.dataset.run)")
    return texts


def test_filter_order_ticks_and_columns_come_back_from_a_run(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server.url, "sweep/made-up")
    page.wait_for_selector("[data-sort='idle_rate.share']")
    page.select_option("[data-filter=model]", "first")
    page.click("[data-sort='idle_rate.share']")
    page.click("[data-sort='idle_rate.share']")
    seen = rows(page)
    page.check(f"[aria-label='Compare {seen[1]}']")
    page.click(f"[data-run='{seen[0]}'] a")
    page.wait_for_selector(".player")
    page.go_back()
    page.wait_for_function(SHOWN, arg="2 of 4 runs")
    page.wait_for_selector("th[aria-sort=descending]")
    assert rows(page) == seen == [made_up.runs()[0].id, made_up.runs()[1].id]
    assert page.is_checked(f"[aria-label='Compare {seen[1]}']")
    page.go_back()
    page.wait_for_selector("th[aria-sort=ascending]")
    page.go_back()
    page.go_back()
    page.wait_for_function(SHOWN, arg="4 of 4 runs")
    assert page.input_value("[data-filter=model]") == ""


def test_where_the_grid_is_looked_at_is_in_the_address(page: Any, server: ViewServer, made_up: SweepFolder):
    run = f"run/made-up/{made_up.runs()[0].id}"
    go(page, server.url, f"{run}?step=3&agent=1")
    page.click("[aria-label='Zoom in']")
    page.wait_for_function("() => location.hash.endsWith('?step=3&agent=1&camera=1.5%2C0%2C0')")
    go(page, server.url, f"{run}?step=2&camera=4,1.5,-2")
    assert page.evaluate("() => [Foundry.page.grid.zoom, Foundry.page.grid.centre]") == [4, [1.5, -2]]
    go(page, server.url, f"{run}?step=2&camera=nowhere")
    assert page.evaluate("() => [Foundry.page.grid.zoom, Foundry.page.grid.centre]") == [1, [0, 0]]
