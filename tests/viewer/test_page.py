"""The page in a real browser; its console must stay free of errors, which `browser_page` checks."""

from typing import Any

import pytest

import viewer_pages
from browser import browser_page
from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer
from made_up_runs import STEPS

pytestmark = pytest.mark.browser


def go(page: Any, server: ViewServer, address: str) -> None:
    viewer_pages.go(page, server.url, address)


def run_address(made_up: SweepFolder, index: int = 0, rest: str = "") -> str:
    return f"run/made-up/{made_up.runs()[index].id}{rest}"


def where(page: Any) -> str:
    return str(page.text_content(".where"))


def wait_where(page: Any, text: str) -> None:
    page.wait_for_function("text => document.querySelector('.where').textContent === text", arg=text)


def test_the_overview_lists_sorts_and_filters_the_runs(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server, "")
    page.wait_for_selector("[data-sort='idle_rate.share']")
    rows = page.locator("tbody tr[data-run]")
    assert rows.count() == 4
    page.click("[data-sort='idle_rate.share']")
    assert rows.first.get_attribute("data-run") == made_up.runs()[1].id
    page.click("[data-sort='idle_rate.share']")
    assert rows.first.get_attribute("data-run") == made_up.runs()[0].id
    assert page.locator("th[aria-sort=descending]").count() == 1
    page.fill("[aria-label='Filter and search']", "first")
    assert rows.count() == 2
    page.fill("[aria-label='Filter and search']", "")
    page.select_option("[data-filter=status]", "failed")
    assert rows.count() == 1
    assert "the server is gone <b>for good</b>" in page.text_content(".failures")
    assert page.locator(".reports a").get_attribute("href") == "files/made-up/report.html"


def test_a_run_is_played_paused_stepped_and_scrubbed(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server, run_address(made_up))
    assert where(page) == f"step 1 of {STEPS}"
    page.select_option("[aria-label^=Speed]", "30")
    page.click("[data-do=play]")
    wait_where(page, f"after step {STEPS} of {STEPS}")
    page.click("[aria-label='First step']")
    page.click("[aria-label='Step on']")
    assert where(page) == f"step 2 of {STEPS}"
    page.locator(".scrub").fill("5")
    assert where(page) == f"step 5 of {STEPS}"
    page.mouse.click(*middle_of(page, ".marks"))
    assert where(page) == f"step 4 of {STEPS}"


def middle_of(page: Any, selector: str) -> tuple[float, float]:
    box = page.locator(selector).bounding_box()
    return box["x"] + box["width"] / 2 + 2, box["y"] + box["height"] / 2


def test_a_clicked_agent_shows_its_prompts_replies_and_outcome_and_the_grid_is_described_in_words(
    page: Any, server: ViewServer, made_up: SweepFolder
):
    go(page, server, run_address(made_up, rest="?step=4"))
    page.wait_for_function("() => Foundry.page.grid.spots")
    box = page.locator("canvas.grid").bounding_box()
    x, y = page.evaluate("() => Foundry.page.grid.spots[0]")
    page.mouse.click(box["x"] + x, box["y"] + y)
    page.wait_for_selector(".inspector .is-unreadable")
    page.wait_for_function("() => document.querySelector('.persona').textContent.includes('gender: female')")
    call = page.locator("details[data-kind=action]")
    assert call.get_attribute("open") is not None, "the call that failed is open"
    assert "You are Agent 0 (female) at step 4" in call.locator(".prompt").text_content()
    assert call.locator(".reply").text_content() == 'action: {"action": "move"}'
    assert page.locator("details[data-kind=message]").get_attribute("open") is None
    page.wait_for_function("() => location.hash.endsWith('?step=4&agent=0')")
    go(page, server, run_address(made_up, rest="?step=2"))
    page.wait_for_function("() => document.querySelector('canvas.grid').ariaLabel?.includes('2 in cafe (capacity 1)')")
    assert "1 messages delivered. No fire." in page.get_attribute("canvas.grid", "aria-label")
    page.keyboard.press("f")
    page.wait_for_function("() => document.querySelector('#announcer').textContent.includes('Burning: fire1')")


def test_the_agents_are_rows_sorted_by_the_whole_run_and_one_of_them_is_a_conversation(
    page: Any, server: ViewServer, made_up: SweepFolder
):
    page.set_viewport_size({"width": 1440, "height": 900})
    go(page, server, run_address(made_up, rest="?step=4"))
    page.click("[data-sort=messages]")
    rows = page.locator(".agents tbody tr")
    assert rows.first.get_attribute("data-agent") == "1" and rows.count() == 4
    assert "hello from step 4" in rows.first.text_content()
    assert page.evaluate("() => document.documentElement.scrollHeight <= innerHeight"), "the page fits the screen"
    page.click(".agents tr[data-agent='2'] button")
    page.click(".told a")
    assert page.input_value("[aria-label=Agent]") == "1" and where(page) == f"step 4 of {STEPS}"
    page.check("text=all steps")
    page.wait_for_selector(".talk [data-step='6']")
    assert "said hello from step 4" in page.text_content(".talk .now")
    page.click(".talk button >> text=step 6")
    assert where(page) == f"step 6 of {STEPS}"


def test_texts_of_a_model_are_shown_and_never_run(page: Any, server: ViewServer, made_up: SweepFolder):
    page.set_viewport_size({"width": 900, "height": 900})
    go(page, server, run_address(made_up, 1, "?step=2&agent=1"))
    page.wait_for_selector("details[data-kind=action]")
    page.click("details[data-kind=action] summary")
    shown = page.text_content("details[data-kind=action] .reply")
    assert "<script>window.hacked = 1</script><img src=x onerror=" in shown
    assert "[U+202E]gnirts desrever" in shown
    assert "nul:[U+0000]:" in shown
    page.click("[data-do=Search]")
    page.fill("[aria-label='Search in messages']", "onerror")
    page.keyboard.press("Enter")
    page.wait_for_selector(".found li")
    assert page.locator("main script, main img").count() == 0
    assert page.evaluate("() => window.hacked") is None
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth"), "no text widens the page"


def test_what_is_not_there_is_said_on_the_page_and_of_compared_runs_which(server: ViewServer, made_up: SweepFolder):
    with browser_page(allowed_errors=("404",)) as page:
        go(page, server, "")
        page.wait_for_selector("[data-run]")
        page.evaluate("() => { location.hash = '#/run/made-up/nothing' }")
        page.wait_for_selector("[role=alert]")
        assert "Run 'nothing' not found" in page.text_content("[role=alert]")
        go(page, server, f"compare/made-up/{'/'.join(run.id for run in made_up.runs()[:3])}/nothing")
        assert page.text_content("h1") == "3 of 4 runs side by side"
        assert "Run 'nothing' not found" in page.text_content(".left-out")


NOWHERE = {
    "run/made-up/%E0%A4%A": "The address cannot be read at '%E0%A4%A'",
    "sweep/other": "There is no sweep 'other'. Available: made-up.",
    "sweeps/made-up": "There is no page 'sweeps'",
    "constructor": "There is no page 'constructor'",
}


def test_an_address_that_leads_nowhere_is_said_to_do_so(page: Any, server: ViewServer):
    for address, said in NOWHERE.items():
        go(page, server, "")
        page.wait_for_selector("[data-run]")
        page.evaluate("address => { location.hash = `#/${address}` }", address)
        page.wait_for_selector("[role=alert]")
        assert said in page.text_content("[role=alert]")
        assert page.locator("tbody tr[data-run]").count() == 0
