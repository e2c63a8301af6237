"""Notes on the pages: written by keyboard, filtered by tag, found by a search, read in an export."""

import csv
import io
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from foundry.storing.notes import Note, add_note, notes_of
from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer, serving
from made_up_runs import sweep, whole_run
from viewer_pages import SHOWN, go, saved

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Two models and two seeds; one note on a moment of the first run. Read only."""
    found = sweep(tmp_path_factory.mktemp("played") / "played")
    for run in found.runs():
        whole_run(run)
    add_note(found.path, note(found, step=3, agent=1, text="It turned <b>back</b>.", tags=("odd",)))
    return found


@pytest.fixture(scope="module")
def copies(played: SweepFolder) -> list[Path]:
    """A sweep for each test that writes notes; a page that is open learns of no further one."""
    return [Path(shutil.copytree(played.path, played.path.parent / f"copy-{number}")) for number in range(6)]


@pytest.fixture(scope="module")
def served(played: SweepFolder, copies: list[Path]) -> Iterator[ViewServer]:
    with serving(played.path.parent) as running:
        yield running


@pytest.fixture
def made(copies: list[Path]) -> SweepFolder:
    return SweepFolder.open(copies.pop())


def note(made: SweepFolder, run: int = 0, **keys: Any) -> Note:
    given: dict[str, Any] = {
        "note": "a",
        "when": "2026-01-01T09:30:00+00:00",
        "who": "Ada",
        "step": None,
        "agent": None,
    }
    return Note(run=made.runs()[run].id, **{**given, "text": "", "tags": (), **keys})


def noted(made: SweepFolder) -> list[tuple[str, int | None, int | None, str, tuple[str, ...]]]:
    return [(note.run, note.step, note.agent, note.text, note.tags) for note in notes_of(made.path).notes]


def test_a_note_on_a_run_is_written_by_keyboard_and_its_tag_leaves_the_run(
    page: Any, served: ViewServer, made: SweepFolder
):
    go(page, served.url, f"sweep/{made.path.name}")
    second = made.runs()[1].id
    page.focus(f"[aria-label='Compare {second}']")
    page.keyboard.press("n")
    page.keyboard.type("Left too late")
    page.keyboard.press("Tab")
    page.keyboard.type("Late stuck")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector("dialog [data-note] >> text=Left too late")
    page.keyboard.press("Escape")
    page.wait_for_selector("dialog", state="detached")
    assert page.evaluate("() => document.activeElement.ariaLabel") == f"Notes on {second}"
    assert noted(made)[1] == (second, None, None, "Left too late", ("Late", "stuck"))
    page.click("[aria-label='Only runs with the tag late']")
    page.wait_for_function(SHOWN, arg="1 of 4 runs")
    assert page.url.endswith("?q=tag%3Alate")
    page.fill("[aria-label='Filter and search']", "tag:")
    page.wait_for_function(SHOWN, arg="2 of 4 runs")
    page.fill("[aria-label='Filter and search']", "tag:lat")
    page.wait_for_function(SHOWN, arg="0 of 4 runs")
    page.fill("[aria-label='Filter and search']", "too late")
    page.wait_for_function(SHOWN, arg="1 of 4 runs")


def test_a_note_on_a_moment_is_written_changed_and_deleted_on_the_page_of_the_run(
    page: Any, served: ViewServer, made: SweepFolder
):
    run = made.runs()[0].id
    go(page, served.url, f"run/{made.path.name}/{run}?step=5&agent=2")
    page.wait_for_selector(".inspector h3")
    page.keyboard.press("n")
    page.keyboard.type("Here")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector("[data-note] >> text=Here")
    assert noted(made)[1] == (run, 5, 2, "Here", ())
    page.click(".notes button >> text=step 3 · agent 1")
    assert page.text_content(".where") == "step 3 of 6"
    assert page.input_value("[aria-label=Agent]") == "1"
    page.click("[aria-label='Change the note: Here']")
    page.fill("[aria-label=Note]", "Here it is")
    page.click(".notes button >> text=Save")
    page.wait_for_selector("[data-note] >> text=Here it is")
    assert noted(made)[1] == (run, 5, 2, "Here it is", ())
    page.click("[aria-label='Delete the note: Here it is']")
    page.wait_for_function("() => document.querySelectorAll('[data-note]').length === 1")
    assert len(noted(made)) == 1


def test_compared_runs_have_their_notes_and_take_one_on_any_of_them(page: Any, served: ViewServer, made: SweepFolder):
    first, _, third, _ = (run.id for run in made.runs())
    go(page, served.url, f"compare/{made.path.name}/{first}/{third}?step=4")
    page.wait_for_selector(".notes [data-note]")
    assert page.text_content(".notes [data-note]").startswith("first: step 3 · agent 1 It turned <b>back</b>. odd Ada,")
    page.keyboard.press("n")
    page.keyboard.type("They part")
    page.select_option("[aria-label='Run of the note']", third)
    page.click(".notes button >> text=Save")
    page.wait_for_selector("[data-note] >> text=They part")
    assert noted(made)[1] == (third, 4, None, "They part", ())


def test_a_note_that_a_crash_cut_is_told_beside_the_others(page: Any, served: ViewServer, made: SweepFolder):
    with (made.path / "notes.jsonl").open("ab") as lines:
        lines.write(b'{"note": "b", "who"')
    go(page, served.url, f"sweep/{made.path.name}")
    page.wait_for_selector(".warning >> text=Line 2 of notes.jsonl is left out")
    page.click("[aria-label^='Notes on'] >> nth=0")
    page.wait_for_selector("dialog [role=status] >> text=Line 2 of notes.jsonl is left out")
    assert page.locator("dialog [data-note]").count() == 1


def test_a_table_is_saved_with_notes_when_asked(page: Any, served: ViewServer, made: SweepFolder):
    further = note(made, note="b", who="Grace", step=None, text='Two\nlines, "quoted"', tags=("late", "odd"))
    alone, other = note(made, note="c", step=2, tags=("tag-alone",)), note(made, 1, note="d", text="Another run")
    for one in (further, alone, other):
        add_note(made.path, one)
    go(page, served.url, f"sweep/{made.path.name}?model=first")
    page.wait_for_selector("[data-save=csv]")
    plain = list(csv.DictReader(io.StringIO(saved(page, "csv").decode(), newline="")))
    assert {"tags", "notes"}.isdisjoint(plain[0])
    page.check("label >> text=with notes")
    rows = list(csv.DictReader(io.StringIO(saved(page, "csv").decode(), newline="")))
    first = ("odd late tag-alone", 'step 3 · agent 1: It turned <b>back</b>.\nthe run: Two\nlines, "quoted"')
    assert [(row["tags"], row["notes"]) for row in rows] == [first, ("", "the run: Another run")]
    assert b"Ada" not in saved(page, "csv") and b"Grace" not in saved(page, "csv")
