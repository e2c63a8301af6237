"""What the El Farol example adds to the page of its runs, in a real browser."""

from pathlib import Path

import pytest

import foundry
from browser import browser_page
from commands import foundry as command
from foundry import paths
from foundry.storing.store import SweepFolder

MINE = paths.PACKAGE.parent / "examples" / "el_farol" / "mine"
pytestmark = pytest.mark.browser


def test_its_page_says_how_many_went_on_every_evening(tmp_path: Path):
    own = ("--config-dir", str(MINE))
    asked = ("world=el_farol", "model=scripted/random", "world.steps=4", "output.dir=bar", "analyze=false")
    assert command(*own, *asked, cwd=tmp_path).returncode == 0
    assert command("view", "bar", "--export", "page", *own, cwd=tmp_path).returncode == 0
    steps = foundry.load(tmp_path / "bar").steps
    run = SweepFolder.open(tmp_path / "bar").runs()[0].id
    with browser_page() as page:
        for step in (1, 2, 4):
            went = int((steps[steps["step"] == step]["action"] == "go").sum())
            page.goto(f"{(tmp_path / 'page' / 'index.html').as_uri()}#run/bar/{run}?step={step}")
            page.reload()
            page.wait_for_function("text => document.querySelector('.attendance')?.textContent === text",
                                   arg=f"Evening {step}:  {went} of 10 went")  # fmt: skip
