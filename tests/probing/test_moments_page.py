"""The page of a probe in a real browser, and exported."""

import re
import shutil
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import axe
from analysis.probes.distance import apart
from browser import browser_page
from foundry.palette import look
from foundry.seeding import stream
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.resources import Resources
from foundry.viewer.server import serving
from probing.conftest import MOMENTS, moments, note, noted

pytestmark = pytest.mark.browser
READY = ".moment .choices"


@pytest.fixture(scope="module")
def mine(probed: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(probed, tmp_path_factory.mktemp("mine") / "probed"))


@pytest.fixture(scope="module")
def page(mine: Path) -> Iterator[Any]:
    with serving(mine) as server, browser_page() as page:
        page.goto(server.url)
        page.wait_for_selector(READY)
        yield page


def test_it_opens_at_the_moment_at_which_models_differ_most_beyond_chance(page: Any):
    shown = [float(text) for text in page.locator(".moments .excess").all_text_contents()]
    assert shown == sorted(shown, reverse=True)
    assert shown[0] > 0.3
    apart, chance = re.findall(r"0\.\d\d", page.locator(".moments .distance").first.text_content())
    assert float(apart) - float(chance) == pytest.approx(shown[0], abs=0.011)
    assert page.locator(".moments button").first.get_attribute("aria-current") == "true"
    assert page.locator(".column .choices").count() == 5
    assert page.locator(".map svg[role=img]").count() == 1
    assert "You are Agent" in page.locator(".prompt").first.text_content()


def test_all_models_show_their_choices_in_one_order_and_in_the_colours_of_the_sweep(page: Any, probed: Path):
    columns = page.locator(".moment .columns").first.locator(".column").all()
    choices = {tuple(column.locator(".choices bdi").all_text_contents()) for column in columns}
    assert len(choices) == 1 and len(choices.pop()) > 1
    names = [column.locator("h3").text_content().strip() for column in columns]
    assert names == SweepFolder.open(probed).sweep.model_names() != sorted(names)
    colours = [column.locator(".marker path").get_attribute("fill") for column in columns]
    assert colours == [look(place).paint for place in range(len(columns))]
    gist = page.locator(".moments .gist").first.text_content()
    assert gist.startswith("Fire, no message") and "scripted/herd" in gist
    assert page.locator(".moment .gist").text_content() == gist


def test_choices_are_compared_as_the_tables_compare_them(page: Any):
    def told(first: dict[str, int], second: dict[str, int], expected: dict[str, str]) -> float:
        script = "([a, b, expected]) => Foundry.probes.apart(Foundry.probes.carried(a, {expected}), b)"
        return float(page.evaluate(script, [first, second, expected]))

    assert told({"left": 3, "up": 1}, {"left": 1, "up": 1}, {}) == 0.25
    assert told({"left": 4}, {"left": 2, "stay": 2}, {"left": "right"}) == 1
    assert told({"left": 4, "stay": 4}, {"right": 1, "stay": 1}, {"left": "right", "stay": "stay"}) == 0
    by_repeats, by_probabilities = {"left": 1, "up": 3}, {"left": 600, "up": 399, "stay": 1}
    for first in ({"left": 5, "up": 3, "stay": 1}, {"left": 1000}, by_probabilities):
        for second in (by_repeats, by_probabilities):
            floor = page.evaluate("([a, b]) => Foundry.probes.floorOf(a, b)", [first, second])
            assert floor == pytest.approx(apart(Counter(first), Counter(second), stream(0, "t")).floor)


def test_the_map_shows_all_that_an_agent_perceives_of_walls_exits_food_and_others(page: Any):
    seen = {
        "agent": 0, "x": 4, "y": 0, "half_size": 4, "view": 1, "window": ["#E#", ".@#", "fA#"],
        "neighbours": [], "fires": [], "seen": [{"id": 7, "x": 4, "y": -1}], "energy": 5,
        "food": [{"x": 3, "y": -1, "amount": 2}, {"x": 4, "y": 0, "amount": 1}], "burning": [[3, 1]],
        "exits": [{"name": "door", "x": 4, "y": 1}], "received": [],
        "zones": [{"name": "pit", "x_min": -4, "x_max": -3, "y_min": -4, "y_max": -4, "risk": 0.5}],
    }  # fmt: skip
    shown = page.evaluate("(seen) => Foundry.perceived.grid(seen, 'moment').outerHTML", seen)
    drawn = {name: shown.count(f'class="{name}"') for name in ("wall", "food", "burning", "zone", "other", "self")}
    assert drawn == {"wall": 1, "food": 2, "burning": 1, "zone": 1, "other": 1, "self": 1}, (
        "what is beyond the edge is none"
    )
    assert 'class="exit" x="3.5" y="-1.5"' in shown and ">7<" in shown and ">pit<" in shown
    assert "energy 5" in shown and "1 more seen" in shown and "food in 2 cells, also in the agent's cell" in shown
    assert shown.index('class="food-edge" x="3.5" y="-0.5"') > shown.index('class="self"'), "what it stands on is seen"


def test_the_keyboard_goes_through_moments_and_edits(page: Any):
    page.keyboard.press("j")
    assert page.locator(".moments button").nth(1).get_attribute("aria-current") == "true"
    page.keyboard.press("k")
    page.keyboard.press("e")
    page.get_by_text("What the edit changes").wait_for()
    assert page.locator(".map svg").count() == 2
    assert page.url.endswith("&edit=no_fire")
    page.keyboard.press("e")
    page.keyboard.press("e")
    page.wait_for_selector(".moment figure:only-child")
    assert "edit" not in page.url


def test_axe_finds_nothing_wrong_with_the_moments_of_a_probe(page: Any):
    axe.check(page)


def test_a_moment_is_noted_by_keyboard_gone_to_from_its_note_and_found_by_a_search(page: Any, mine: Path):
    first = page.url
    page.keyboard.press("n")
    page.keyboard.type("They part here")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector("[data-note] >> text=They part here")
    number = int(page.locator(".moments [aria-current]").get_attribute("data-moment"))
    assert noted(mine) == [(*moments(mine)[number][:3], number, "They part here")]
    page.keyboard.press("j")
    page.keyboard.press("j")
    assert page.url != first
    page.click("[data-note] .go >> nth=0")
    assert page.url == first
    page.click("[aria-label='Change the note: They part here']")
    assert page.locator("[aria-label='Run of the note']").is_disabled()
    page.fill("[aria-label=Note]", "They part")
    page.click(".notes button >> text=Save")
    page.wait_for_selector("[data-note] >> text=/They part$/")
    assert noted(mine) == [(*moments(mine)[number][:3], number, "They part")]
    Resources(mine).take_note("probed", note(mine, 7, "It turned back."))
    page.evaluate("location.hash = '#/runs/probed?find=turned&in=note'")
    page.click(".find .found a")
    page.wait_for_selector(".moments [aria-current][data-moment='7']")
    assert page.url.endswith("#/sweep/probed?moment=7")
    page.wait_for_selector("[data-note] >> text=It turned back.")


def test_the_exported_page_shows_the_same_from_its_files_with_notes_when_asked(probed: Path, tmp_path: Path):
    copied = Path(shutil.copytree(probed, tmp_path / "probed"))
    Resources(copied).take_note("probed", note(copied, 7, "It turned back."))
    exported = export(copied, tmp_path / "page", notes=True).page
    every_moment = (tmp_path / "page" / "data" / "probe" / "probed" / "moment").iterdir()
    assert {file.name for file in every_moment} == {f"{number}.js" for number in range(MOMENTS)}
    with browser_page(width=400) as page:
        page.goto(exported.as_uri())
        page.wait_for_selector(READY)
        assert page.locator(".moments button").count() == MOMENTS
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
        page.wait_for_selector(".notes >> text=It turned back.")
        assert page.locator(".notes form").count() == 0
        page.get_by_text("runs of this probe").click()
        page.wait_for_selector("table.runs tbody tr")


def test_the_report_of_a_probe_fits_a_narrow_page(report: Path):
    with browser_page(width=400) as page:
        page.goto(report.as_uri())
        assert page.locator("article:not(.finding)").count() == 10
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
        assert page.locator("img:not([alt])").count() == 0
        page.evaluate("() => document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        axe.check(page)
