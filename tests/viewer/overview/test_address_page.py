"""Everything that is seen is in the address: Back and a copied link bring it back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from browser import browser_page
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import ViewServer
from viewer_pages import go

pytestmark = pytest.mark.browser

SHOWN = "text => document.querySelector('.shown')?.textContent === text"


def rows(page: Any) -> list[str]:
    found: list[str] = page.eval_on_selector_all("tbody tr[data-run]", "all => all.map((one) => one.dataset.run)")
    return found


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


def test_the_way_up_from_a_run_leads_to_the_overview_as_it_was(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server.url, "sweep/made-up")
    page.wait_for_selector("tbody tr")
    page.fill("[aria-label='Filter and search']", "second")
    page.click("tbody tr a >> nth=0")
    page.wait_for_selector(".player")
    page.click("#crumbs a")
    page.wait_for_function(SHOWN, arg="2 of 4 runs")
    assert page.input_value("[aria-label='Filter and search']") == "second"


def test_a_copied_link_of_an_export_shows_the_same(page: Any, made_up: SweepFolder, tmp_path: Path):
    exported = export(made_up.path, tmp_path / "page")
    go(page, exported.page.as_uri(), "sweep/made-up?model=second&sort=-seed&columns=none")
    page.wait_for_function(SHOWN, arg="2 of 4 runs")
    assert rows(page) == [made_up.runs()[3].id, made_up.runs()[2].id]
    assert page.locator("[data-sort='idle_rate.share']").count() == 0
    page.goto("about:blank")


def test_where_the_grid_is_looked_at_is_in_the_address(page: Any, server: ViewServer, made_up: SweepFolder):
    run = f"run/made-up/{made_up.runs()[0].id}"
    go(page, server.url, f"{run}?step=3&agent=1")
    page.click("[aria-label='Zoom in']")
    page.wait_for_function("() => location.hash.endsWith('?step=3&agent=1&camera=1.5%2C0%2C0')")
    go(page, server.url, f"{run}?step=2&camera=4,1.5,-2")
    assert page.evaluate("() => [Foundry.page.grid.zoom, Foundry.page.grid.centre]") == [4, [1.5, -2]]
    go(page, server.url, f"{run}?step=2&camera=nowhere")
    assert page.evaluate("() => [Foundry.page.grid.zoom, Foundry.page.grid.centre]") == [1, [0, 0]]


def test_what_one_page_is_about_to_remember_is_no_part_of_the_next(page: Any, server: ViewServer, made_up: SweepFolder):
    first, second = (f"run/made-up/{run.id}" for run in made_up.runs()[:2])
    go(page, server.url, f"{first}?step=3")
    page.evaluate("address => { Foundry.remember({camera: '4,0,0'}); location.hash = address; }", f"#/{second}?step=2")
    page.wait_for_function(
        "id => Foundry.page?.data.id === id && Foundry.page.clock.step === 2", arg=made_up.runs()[1].id
    )
    page.evaluate("() => Foundry.remember({agent: 1})")
    page.wait_for_function("() => location.hash.includes('agent=1')")
    assert "camera" not in page.url


ELSEWHERE_UNHEARD = """() => {
  Foundry.remember({step: 1});
  history.replaceState(null, '', location.hash.replace('step=2', 'step=3'));
}"""
GO_ELSEWHERE = """() => new Promise((gone) => {
  addEventListener('hashchange', gone, {once: true});
  Foundry.source.json = () => new Promise(() => null);
  Foundry.remember({step: 1});
  location.hash = location.hash.replace('step=2', 'step=3');
})"""


@pytest.mark.parametrize("elsewhere", [GO_ELSEWHERE, ELSEWHERE_UNHEARD], ids=["heard", "unheard"])
def test_who_goes_to_another_step_is_not_led_back_by_what_was_looked_at_last_or_is_remembered_late(
    server: ViewServer, made_up: SweepFolder, elsewhere: str
):
    with browser_page() as page:
        go(page, server.url, f"run/made-up/{made_up.runs()[0].id}?step=2")
        page.wait_for_function("() => Foundry.page?.clock?.step === 2")
        page.clock.install()
        page.evaluate(elsewhere)
        page.clock.run_for(1000)
        assert page.url.endswith("step=3")
