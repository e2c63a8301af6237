"""The page in a real browser."""

import re
import struct
from pathlib import Path
from typing import Any

import pytest

import axe
from analysis.report import render
from analysis.report.material import gather
from analysis.report.sections import MOST_OF_WORLDS
from browser import browser_page
from report_pages import narrowed
from walkers import WORLD, Habits, make_condition, write_sweep

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def page_file(hostile_sweep, hostile) -> Path:
    """The page of the hostile sweep with a few signatures alone: drawing all of them takes long."""
    page = render(
        narrowed(hostile, ("exploration.", "idle_rate.", "warning.")),
        hostile_sweep.path,
        hostile_sweep.analysis_dir / "plots",
    )
    hostile_sweep.report_file.write_text(page, encoding="utf-8")
    return hostile_sweep.report_file


@pytest.fixture
def five_models(tmp_path) -> Path:
    """The page of five models with long names over ten seeds, with every signature."""
    names = [f"hf.co/someone/some-model-{size}B-Instruct-GGUF:Q4_K_M" for size in (1, 4, 8, 14, 32)]
    world = {**WORLD, "steps": 10}
    conditions = [make_condition(name, range(10), world=world) for name in names]
    habits = {name: Habits(speak=0.2 * place, move=0.9 - 0.2 * place) for place, name in enumerate(names)}
    folder = write_sweep(tmp_path / "sweep", conditions, habits)
    page = render(gather([folder.path]), folder.path, folder.analysis_dir / "plots")
    folder.report_file.write_text(page, encoding="utf-8")
    return folder.report_file


def column(page: Any, caption: str, index: int) -> list[str]:
    cells = page.locator(f"table:has(caption:text-is('{caption}')) tbody tr > :nth-child({index})")
    return [text.strip() for text in cells.all_text_contents()]


def links_of(page: Any, selector: str) -> list[str]:
    texts: list[str] = page.locator(selector).evaluate_all("every => every.map((one) => one.getAttribute('href'))")
    return texts


def bottom(page: Any, selector: str) -> float:
    found: float = page.evaluate("(one) => document.querySelector(one).getBoundingClientRect().bottom", selector)
    return found


def test_hostile_names_stay_text_and_everything_is_on_the_page_with_a_name_and_leads_to_its_folder(page_file: Path):
    with browser_page() as page:
        page.goto(page_file.as_uri())
        assert (page.inner_text("h1"), page.title()) == ("sweep", "Report: sweep")
        assert 3 <= page.locator("figure").count() <= 1 + MOST_OF_WORLDS
        assert page.locator("script").count() == 1
        assert page.locator("img[src=x]").count() == 0
        assert page.locator("text=onerror=document.title").count() > 0
        assert "<script>document.title" in page.locator(".figures svg").first.text_content()
        assert page.locator("table:not(:has(caption))").count() == 0
        assert page.locator("th:not([scope])").count() == 0
        drawn = page.locator("svg:not([aria-hidden])").count()
        assert drawn == page.locator("[role=img][aria-label] > svg").count() > 0
        ids = page.evaluate("Array.from(document.querySelectorAll('[id]'), one => one.id)")
        assert len(set(ids)) == len(ids)
        assert page.evaluate("document.documentElement.lang") == "en"
        links = links_of(page, "td a, th a")
        assert {link.split("/")[0] for link in links} == {"runs", "baselines"}
        assert all((page_file.parent / link).is_dir() for link in set(links))
    content = page_file.read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href|url)\s*[=(]\s*"?(?:https?:)?//', content) == [], "the page asks for nothing outside"


def test_the_first_screen_holds_cards_matrix_and_claims_and_everything_else_is_one_line_with_a_number(page_file: Path):
    with browser_page() as page:
        page.goto(page_file.as_uri())
        assert page.locator("article.finding").count() == 3
        assert bottom(page, "#claims") <= 1300
        first = page.locator("article.finding").first
        assert "describes these runs" in first.inner_text() and first.locator("tbody tr").count() == 2
        parts = page.locator("details.part")
        assert parts.evaluate_all("every => every.some((one) => one.open)") is False
        titles = page.locator("details.part > summary").all_text_contents()
        assert [title for title in titles if not re.search(r"\d", title)] == []
        assert parts.evaluate_all("every => every.map((one) => one.id)")[-3:] == ["runs", "asked", "methods"]


def test_numbers_sort_by_value_with_undefined_ones_last_and_names_as_texts_by_the_keyboard(page_file: Path):
    with browser_page() as page:
        page.goto(page_file.as_uri())
        page.locator("#runs > summary").press("Enter")
        caption = "Every run. The id of a run links to its folder."
        head = page.locator(f"table:has(caption:text-is('{caption}')) th button", has_text="calls")
        head.click()
        assert column(page, caption, 5) == ["12"] * 6 + ["300"] * 11 + ["-"]
        head.click()
        assert column(page, caption, 5) == ["300"] * 11 + ["12"] * 6 + ["-"]
        assert head.locator("..").get_attribute("aria-sort") == "descending"
        caption = "Runs of each group by status, and the unreadable decisions of these runs."
        before = column(page, caption, 1)
        page.locator(f"table:has(caption:text-is('{caption}')) th button").first.press("Enter")
        assert sorted(before) == sorted(column(page, caption, 1))
        assert column(page, caption, 1)[-1] == "scripted/stay"


def test_axe_finds_nothing_wrong_and_print_leaves_out_what_cannot_be_pressed_on_paper(page_file: Path):
    with browser_page() as page:
        page.goto(page_file.as_uri())
        page.locator("#methods > summary").click()
        page.emulate_media(media="print")
        assert not page.locator("#runs").is_visible()
        assert page.locator("#methods p").first.is_visible()
        assert page.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
        page.emulate_media(media="screen")
        page.evaluate("() => document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        # All rows of a table are alike, so a few are checked.
        page.evaluate("() => document.querySelectorAll('tbody tr:nth-child(n+4)').forEach((one) => one.remove())")
        axe.check(page)


def test_five_models_in_one_world_are_at_most_1500_words_unfolded_and_all_signatures_are_there(five_models: Path):
    with browser_page() as page:
        page.goto(five_models.as_uri())
        assert 200 < len(page.inner_text("body").split()) <= 1500
        assert page.locator("#signatures details").count() > 10


def test_a_figure_is_downloaded_as_a_picture_and_printed_alone_and_its_files_are_there(page_file: Path):
    with browser_page() as page:
        page.goto(page_file.as_uri())
        page.evaluate("() => document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        assert all((page_file.parent / link).is_file() for link in links_of(page, ".files a"))
        with page.expect_download() as got:
            page.get_by_role("button", name="PNG").first.click()
        assert struct.unpack(">I", got.value.path().read_bytes()[16:20])[0] == 1020, "one column with 300 dots an inch"
        page.evaluate(
            "() => { window.print = () => { window.pages = document.querySelectorAll('.alone .printed').length; }; }"
        )
        page.get_by_role("button", name="PDF").first.click()
        assert page.evaluate("window.pages") == 1
