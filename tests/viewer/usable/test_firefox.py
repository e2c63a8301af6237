"""The main path through the viewer in Firefox: its console stays free of errors, and nothing outside is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from firefox import Firefox
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from made_up_runs import STEPS, Playing, sweep
from viewer.usable.conftest import Forms

pytestmark = pytest.mark.firefox


@pytest.fixture(scope="module")
def firefox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Firefox]:
    with Firefox.started(tmp_path_factory.mktemp("profile")) as page:
        yield page


def at_step(step: int) -> str:
    return f"document.querySelector('.where')?.textContent === 'step {step} of {STEPS}'"


def rows(many: int) -> str:
    return f"document.querySelectorAll('tr[data-run]').length === {many}"


def is_shown(element: str) -> str:
    return f"document.querySelector({element!r})"


def open_sweep(firefox: Firefox, url: str) -> None:
    """Open the page of the 2D sweep, and wait until nothing on it moves any more."""
    firefox.goto(f"{url}#/sweep/grid")
    firefox.wait_for(f"{rows(4)} && {is_shown('.groups button')} && {is_shown('.links a')}")


def test_runs_are_filtered_opened_stepped_and_played(firefox: Firefox, forms: Forms):
    open_sweep(firefox, forms.server.url)
    firefox.write("[aria-label='Filter runs']", "second")
    firefox.wait_for(rows(2))
    firefox.click("tr[data-run] a")
    firefox.wait_for(at_step(1))
    firefox.press("ArrowRight", "]")
    firefox.wait_for(f"{at_step(2)} && {is_shown('.inspector .facts')}")
    firefox.press("+", "+", "+", " ")
    firefox.wait_for(f"document.querySelector('.where').textContent === 'after step {STEPS} of {STEPS}'")
    assert firefox.evaluate("location.hash.endsWith('agent=0')")


@pytest.mark.parametrize("form", ["grid", "rounds", "camera"])
def test_runs_side_by_side_show_where_they_part(firefox: Firefox, forms: Forms, form: str):
    firefox.goto(f"{forms.server.url}#/{forms.compared(form)}")
    firefox.click(".verdict .go")
    firefox.wait_for("document.querySelectorAll('.column .facts, .column .quote').length > 1")
    assert firefox.evaluate("document.querySelectorAll('.panel').length") == 2


def test_texts_are_found_in_all_runs(firefox: Firefox, forms: Forms):
    open_sweep(firefox, forms.server.url)
    firefox.write(".find input", "hello")
    firefox.click(".find .found a")
    firefox.wait_for(is_shown(".inspector .quote"))


def test_a_probe_is_gone_through_by_keys(firefox: Firefox, forms: Forms):
    firefox.goto(f"{forms.server.url}#/sweep/probe")
    firefox.wait_for(is_shown(".moment .choices"))
    firefox.press("j", "e")
    firefox.wait_for("location.hash.includes('edit=no_fire') && document.querySelectorAll('.map svg').length === 2")


def test_an_exported_page_is_opened_from_its_files(firefox: Firefox, forms: Forms, tmp_path: Path):
    open_sweep(firefox, export(forms.grid.path, tmp_path / "page").page.as_uri())
    firefox.click("tr[data-run] a")
    firefox.wait_for(at_step(1))
    firefox.press("]")
    firefox.wait_for(is_shown(".inspector .quote"))


def test_a_run_is_followed_while_it_is_written(firefox: Firefox, tmp_path: Path):
    made: SweepFolder = sweep(tmp_path / "grows", models=("first",), seeds=(0,))
    with serving(made.path) as server:
        firefox.goto(f"{server.url}#/run/grows/{made.runs()[0].id}")
        firefox.wait_for("document.querySelector('.where')?.textContent === 'no step yet'")
        playing = Playing(made.runs()[0])
        playing.play(1, 4)
        firefox.wait_for("document.querySelector('.where').textContent === 'after step 4 of 4'")
        firefox.goto("about:blank")
        playing.end()
