"""What a user is told of a sweep while it runs: how far each model is, how fast it goes, how long it will take."""

import io
import itertools
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import pytest
import zstandard
from rich.console import Console
from rich.table import Table

from commands import succeeds, wait_until
from foundry.cli import run
from foundry.composing.compose import compose
from foundry.display import ProgressDisplay, frame_table, ran_line, status_table
from foundry.expansion import Sweep, expand
from foundry.running.lane import Tally
from foundry.running.local import SweepJob
from foundry.storing.run_files import calls_bytes
from foundry.storing.standing import counts_so_far, standings
from foundry.storing.store import SweepFolder, write_atomically
from ollama_cases import Body
from ollama_server import OllamaServer

AGENTS, STEPS = 5, 10
MOST = 2 * AGENTS * STEPS
"""Calls of a run, at most."""
LATER = 10 * MOST
"""Calls of the model that waits."""
LOOKS = 100


@dataclass
class Watched:
    """A sweep that is watched by a clock of its own, with one worker whose reports a test writes."""

    folder: SweepFolder
    tallies: dict[str, Tally] = field(default_factory=dict)
    now: float = 1000.0

    def __post_init__(self) -> None:
        self.folder.start_progress()
        self.console = Console(file=io.StringIO(), width=120)
        self.display = ProgressDisplay(self.folder, self.console, clock=lambda: self.now)

    def after(self, seconds: float, **tallies: Tally) -> list[str]:
        """Let time pass, report, and look; returns the time left and what is told of the reported model."""
        self.now += seconds
        self.tallies |= tallies
        report = {"pid": 1, "open": [], "counts": {}, "models": {k: vars(v) for k, v in self.tallies.items()}}
        write_atomically(self.folder.progress_file("0-0"), msgspec.json.encode(report))
        totals, name = self.display.look(), next(iter(tallies))
        left_s = self.display.left_s(totals)
        return ([f"{left_s:.0f} s left"] if left_s else []) + self.display.told(name, totals[name])

    def play(self, model: str, calls_per_s: float, seconds: float, so_far: Tally) -> list[str]:
        """Have a model answer at a steady speed, whole calls only; returns what is told at the end."""
        told, before = [], so_far.calls
        for look in range(1, LOOKS + 1):
            so_far.calls = before + int(calls_per_s * seconds * look / LOOKS)
            told = self.after(seconds / LOOKS, **{model: so_far})
        return told


def sweep_of(models: str) -> Sweep:
    composed = compose(["-m", f"model={models}", "seed=0-9", f"world.agents={AGENTS}", f"world.steps={STEPS}"])
    return expand(composed.asked, composed.conditions)


@pytest.fixture(scope="module")
def sweep() -> Sweep:
    """Ten runs of each of two served models, which are asked one after the other."""
    return sweep_of("stay,random")


@pytest.fixture
def watch(sweep: Sweep, tmp_path: Path) -> Callable[[], Watched]:
    return lambda: Watched(SweepFolder.create(tmp_path / "out", sweep, {}, []))


def seconds_left(told: list[str]) -> int:
    (left,) = [part.removesuffix(" s left") for part in told if part.endswith(" left")]
    return int(left)


def test_the_time_left_covers_the_models_that_wait_and_ends_with_the_last_call(watch):
    watched = watch()
    watched.play("stay", calls_per_s=10.0, seconds=100, so_far=Tally())
    left = watched.after(1, stay=Tally(complete=10, calls=10 * MOST))
    assert seconds_left(left) == pytest.approx(LATER / 10.0, rel=0.03)
    assert left[1:] == ["1,000 calls"]
    assert watched.after(2000, random=Tally())[1:] == ["no reply yet"]
    watched.after(1, random=Tally(complete=10, calls=LATER))
    assert watched.display.left_s(watched.display.look()) == 0


@pytest.mark.parametrize("calls_per_s", [0.01, 2.0, 30.0])
def test_the_time_left_of_slow_and_fast_models_is_right_alike_from_the_first_run_on(calls_per_s: float, watch):
    watched, so_far = watch(), Tally()
    for seconds in (80 / calls_per_s, 120 / calls_per_s):
        told = watched.play("stay", calls_per_s, seconds, so_far=so_far)
        assert seconds_left(told) == pytest.approx((10 * MOST - so_far.calls + LATER) / calls_per_s, rel=0.05)


def test_runs_that_end_early_shorten_the_time_left(watch):
    watched = watch()
    calls = MOST // 4
    for ended in range(1, 5):
        told = watched.after(100, stay=Tally(complete=ended, calls=ended * calls, spared=ended * (MOST - calls)))
    assert seconds_left(told) == pytest.approx((6 + 10) * 100, rel=0.05)
    assert watched.display.look()["stay"].done == 4 * MOST


def test_answers_of_the_cache_say_nothing_of_the_speed_of_the_others_unless_all_are_cached(watch):
    watched = watch()
    for second in range(1, 6):
        told = watched.after(1, stay=Tally(calls=100 * second, cached=100 * second))
    assert told == ["15 s left", "100 calls/s", "500 cached"]
    for second in range(1, 31):
        told = watched.after(1, stay=Tally(calls=500 + second, cached=500))
    assert told[1:] == ["1.0 calls/s", "500 cached"]


def test_nothing_is_said_of_speed_before_there_is_any(watch):
    watched = watch()
    assert watched.after(1, stay=Tally()) == ["no reply yet"]
    assert watched.after(1, stay=Tally(calls=1)) == []
    assert watched.after(1, stay=Tally(calls=2, retries=3, failed=1))[1:] == ["3 retries", "1 failed"]


def test_a_line_of_a_log_tells_of_the_models_at_work(watch):
    watched = watch()
    watched.after(5, stay=Tally(complete=10, calls=1000))
    watched.after(5, random=Tally(complete=1, calls=150))
    watched.after(5, random=Tally(complete=2, calls=200))
    assert watched.display.line(watched.display.look()) == ("[0:00:15] 0:01:20 left; random 2/10 runs, 10 calls/s")


def test_what_ended_before_this_session_is_done_and_not_counted_as_speed(workspace: Path):
    asked = ["-m", "model=scripted/stay", "seed=0-3", "output.dir=out", f"world.agents={AGENTS}", "analyze=false"]
    assert run([*asked, f"world.steps={STEPS}"]) == 0
    folder = SweepFolder.open(workspace / "out")
    tally, summary = Tally(), folder.runs()[0].summary()
    assert summary is not None
    tally.end(summary, MOST + 7)
    assert (tally.complete, tally.calls, tally.spared) == (1, MOST, 7)
    (folder.runs()[0].path / "run.json").unlink()
    watched = Watched(folder)
    assert watched.display.look()["scripted/stay"].done == 3 * MOST
    told = watched.play("scripted/stay", calls_per_s=1.0, seconds=10, so_far=Tally())
    assert seconds_left(told) == pytest.approx(90, rel=0.05)


def test_the_status_of_a_sweep_shows_the_calls_of_running_runs(workspace: Path):
    shown: list[str] = []

    def look(number: int, body: Body) -> None:
        if number == 7:
            folder = SweepFolder.open(workspace / "out")
            wait_until(lambda: _calls_of(folder) == 6, "the worker has reported whole rounds")
            console = Console(file=io.StringIO(), width=120)
            console.print(table_of(folder))
            shown.extend(console.file.getvalue().splitlines())  # type: ignore[attr-defined]

    alone = "model.server.in_flight={min: 1, max: 1, initial: 1}"  # so the first six are answered before the seventh
    asked = ("model=llama3.2", alone, "world.agents=2", "world.steps=2", "analyze=false", "output.dir=out")
    with OllamaServer(on_chat=look) as server:
        succeeds(*asked, cwd=workspace, OLLAMA_HOST=server.url)
    head, row = map(str.split, shown)
    assert dict(zip(head, row, strict=True)) == {
        **{"model": "llama3.2", "runs": "1", "complete": "0", "failed": "0", "running": "1", "waiting": "0"},
        **{"calls": "6", "cached": "0", "retries": "0"},
    }


def test_the_status_says_what_share_of_the_prompts_came_from_a_servers_prompt_cache_where_it_tells(watch):
    folder = watch().folder
    folder.start_progress()
    one, two, silent = (run.id for run in folder.runs()[:3])
    counts = {
        one: {"calls": 3, "prompt_tokens": 300, "cached_tokens": 30},
        two: {"calls": 1, "prompt_tokens": 100, "cached_tokens": 90},
        silent: {"calls": 1, "prompt_tokens": 5000, "cached_tokens": None},
    }
    report = {"open": [], "counts": counts, "models": {}}
    write_atomically(folder.progress_file("0-0"), msgspec.json.encode(report))
    table = table_of(folder)
    assert [str(cell) for cell in table.columns[-1].cells] == ["30%", ""]
    folder.end_progress()
    assert len(table_of(folder).columns) == len(table.columns) - 1
    narrow = status_table(standings(folder, [run.summary() for run in folder.runs()]), width=80)
    assert [str(column.header) for column in narrow.columns] == ["model", "runs", "complete", "waiting", "calls"]


def test_the_calls_of_runs_that_were_interrupted_in_their_first_steps_are_counted(workspace: Path):
    asked = ["-m", "model=scripted/stay", "seed=0-2", "output.dir=out", f"world.agents={AGENTS}", "analyze=false"]
    assert run([*asked, "world.steps=1"]) == 0
    folder = SweepFolder.open(workspace / "out")
    cut, damaged, _ = folder.runs()
    for interrupted in (cut, damaged):
        (interrupted.path / "run.json").unlink()
    three = calls_bytes([*itertools.islice(damaged.calls(), 3)])
    damaged.stream_path("calls").write_bytes(three + zstandard.compress(b"not a call\n"))
    summaries, calls = [run.summary() for run in folder.runs()], 2 * 2 * AGENTS + 3
    (row,) = standings(folder, summaries)
    assert (row.complete, row.waiting, row.calls) == (1, 2, calls)
    assert ran_line(
        summaries, list(counts_so_far(folder, summaries, folder.progress().values())), Path("out")
    ).endswith(f", {calls} calls")


def _calls_of(folder: SweepFolder) -> int:
    return sum(counts["calls"] for report in folder.progress().values() for counts in report["counts"].values())


def test_a_command_that_begins_or_ends_leaves_another_at_work_on_the_same_sweep(sweep: Sweep, tmp_path: Path):
    folder = SweepFolder.create(tmp_path / "shared", sweep, {}, [])
    jobs = [SweepJob(folder, {}, "", 0) for _ in range(2)]
    one, two = (job.session for job in jobs)
    folder.start_progress(one)
    reports = folder.progress_file("any").parent
    jobs[0].stop()
    folder.start_progress(two)
    assert (folder.stop_asked(one), folder.stop_asked(two)) == (True, False)
    for session in (one, two):
        write_atomically(folder.progress_file(f"{session}-0-0"), b'{"open": [], "models": {}}')
    folder.end_progress(one)
    assert (list(folder.progress()), folder.stop_asked(two)) == ([f"{two}-0-0"], False)
    folder.end_progress(two)
    assert not reports.exists()
    jobs[1].stop()  # a Ctrl-C at the very end
    assert jobs[1].stop_asked() and not reports.exists()


def test_a_command_that_ends_before_another_has_reported_leaves_it_at_work(sweep: Sweep, tmp_path: Path):
    folder = SweepFolder.create(tmp_path / "shared", sweep, {}, [])
    for session in ("old", "new"):
        folder.start_progress(session)
    write_atomically(folder.progress_file("old-0-0"), b'{"open": [], "models": {}}')
    folder.end_progress("old")
    assert not folder.stop_asked("new")
    write_atomically(folder.progress_file("new-0-0"), b'{"open": [], "models": {}}')
    assert folder.stop_asked("old") and list(folder.progress()) == ["new-0-0"]
    folder.end_progress("new")
    assert not (folder.path / "progress").exists()


def table_of(folder: SweepFolder) -> Table:
    return status_table(standings(folder, [run.summary() for run in folder.runs()]))


def test_a_table_on_a_narrow_terminal_breaks_texts_at_spaces_and_keeps_names_whole():
    name, prose = "qwen3:4b-instruct-q8_0", "no connection to the server and nothing else was checked"
    screen = Console(file=io.StringIO(), width=60)
    screen.print(frame_table([(name, prose, prose)], ("model", "found", "what to do")))
    text = screen.file.getvalue()  # type: ignore[attr-defined]
    words = text.split()
    assert name in words and all(words.count(word) >= 2 for word in prose.split())
    assert max(map(len, text.splitlines())) <= 60
    narrow = Console(file=io.StringIO(), width=20)
    narrow.print(frame_table([(name, prose, prose)], ("model", "found", "what to do")))
    assert max(map(len, narrow.file.getvalue().splitlines())) <= 20  # type: ignore[attr-defined]


def test_a_session_that_ends_while_a_thread_looks_at_it_has_no_reports(sweep: Sweep, tmp_path, monkeypatch):
    folder = SweepFolder.create(tmp_path / "ending", sweep, {}, [])
    folder.start_progress()
    listed = os.scandir

    def just_removed(path):
        monkeypatch.setattr(os, "scandir", listed)
        folder.end_progress()
        return listed(path)

    monkeypatch.setattr(os, "scandir", just_removed)
    assert folder.progress() == {}
    assert not (folder.path / "progress").exists()


def test_a_command_begins_though_another_removes_the_folder_of_reports_meanwhile(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    folder = SweepFolder.create(tmp_path / "shared", sweep, {}, [])
    folder.start_progress("old")
    touched = Path.touch

    def just_removed(path: Path) -> None:
        monkeypatch.setattr(Path, "touch", touched)
        folder.end_progress("old")
        touched(path)

    monkeypatch.setattr(Path, "touch", just_removed)
    folder.start_progress("new")
    assert (folder.stop_asked("old"), folder.stop_asked("new")) == (True, False)
