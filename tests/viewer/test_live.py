"""A page that is open while runs are being written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import pytest

import made_up_rounds
from commands import wait_until
from foundry import own_code
from foundry.viewer.live import serve_live
from foundry.viewer.server import serving
from made_up_runs import Playing, mishaps, sweep

pytestmark = pytest.mark.browser

CODE = """
import sys, time
from pathlib import Path
from foundry.viewer.live import serve_live
with serve_live(Path(sys.argv[1])) as url:
    print(url, flush=True)
    time.sleep(60)
"""


def answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=5) as response:
            return bool(response.status == 200)
    except OSError:
        return False


def test_a_page_that_was_opened_before_its_run_began_follows_it(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "grows")
    with serving(made.path) as server:
        page.goto(f"{server.url}#/run/grows/{made.runs()[0].id}")
        page.wait_for_function("() => document.querySelector('.where')?.textContent === 'no step yet'")
        assert page.is_checked(".follow input")
        playing = Playing(made.runs()[0], mishaps)
        playing.play(1, 4)
        page.wait_for_function("() => document.querySelector('.where').textContent === 'after step 4 of 4'")
        page.wait_for_function("() => Foundry.page.data.marks.undecided?.[3] === 1")
        playing.play(5, 6)
        playing.end("the server is gone")
        page.wait_for_selector(".state .is-failed")
        assert "the server is gone" in page.text_content(".heading .warning")
        assert page.text_content(".where") == "after step 6 of 6"
        assert page.is_hidden(".follow")
        page.goto("about:blank")


def test_a_run_that_is_being_written_is_opened_at_its_end_and_followed(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "goes on", models=("first",), seeds=(0,))
    playing = Playing(made.runs()[0])
    playing.play(1, 3)
    made.start_progress()
    made.progress_file("0").write_text(f'{{"pid": 0, "open": ["{made.runs()[0].id}"], "models": {{}}}}')
    with serving(made.path) as server:
        page.goto(f"{server.url}#/run/goes-on/{made.runs()[0].id}")
        page.wait_for_function("() => document.querySelector('.where')?.textContent === 'after step 3 of 3'")
        assert page.is_checked(".follow input")
        page.goto("about:blank")
        page.goto(f"{server.url}#/run/goes-on/{made.runs()[0].id}?step=2")
        page.wait_for_function("() => document.querySelector('.where')?.textContent === 'step 2 of 3'")
        assert not page.is_checked(".follow input"), "an address that names a step is that of the step"
        page.goto("about:blank")
    playing.end()


def test_the_overview_follows_a_sweep_until_it_is_analysed(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "goes on", models=("first",), seeds=(0,))
    with serving(made.path) as server:
        page.goto(server.url)
        page.wait_for_selector(".is-waiting")
        page.focus("tbody a")
        playing = Playing(made.runs()[0])
        playing.play(1, 6)
        made.analysis_dir.mkdir()
        rows = f"run,idle_rate.share\n{made.runs()[0].id},0.25\n"
        made.signatures_path.write_text(rows, encoding="utf-8")
        playing.end()
        page.wait_for_selector("tbody .is-complete")
        page.wait_for_selector("[data-sort='idle_rate.share']")
        assert "1 of 1 runs ended" in page.text_content(".progress")
        assert page.locator("[data-filter=status] option[value=complete]").count() == 1
        assert page.evaluate("() => document.activeElement.closest('tbody') !== null"), "the keyboard keeps its place"
        page.goto("about:blank")


def test_a_sweep_is_served_from_a_process_of_its_own_as_long_as_asked(tmp_path: Path):
    made = sweep(tmp_path / "served")
    with serve_live(made.path) as url:
        assert answers(f"{url}data/sweeps")
    assert not answers(url)


def test_a_world_of_ones_own_that_is_being_run_is_drawn_by_that_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv(own_code.VARIABLE, str(Path(made_up_rounds.__file__).parent))
    made = made_up_rounds.sweep(tmp_path / "served", models=("first",))
    made_up_rounds.whole_run(made.runs()[0])
    asked = f"data/run/served/{made.runs()[0].id}/picture/3"
    with serve_live(made.path, ("made_up_rounds",)) as url, urllib.request.urlopen(url + asked, timeout=30) as response:
        assert response.read().startswith(b"\x89PNG")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows kills no process group")
def test_the_server_ends_with_the_process_that_started_it(tmp_path: Path):
    made = sweep(tmp_path / "served")
    command = [sys.executable, "-c", CODE, str(made.path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        assert answers(url)
        os.kill(process.pid, signal.SIGKILL)
    wait_until(lambda: not answers(url), "the server goes on without the process that started it")
