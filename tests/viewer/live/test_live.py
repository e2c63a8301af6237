"""A page that is open while runs are being written."""

import json
import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import pytest

import made_up_rounds
from commands import answers, wait_until
from foundry import own_code
from foundry.viewer.live import serve_live
from foundry.viewer.server import serving
from made_up_runs import Playing, sweep, whole_run
from viewer_pages import go, shown

pytestmark = pytest.mark.browser

CODE = """
import sys
from pathlib import Path
from foundry.viewer.live import serve_live
with serve_live(Path(sys.argv[1])) as url:
    print(url, flush=True)
    sys.stdin.read()
"""


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
        page.wait_for_selector(".progress .is-complete")
        page.wait_for_selector("[data-sort='idle_rate.share']")
        assert "1 of 1 runs ended" in page.text_content(".progress")
        assert page.evaluate("() => document.activeElement.closest('tbody') !== null"), "the keyboard keeps its place"
        page.goto("about:blank")


def test_a_world_of_ones_own_is_drawn_by_a_process_of_its_own_as_long_as_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv(own_code.VARIABLE, str(Path(made_up_rounds.__file__).parent))
    made = made_up_rounds.sweep(tmp_path / "served", models=("first",))
    made_up_rounds.whole_run(made.runs()[0])
    asked = f"data/run/served/{made.runs()[0].id}/picture/3"
    with serve_live(made.path, ("made_up_rounds",)) as url, urllib.request.urlopen(url + asked) as response:
        assert response.read().startswith(b"\x89PNG")
    assert not answers(url)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows kills no process group")
def test_the_server_ends_with_the_process_that_started_it(tmp_path: Path):
    made = sweep(tmp_path / "served")
    command = [sys.executable, "-c", CODE, str(made.path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        assert answers(url)
        os.kill(process.pid, signal.SIGKILL)
    wait_until(lambda: not answers(url), "the server goes on without the process that started it")


def test_what_open_runs_do_and_what_failed_is_shown_while_a_sweep_is_played(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "busy", seeds=(0, 1, 2))
    first, second, third = made.runs()[:3]
    whole_run(first)
    Playing(second).end("the server is gone <b>")
    playing = Playing(third)
    playing.play(1, 2)
    playing.writer.close()
    made.start_progress()
    tally = {"complete": 1, "failed": 1, "calls": 66, "cached": 33, "retries": 2, "output_tokens": 100, "spared": 30}
    so_far = {"calls": 16, "cached": 3, "retries": 1, "prompt_tokens": 9, "output_tokens": 80}
    limits = {"server": {"wanted": 12, "allowed": 8}}
    report = {
        "open": [third.id],
        "most": {third.id: 48},
        "counts": {third.id: so_far},
        "models": {"first": tally},
        "limits": limits,
    }
    made.progress_file("0-1").write_text(json.dumps(report), encoding="utf-8")
    with serving(made.path) as server:
        go(page, server.url, "sweep/busy")
        page.click("text=live progress")
        page.wait_for_selector(".live tbody tr")
        told = page.text_content(".live")
        assert page.text_content("tbody tr").startswith(f"{third.id}firstpaper22 of 616 of 48")
        assert "without the calls of second, whose number is unknown" in told
        assert "66 made in this session" in told and "50 % of the calls" in told
        assert "12 calls sent or waiting; at most 8 at a time" in told
        assert "1 × BackendError: the server is gone <b>" in told
        assert page.text_content(".again") == f"foundry resume {made.path}"
        page.goto("about:blank")


def test_the_end_is_told_by_the_calls_left_and_the_calls_a_second_so_far(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "pace")
    with shown(page, made, "live/pace"):
        page.wait_for_selector(".live dl")
        tell = """counts => {
          const live = Foundry.page, runs = live.looks[0].runs;
          const looked = {...live.looks[0], workers: 1, left: 600, unknown: ["second"], counts: {waiting: runs}};
          live.disposed = true;
          live.looks = [];
          counts.forEach((calls, index) => live.take({...looked, at: 2 * index, calls, cached: 0}));
          return live.element.textContent;
        }"""
        assert "not known yet" in page.evaluate(tell, [1, 10, 20, 30])
        told = page.evaluate(tell, [0, 0, 20, 20, 40])
        assert "5 calls sent per second" in told
        assert re.search(r"in 2 min \(\d\d:\d\d\), if the speed stays the same, without the calls of second", told)
