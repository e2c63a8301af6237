"""What was found of each group, above the runs of a sweep."""

from __future__ import annotations

import json
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
    with serving(made.path) as server:
        go(page, server.url, "sweep/later")
        page.wait_for_selector(".matrix td >> text=1 of 2 runs")
        assert page.locator(".matrix tbody tr").count() == 2
        for run in others:
            whole_run(run)
        page.evaluate("() => Foundry.page.load()")
        page.wait_for_selector(".matrix tr:last-child td >> text=2 of 2 runs")
        page.goto("about:blank")


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


@pytest.mark.parametrize("tones", ["light", "dark"])
def test_the_matrix_fits_a_telephone(page: Any, groups: ViewServer, tones: str):
    page.set_viewport_size({"width": 400, "height": 800})
    page.emulate_media(color_scheme=tones)
    go(page, groups.url, "sweep/groups")
    page.wait_for_selector(".matrix tbody")
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
        head = page.locator("table.runs:not(.matrix *) thead th", has_text="status").bounding_box()
    assert head["width"] < 280
