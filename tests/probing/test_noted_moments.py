"""Notes on the moments of a probe: in its folder, by the way that notes on runs take."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from browser import browser_page
from foundry.errors import InputError
from foundry.storing.notes import notes_of
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.resources import Resources
from foundry.viewer.search import Query, TextSearch
from foundry.viewer.server import serving

READY = ".moment .choices"


@pytest.fixture
def mine(probed: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(probed, tmp_path / "probed"))


@pytest.fixture
def page(mine: Path) -> Iterator[Any]:
    with serving(mine) as server, browser_page() as page:
        page.goto(server.url)
        page.wait_for_selector(READY)
        yield page


def moments(folder: Path) -> list[Any]:
    found: list[Any] = msgspec.json.decode(SweepFolder.open(folder).moments_file.read_bytes())["moments"]
    return found


def note(folder: Path, number: int, text: str, **keys: Any) -> bytes:
    """Return what the page sends of a moment."""
    run, step, agent = moments(folder)[number][:3]
    of_moment = {"run": run, "step": step, "agent": agent, "moment": number}
    return msgspec.json.encode({"who": "Ada", "text": text, "tags": ["odd"], **of_moment, **keys})


def noted(folder: Path) -> list[tuple[str, int | None, int | None, int | None, str]]:
    return [(one.run, one.step, one.agent, one.moment, one.text) for one in notes_of(folder).notes]


@pytest.mark.slow
def test_a_note_on_a_moment_is_found_by_a_search_and_leads_to_it(mine: Path):
    resources = Resources(mine)
    resources.take_note("probed", note(mine, 7, "It turned back."))
    run, step, agent = moments(mine)[7][:3]
    assert noted(mine) == [(run, step, agent, 7, "It turned back.")]
    search = TextSearch(SweepFolder.open(mine))
    assert search.find(Query("note", "turned"))["hits"] == [[run, step, agent, "note", "It turned back. odd Ada", 7]]
    search.close()
    resources.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "keys", "said"),
    [
        (7, {"moment": 30}, "There is no moment 30: the last is 29."),
        (7, {"moment": 8}, "Moment 8 is agent "),
        (7, {"moment": -1}, "The note cannot be read: "),
        (7, {"moment": None}, "Run '"),
    ],
)
def test_a_note_on_no_moment_of_the_probe_is_refused(mine: Path, number: int, keys: dict[str, Any], said: str):
    resources = Resources(mine)
    with pytest.raises(InputError) as raised:
        resources.take_note("probed", note(mine, number, "Here", **keys))
    assert str(raised.value).startswith(said) and noted(mine) == []
    resources.close()


@pytest.mark.browser
def test_a_moment_is_noted_by_keyboard_and_gone_to_from_its_note(page: Any, mine: Path):
    first = page.url
    page.keyboard.press("n")
    page.keyboard.type("They part here")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector("[data-note] >> text=They part here")
    number = int(page.locator(".moments [aria-current]").get_attribute("data-moment"))
    run, step, agent = moments(mine)[number][:3]
    assert noted(mine) == [(run, step, agent, number, "They part here")]
    page.keyboard.press("j")
    page.keyboard.press("j")
    assert page.url != first
    page.click("[data-note] .go >> nth=0")
    assert page.url == first
    page.click("[aria-label='Change the note: They part here']")
    assert page.locator("[aria-label='Run of the note']").is_disabled()
    page.fill("[aria-label=Note]", "They part")
    page.click(".notes button >> text=Keep")
    page.wait_for_selector("[data-note] >> text=/They part$/")
    assert noted(mine) == [(run, step, agent, number, "They part")]


@pytest.mark.browser
def test_a_hit_of_the_search_is_a_link_to_the_noted_moment(page: Any, mine: Path):
    Resources(mine).take_note("probed", note(mine, 7, "It turned back."))
    page.evaluate("location.hash = '#/runs/probed?find=turned&in=note'")
    page.click(".find .found a")
    page.wait_for_selector(".moments [aria-current][data-moment='7']")
    assert page.url.endswith("#/sweep/probed?moment=7")
    page.wait_for_selector("[data-note] >> text=It turned back.")


@pytest.mark.browser
@pytest.mark.parametrize("asked", [True, False])
def test_an_exported_probe_shows_notes_when_asked(mine: Path, tmp_path: Path, asked: bool):
    Resources(mine).take_note("probed", note(mine, 7, "It turned back."))
    exported = export(mine, tmp_path / "page", notes=asked).page
    with browser_page() as page:
        page.goto(exported.as_uri())
        page.wait_for_selector(READY)
        page.wait_for_selector(f".notes >> text={'It turned back.' if asked else 'Nothing is noted.'}")
        assert page.locator(".notes form").count() == 0
