"""Processes are killed for real; what was answered is never asked again, and nothing of the records changes."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import foundry, is_dead, is_stopping, kill, sessions, started, succeeds, wait_until
from foundry.running.lane import WAITING
from foundry.running.local import STOPPING
from foundry.storing.store import SweepFolder
from holding import CALLS, SWEEP, Holding, assert_nothing_lost_or_paid_twice, held_sweep, working
from ollama_server import OllamaServer

IMPATIENT = "model.server.retry.wait_initial_s=0.05"
INTO = (*SWEEP, "output.dir=sweep", IMPATIENT)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    workspace = tmp_path_factory.mktemp("undisturbed")
    with OllamaServer() as server:
        in_lock_step = ("runner.workers=1", "runner.ahead=false")
        done = foundry(*SWEEP, "output.dir=sweep", *in_lock_step, cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stdout + done.stderr
    assert sum(server.answered.values()) == CALLS
    yield workspace / "sweep"


def wait_until_all_report(folder: SweepFolder) -> None:
    def reported() -> dict[str, int]:
        at_work = [name for name, report in folder.progress().items() if report["open"]]
        return {name: folder.progress_file(name).stat().st_mtime_ns for name in at_work}

    before = reported()
    wait_until(lambda: all(reported().get(name, then + 1) > then for name, then in before.items()), "all report")


def all_open(folder: Path) -> int:
    if not (folder / "sweep.yaml").exists():
        return 0
    return sum(len(report["open"]) for report in SweepFolder.open(folder).progress().values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("workers", "answers"),
    [pytest.param(1, 1, marks=pytest.mark.exhaustive), pytest.param(1, 150, marks=pytest.mark.exhaustive), (2, 37)],
)
def test_a_sweep_that_was_killed_goes_on_where_it_was(workers: int, answers: int, tmp_path: Path, undisturbed: Path):
    with held_sweep(answers, *INTO, f"runner.workers={workers}", cwd=tmp_path) as sweep:
        sweep.wait_until_cached(answers)
        folder = SweepFolder.open(tmp_path / "sweep")
        wait_until(lambda: len(folder.progress()) == workers, "every worker has begun", sweep.process)
        at_work = [report["pid"] for report in folder.progress().values()]
        kill(sweep.process.pid)
        wait_until(lambda: all(map(is_dead, at_work)), "no worker outlives the command")
        sweep.holding.free()
        succeeds("resume", "sweep", cwd=tmp_path)
        assert_nothing_lost_or_paid_twice(sweep.server, tmp_path / "sweep", undisturbed)


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_only_its_unfinished_runs(tmp_path: Path, undisturbed: Path):
    with held_sweep(60, *INTO, "runner.workers=2", cwd=tmp_path) as sweep:
        sweep.wait_until_cached(60)
        kill(working(tmp_path / "sweep")[0]["pid"])
        output = sweep.finish()
        assert sweep.process.returncode == 0, output
        assert_nothing_lost_or_paid_twice(sweep.server, tmp_path / "sweep", undisturbed)


@pytest.mark.slow
def test_of_two_commands_on_one_sweep_ctrl_c_stops_its_own_in_order_and_says_how_to_go_on(
    tmp_path: Path, undisturbed: Path
):
    holding, folder = Holding(0), tmp_path / "sweep"
    with OllamaServer(holding) as server:
        with (
            started(*INTO, "runner.workers=2", "runner.open_runs=1", cwd=tmp_path, OLLAMA_HOST=server.url) as stopped,
            started(*INTO, "runner.workers=1", "runner.open_runs=4", cwd=tmp_path, OLLAMA_HOST=server.url) as other,
        ):
            wait_until(lambda: all_open(folder) == 6 and len(sessions(folder)) == 2, "each has its runs")
            os.killpg(stopped.pid, signal.SIGINT)
            wait_until(lambda: is_stopping(folder), "it was understood")
            for _ in range(2):  # a worker looks whether to stop before it reports
                wait_until_all_report(SweepFolder.open(folder))
            holding.free()
            server.drop_hanging()
            said = [process.communicate()[0] for process in (stopped, other)]
        assert (stopped.returncode, other.returncode) == (130, 0), said
        assert "foundry resume sweep" in said[0]
        assert_nothing_lost_or_paid_twice(server, folder, undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_command_whose_runs_are_all_played_by_another_says_once_that_it_waits_and_how_to_stop(
    workers: int, tmp_path: Path
):
    with held_sweep(0, *INTO, "runner.workers=1", "runner.open_runs=6", cwd=tmp_path) as sweep:
        wait_until(lambda: all_open(tmp_path / "sweep") == 6, "it plays all runs", sweep.process)
        again, host = (*INTO, f"runner.workers={workers}"), sweep.server.url
        with started(*again, cwd=tmp_path, OLLAMA_HOST=host) as second:
            assert second.stdout is not None
            said = next((line for line in second.stdout if line.startswith("waiting:")), "")
            os.killpg(second.pid, signal.SIGINT)
            rest = second.communicate()[0]
        assert said == f"{WAITING % 'sweep'}\n", rest
        assert second.returncode == 130 and "waiting:" not in rest, rest
        output = sweep.finish()
    assert sweep.process.returncode == 0 and "waiting:" not in output, output


@pytest.mark.slow
@pytest.mark.parametrize("workers", [pytest.param(1, marks=pytest.mark.exhaustive), 2])
def test_a_second_ctrl_c_stops_at_once(workers: int, tmp_path: Path):
    with held_sweep(10, *INTO, f"runner.workers={workers}", cwd=tmp_path) as sweep:
        os.killpg(sweep.process.pid, signal.SIGINT)
        wait_until(lambda: is_stopping(tmp_path / "sweep"), "the first one was understood")
        os.killpg(sweep.process.pid, signal.SIGINT)
        output, _ = sweep.process.communicate()
    assert sweep.process.returncode == 130, output
    assert "Traceback" not in output
    assert output.count(STOPPING) == 1
    assert "interrupted; go on with: foundry resume" in output
