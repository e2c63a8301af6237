"""The page in a real browser; its console must stay free of errors, which `browser_page` checks."""

from pathlib import Path
from typing import Any

import pytest

import viewer_pages
from browser import browser_page
from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer
from made_up_runs import STEPS, sweep, whole_run
from viewer_pages import shown

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


def test_the_head_stays_above_the_rows_and_the_next_page_is_read_from_its_top(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "many", models=("first",), seeds=range(130))
    with shown(page, made, "sweep/many"):
        page.wait_for_function("() => document.querySelectorAll('tbody tr[data-run]').length === 100")
        page.eval_on_selector("[aria-label=Runs]", "box => { box.scrollTop = box.scrollHeight; }")
        assert page.evaluate(ABOVE_THE_HEAD) == 0
        page.click("[aria-label='Next page']")
        page.wait_for_function("() => document.querySelectorAll('tbody tr[data-run]').length === 30")
        assert page.eval_on_selector("[aria-label=Runs]", "box => box.scrollTop") == 0
        assert page.locator("tbody tr[data-run]").first.get_attribute("data-run") == made.runs()[100].id
        page.go_back()
        page.wait_for_function("() => document.querySelectorAll('tbody tr[data-run]').length === 100")


ABOVE_THE_HEAD = """() => {
  const box = document.querySelector("[aria-label=Runs]"), head = box.querySelector("th");
  return Math.round(head.getBoundingClientRect().top - box.getBoundingClientRect().top - box.clientTop);
}"""


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


def test_who_perceives_a_fire_and_speaks_has_both_rings(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "rings", models=("first",), seeds=(0,))
    whole_run(
        made.runs()[0], change=lambda number, agent: {"fires": ("fire1",), "message": "fire!"} if agent == 1 else {}
    )
    with shown(page, made, f"run/rings/{made.runs()[0].id}?step=2"):
        page.wait_for_function("() => Foundry.page.grid.spots")
        assert page.evaluate(TONES_BESIDE, [1, ["fire", "talk"]]) == [True, True]
        assert page.evaluate(TONES_BESIDE, [3, ["fire", "talk"]]) == [False, False]


TONES_BESIDE = """([agent, names]) => {
  const {grid} = Foundry.page, [x, y] = grid.spots[agent], scale = devicePixelRatio;
  const pen = grid.canvas.getContext('2d'), seen = new Set();
  for (let away = 0; away < 24; away += 0.5) {
    seen.add(pen.getImageData((x + away) * scale, y * scale, 1, 1).data.slice(0, 3).join());
  }
  const probe = document.createElement('canvas').getContext('2d');
  return names.map((name) => {
    probe.fillStyle = Foundry.dom.color(name);
    probe.fillRect(0, 0, 1, 1);
    return seen.has(probe.getImageData(0, 0, 1, 1).data.slice(0, 3).join());
  });
}"""


def test_the_keyboard_keeps_its_place(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server, "")
    page.focus("[data-sort=undecided]")
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.dataset.sort") == "undecided"
    go(page, server, run_address(made_up))
    page.focus(".scrub")
    page.wait_for_function("() => Foundry.page.data.marked === 6")
    for key, step in [("ArrowRight", "step 2"), ("x", "step 3"), ("End", f"after step {STEPS}"), ("Home", "step 1")]:
        page.keyboard.press(key)
        assert where(page) == f"{step} of {STEPS}", key
    page.focus(".skip")
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.id") == "main"
    assert where(page) == f"step 1 of {STEPS}", "the page is still that of the run"


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


def test_the_jumps_are_about_the_chosen_agent(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server, run_address(made_up, rest="?step=1"))
    page.wait_for_function("() => Foundry.page.data.marked === 6")
    page.keyboard.press("x")
    page.wait_for_selector("tr[data-agent='2'] .is-repaired")
    page.click("tbody tr[data-agent] >> nth=0 >> button")
    page.wait_for_function("() => Foundry.page.ownMarks")
    assert page.input_value("[aria-label=Agent]") == "2"
    assert "of agent 2 alone" in page.text_content(".legend")
    page.keyboard.press("x")
    assert where(page) == f"step 3 of {STEPS}", "agent 2 has no later failure"
    page.select_option("[aria-label=Agent]", "0")
    page.wait_for_function("() => Foundry.page.ownMarks?.undecided[3] === 1")
    page.focus("#main")
    page.keyboard.press("x")
    assert where(page) == f"step 4 of {STEPS}"
    page.wait_for_selector(".happening >> text=not analysed: foundry analyze")


LONG = 120_000
PARTS = ("smoke and fire ", "x\u00e9", "go\n", "=== WHAT IS NEAR ===\nNobody.\n", '[{"a": [')
"""Words, one endless word, lines, headings, brackets."""
MADE = """() => {
  const nodes = document.createTreeWalker(document.getElementById('main'), NodeFilter.SHOW_ALL);
  let count = 0, signs = 0, longest = 0;
  for (; nodes.nextNode(); count += 1) {
    if (nodes.currentNode.nodeType !== Node.TEXT_NODE) continue;
    signs += nodes.currentNode.data.length;
    longest = Math.max(longest, ...nodes.currentNode.data.split(/\\s/, 1000).map((word) => word.length));
  }
  return {count, signs, longest};
}"""


def made_of(folder: Path, size: int) -> SweepFolder:
    """Write two models whose prompts and replies are so long, and messages and memories a tenth of it."""
    text = "".join(part * (size // len(part) // len(PARTS)) for part in PARTS)
    made = sweep(folder / f"long{size}", seeds=(0,), agents=3, steps=2)
    for number, run in enumerate(made.runs()):
        said = text[: size // 10]
        whole_run(run, lambda step, agent, said=said: {"message": said, "memory": said}, f"{number}{text}", f" {text}")
    return made


def opened(page: Any, made: SweepFolder, address: str) -> dict[str, float]:
    """Open a page and every text on it; return nodes, signs and the longest word without a place to break it."""
    with shown(page, made, f"{address}?step=2&agent=1"):
        page.wait_for_selector("details[data-kind=action], [data-text]")
        page.evaluate("() => document.querySelectorAll('details.call > summary').forEach((one) => one.click())")
        page.wait_for_selector(".quote", state="attached")
        found: dict[str, float] = page.evaluate(MADE)
    return found


@pytest.mark.parametrize("what", ["run", "compare"])
def test_what_a_page_makes_of_a_text_grows_as_the_text_does(page: Any, tmp_path: Path, what: str):
    found = []
    for size in (LONG // 4, LONG):
        made = made_of(tmp_path, size)
        runs = [run.id for run in made.runs()]
        found.append(opened(page, made, "/".join([what, made.path.name, *runs[: 1 if what == "run" else 2]])))
    small, large = found
    assert large["signs"] > 4 * LONG, "prompts and replies of two questions"
    assert large["count"] <= 4.2 * small["count"]
    assert large["longest"] == 256, "finding the breaks of one long part takes seconds"
