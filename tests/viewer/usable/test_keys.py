"""What the keyboard does: every key that a page lists is tried, and everything on a page is reached and seen to be."""

from dataclasses import dataclass
from typing import Any

import pytest

from viewer.usable.conftest import Forms
from viewer_pages import go

pytestmark = pytest.mark.browser

OPEN = "() => document.querySelectorAll('details').forEach((one) => { one.open = true; })"
STEP, END, SPEED = "Foundry.page.clock.step", "Foundry.page.clock.steps", "Foundry.page.clock.speed"
AGENT, FOCUSED = "Foundry.page.agent", "document.activeElement"
MAP = "(Foundry.page.grid || Foundry.page.panels[0].view)"


@dataclass(frozen=True)
class Try:
    """Keys, and an expression of JavaScript that is true after they are pressed and was not before.

    Attributes:
        keys: pressed one after the other.
        shown: the expression.
        before: pressed first, to make ready.
        within: what has the keyboard; the page itself unless said.
    """

    keys: str
    shown: str
    before: str = ""
    within: str = "main"


PLAYER = {
    "Space": [Try("Space", "Foundry.page.clock.playing"), Try("Space", "!Foundry.page.clock.playing")],
    "← →": [Try("ArrowRight", f"{STEP} === 2", "Home"), Try("ArrowLeft", f"{STEP} === 1")],
    "Shift ← →": [
        Try("Shift+ArrowRight", f"{STEP} === Math.min(11, {END})", "Home"),
        Try("Shift+ArrowLeft", f"{STEP} === Math.max(1, {END} + 1 - 10)", "End"),
    ],
    "Home End": [
        Try("End", f"Foundry.page.clock.position === {END} + 1"),
        Try("Home", "Foundry.page.clock.position === 1"),
    ],
    "+ −": [Try("+", f"{SPEED} === 4"), Try("-", f"{SPEED} === 2")],
    "X": [Try("x", f"{STEP} > 1", "Home")],
    "Shift + letter": [Try("Shift+X", f"Foundry.page.clock.position <= {END}", "End")],
}
MESSAGES = {"M": [Try("m", f"{STEP} > 1", "Home")]}
FIRES = {"F": [Try("f", f"{STEP} > 1", "Home")]}
BOUNDARIES = {"B": [Try("b", f"{STEP} > 1", "Home")]}
AGENTS = {
    "[ ]": [Try("] ]", f"{AGENT} === 1", "Escape"), Try("[", f"{AGENT} === 0")],
    "Esc": [Try("Escape", f"{AGENT} === null")],
}
SEARCH = {"/": [Try("/", f"{FOCUSED}.matches('.search input')")]}
NOTES = {"N": [Try("n", f"{FOCUSED}.ariaLabel === 'Note'")]}
SHIFTED = {
    "Tab to the map, ← → ↑ ↓": [
        Try("Enter", f"{MAP}.zoom > 1", within="[aria-label='Zoom in']"),
        Try("ArrowRight ArrowUp", f"{MAP}.centre[0] > 0 && {MAP}.centre[1] > 0", within="canvas.grid"),
        Try("ArrowLeft ArrowDown", f"{MAP}.centre[0] === 0 && {MAP}.centre[1] === 0", within="canvas.grid"),
    ]
}
TURNED = {
    "Tab to the scene, ← → ↑ ↓": [Try("ArrowLeft", "location.hash.includes('camera=')", within=".scene canvas")],
    "there, + − Home": [Try("Home", "!location.hash.includes('camera=')", "+ -", within=".scene canvas")],
    "V": [Try("v", "document.querySelector('.scene-box').hidden")],
}
SWEEP = {
    "/": [Try("/", f"{FOCUSED}.ariaLabel === 'Filter and search'")],
    "N": [Try("n", "document.querySelector('dialog.noted[open]')", within="tbody [type=checkbox]")],
}
MOMENTS = {
    "J": [Try("j", "location.hash !== BEFORE")],
    "K": [Try("k", "location.hash !== BEFORE")],
    "E": [Try("e", "location.hash.includes('edit=no_fire')")],
    **NOTES,
}
EVENTS = {"E": [Try("e", f"{STEP} === 2", "Home"), Try("Shift+E", f"[2, 5].includes({STEP})", "End")]}
RUN = PLAYER | NOTES
GRID = RUN | MESSAGES | FIRES | AGENTS | SHIFTED
PAGES = {
    "a 2D run": ("run grid", GRID | SEARCH | EVENTS),
    "a run of rounds": ("run rounds", RUN | MESSAGES | AGENTS | SEARCH | EVENTS),
    "a 3D run": ("run camera", RUN | BOUNDARIES | SEARCH | TURNED | EVENTS),
    "compared 2D runs": ("compared grid", GRID),
    "compared runs of rounds": ("compared rounds", RUN | MESSAGES | AGENTS),
    "compared 3D runs": ("compared camera", RUN | BOUNDARIES),
    "a sweep": ("sweep/grid", SWEEP),
    "a probe": ("sweep/probe", MOMENTS),
}


def open_page(page: Any, forms: Forms, what: str) -> None:
    kind, _, form = what.partition(" ")
    address = {"run": forms.run, "compared": forms.compared}[kind](form) if form else what
    go(page, forms.server.url, address)
    page.wait_for_selector({"run": ".legend", "compared": ".chips > *"}.get(kind, ".keys"))
    if form:
        page.wait_for_function(
            "() => (Foundry.page.runs || [Foundry.page.data]).every((one) => one.marked === one.done)"
        )
    if kind == "run":
        page.wait_for_function("() => Foundry.page.data.analysis.events.length >= 1")
    if what == "run camera":
        page.keyboard.press("v")
        page.wait_for_selector(".scene canvas")
    if what == "sweep/grid":
        for last in (".matrix td button", "[data-sort='idle_rate.share']", ".gallery"):
            page.wait_for_selector(last, state="attached")
    page.evaluate(OPEN)


def press(page: Any, one: Try) -> None:
    """Try a key, and fail where it does not do what it is said to, or where that was so before."""
    page.evaluate("selector => document.querySelector(selector).focus()", one.within)
    for key in one.before.split():
        page.keyboard.press(key)
    page.evaluate("() => { window.BEFORE = location.hash; }")
    assert not page.evaluate(one.shown), f"{one} is so before"
    for key in one.keys.split():
        page.keyboard.press(key)
    page.wait_for_function(f"() => {one.shown}")


STAND_STILL = "() => { if (Foundry.page.clock) Foundry.page.clock.tick = () => null; }"
"""A run that plays stays at its step, so that it does not end while a slow machine presses the next key."""


@pytest.mark.parametrize("name", PAGES)
def test_the_keys_that_a_page_lists_are_those_that_work(page: Any, forms: Forms, name: str):
    what, tries = PAGES[name]
    open_page(page, forms, what)
    page.evaluate(STAND_STILL)
    assert set(page.locator(".keys kbd").all_text_contents()) == set(tries)
    for key in page.locator(".keys kbd").all_text_contents():
        for one in tries[key]:
            press(page, one)


STOPS = """() => {
  window.UNSEEN = new Set();
  window.REACHED = new Set();
  const isSeen = (one) => [one, ...[one.closest('label')].filter(Boolean)].some((box) => {
    const {outlineStyle, outlineWidth} = getComputedStyle(box);
    return outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2;
  });
  document.addEventListener('focusin', ({target}) => {
    REACHED.add(target);
    if (!isSeen(target)) UNSEEN.add(target.outerHTML.slice(0, 120));
  });
  Foundry.page.disposed = true; // no news of the server is drawn while the keyboard goes through the page
  document.activeElement.blur();
  document.querySelector('.skip').focus();
  UNSEEN.clear(); // no key brought it there
}"""
LEFT = """() => [...document.querySelectorAll('a[href], button, select, input, textarea, summary, [tabindex="0"]')]
  .filter((one) => !one.disabled && one.checkVisibility({visibilityProperty: true}) && !REACHED.has(one))
  .map((one) => one.outerHTML.slice(0, 120))"""


@pytest.mark.parametrize("what", [*(what for what, _ in PAGES.values()), "live/grid"])
def test_everything_is_reached_by_tab_and_is_seen_to_be(page: Any, forms: Forms, what: str):
    open_page(page, forms, what) if what != "live/grid" else go(page, forms.server.url, what)
    page.wait_for_selector("main a, main button")
    page.evaluate(STOPS)
    for _ in range(300):
        page.keyboard.press("Tab")
        if page.evaluate("() => document.activeElement.matches('body, .skip')"):
            break
    assert page.evaluate(LEFT) == []
    assert page.evaluate("() => [...UNSEEN]") == []
