"""axe finds nothing wrong with any page of the viewer, and none is wider than a telephone."""

from typing import Any

import pytest

import axe
from viewer.usable.conftest import Forms
from viewer_pages import go

pytestmark = pytest.mark.browser

OPEN = "() => document.querySelectorAll('details:not(.menu, .keys)').forEach((one) => { one.open = true; })"
CLIPPED = """() => [...document.querySelectorAll('.keys, .menu')].map((one) => {
  one.open = true;
  const {left, right} = one.lastElementChild.getBoundingClientRect();
  return left >= 0 && right <= document.documentElement.clientWidth ? null : one.textContent.slice(0, 40);
}).filter(Boolean)"""


def check(page: Any) -> None:
    axe.check(page)
    page.set_viewport_size({"width": 390, "height": 844})
    for tones in ("light", "dark"):
        page.emulate_media(color_scheme=tones)
        assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("form", ["grid", "rounds", "camera"])
def test_nothing_is_wrong_with_the_page_of_a_run(page: Any, forms: Forms, form: str):
    go(page, forms.server.url, f"{forms.run(form)}?step=2&agent=0")
    page.wait_for_selector(".inspector .quote, .decision .quote")
    page.evaluate(OPEN)
    check(page)


@pytest.mark.parametrize("form", ["grid", "rounds", "camera"])
def test_nothing_is_wrong_with_the_page_of_compared_runs(page: Any, forms: Forms, form: str):
    go(page, forms.server.url, f"{forms.compared(form)}?step=3&agent=0")
    page.wait_for_selector(".chips > *")
    page.wait_for_selector(".column .quote", state="attached")
    page.evaluate(OPEN)
    check(page)


def test_nothing_is_wrong_with_the_pages_of_a_sweep_what_is_being_done_and_what_is_not_there(page: Any, forms: Forms):
    go(page, forms.server.url, "sweep/grid")
    page.wait_for_selector("tbody tr[data-run]")
    page.wait_for_selector(".matrix td button", state="attached")
    page.evaluate(OPEN)
    page.fill(".find input", "hello")
    page.click(".find form button >> text=Search texts")
    page.wait_for_selector(".find .found a")
    check(page)
    go(page, forms.server.url, "live/grid")
    page.wait_for_selector(".live")
    check(page)
    go(page, forms.server.url, "sweep/nothing")
    page.wait_for_selector("[role=alert]")
    check(page)


def test_what_is_unfolded_over_a_page_is_seen_whole(page: Any, forms: Forms):
    page.set_viewport_size({"width": 390, "height": 800})
    for address in (forms.run("grid"), forms.compared("grid"), "sweep/grid", "sweep/probe"):
        go(page, forms.server.url, address)
        page.wait_for_selector(".keys")
        assert page.evaluate(CLIPPED) == [], address
