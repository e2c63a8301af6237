"""The command: a page that is served, written as files, or watched while a sweep runs."""

import os
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

from commands import foundry, records, refusal
from foundry.cli import run
from foundry.storing.store import SweepFolder
from foundry.viewer import http
from foundry.viewer.http import PageHandler, PageServer
from made_up_runs import sweep


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for another process")
def test_view_serves_the_newest_sweep_until_it_is_interrupted(tmp_path: Path):
    for name in ("older", "newer"):
        sweep(tmp_path / "outputs" / name)
    command = [sys.executable, "-m", "foundry", "view", "--no-browser"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line.startswith("outputs/newer is shown at http://127.0.0.1:")
        with urllib.request.urlopen(line.split()[4] + "data/sweeps") as response:
            assert b"newer" in response.read()
        os.kill(process.pid, signal.SIGINT)
        assert process.wait() == 0
        assert process.stdout.read().strip() == "ended"


def test_a_page_takes_the_next_usual_port_where_one_is_taken(monkeypatch: pytest.MonkeyPatch):
    with PageServer(PageHandler) as first:
        monkeypatch.setattr(http, "USUAL_PORTS", (first.server_port, 0))
        with PageServer(PageHandler, port=None) as second:
            assert second.server_port != first.server_port


def test_view_writes_the_page_as_files(made_up: SweepFolder, tmp_path: Path):
    done = foundry("view", str(made_up.path), "--export", "page", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("4 runs in ")
    assert (tmp_path / "page" / "index.html").is_file()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("view",), "No folder outputs/ here"),
        (("view", "nothing"), "Folder 'nothing' does not exist"),
        (("view", ".", "--export", "out"), "it has no sweep.yaml"),
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(tmp_path: Path, arguments: tuple[str, ...], said: str):
    assert said in refusal(*arguments, cwd=tmp_path)


SHORT = ("model=scripted/avoid", "seed=3", "world.agents=3", "world.steps=4", "analyze=false")


@pytest.mark.slow
def test_a_watched_run_has_the_records_of_one_that_is_not(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run([*SHORT, "output.dir=plain"]) == 0
    capsys.readouterr()
    assert run([*SHORT, "output.dir=watched", "view=live"]) == 0
    assert "watch at http://127.0.0.1:" in capsys.readouterr().out
    assert records(Path("watched")) == records(Path("plain"))


def test_another_view_is_refused_before_anything_is_written(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run([*SHORT, "output.dir=there", "view=lve"]) == 2
    assert "view must be null or live; got lve" in capsys.readouterr().err
    assert not Path("there").exists()
