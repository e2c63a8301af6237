"""What the page of a 3D run shows of worlds that tell a way or ask questions: with no code of such a world's own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from browser import put_aside
from foundry.cli import run
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import serving
from labelled_rooms import TINY, write_rooms
from viewer_pages import go

pytestmark = pytest.mark.browser


def played(rooms: Path, world: str, model: str) -> SweepFolder:
    scene = write_rooms(rooms / "rooms.usda")
    asked = [f"world={world}", f"scene='{scene}'", f"model=scripted/{model}", "seed=1", *TINY]
    with put_aside():
        assert run([*asked, "output.dir=sweep", "analyze=false", "runner.workers=1"]) == 0
    return SweepFolder.open(rooms / "sweep")


def test_a_told_way_stands_above_the_run_in_both_languages(page: Any, workspace: Path):
    sweep = played(workspace, "follow", "oracle")
    with serving(sweep.path) as server:
        go(page, server.url, f"run/sweep/{sweep.runs()[0].id}")
        page.wait_for_selector(".told-way")
        shown = page.text_content(".goal")
        assert "Told in english: " in shown and "Told in japanese: " in shown and "Stop at the " in shown
        page.wait_for_function("() => document.querySelector('.seen').naturalWidth === 96")


def test_a_question_is_shown_with_its_choices_and_answers_and_its_walk_is_exported(page: Any, workspace: Path):
    sweep = played(workspace, "map_probe", "knower")
    with serving(sweep.path) as server:
        go(page, server.url, f"run/sweep/{sweep.runs()[0].id}")
        page.wait_for_selector(".decision .question")
        shown = page.text_content(".decision")
        assert "Question: nearer" in shown and "Which of the two is nearer" in shown and "A: " in shown
        assert "right answer" in shown and "answer " in shown
        assert "Questions after a walk in rooms." in page.text_content(".goal")
        loaded = (
            "() => [...document.querySelectorAll('.walk img')].filter((one) => one.naturalWidth === 96).length === 8"
        )
        page.wait_for_function(loaded)
        page.wait_for_function("() => document.querySelector('.seen').naturalWidth === 96")
    exported = export(sweep.path, workspace / "page")
    kept = sorted(file.name for file in exported.page.parent.rglob("walk_*.png"))
    assert kept == [f"walk_{number:04d}.png" for number in range(1, 9)]
