"""Workers die, runs fail, and what cannot be run is refused; the others go on."""

from __future__ import annotations

import os
import re
import signal
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from commands import SMALL, calls, foundry, records, refusal, statuses, succeeds
from foundry.composing.compose import compose
from foundry.composing.preflight import check, declare
from foundry.errors import FoundryError, InputError
from foundry.expansion import Sweep, expand
from foundry.models.answers.opening import open_answers
from foundry.running.cores import share_cores, threads_of
from foundry.running.dask import DaskRunner, Site, check_cache, check_folder, connected
from foundry.running.lane import Lane, LaneSpec
from foundry.running.lane_process import LaneProcess, WorkerDied
from foundry.running.remote import RemoteSweep
from foundry.storing.standing import failures
from foundry.storing.store import SweepFolder
from lane_works import echoing, failing, waiting
from ollama_server import OllamaServer
from policies import DOOMED, write_fate

SWEEP = ("-m", "model=scripted/random", "seed=0-1", *SMALL)
SPEC = LaneSpec("0-0", "0", SweepFolder(Path("sweep"), Sweep((), (), ()), {}, []), (), {}, cache="")


def failed_of_three(workspace: Path, policy: str, workers: int) -> SweepFolder:
    """Run a policy of one's own that cannot bear a doomed agent; seed 6 alone draws one."""
    write_fate(workspace, policy)
    asked = ("-m", "--config-dir", "mine", *DOOMED, "seed=4-6", "output.dir=out", "analyze=false")
    done = foundry(*asked, f"runner.workers={workers}", cwd=workspace)
    assert done.returncode == 3, done.stdout + done.stderr
    assert statuses(workspace / "out") == ["complete", "complete", "failed"]
    return SweepFolder.open(workspace / "out")


@pytest.mark.slow
def test_a_run_that_kills_its_worker_every_time_is_given_up_and_the_others_complete(workspace: Path):
    failed = failed_of_three(workspace, "Deadly", workers=2).runs()[-1].summary()
    assert failed and failed.error and "died 2 times while it had only this run open" in failed.error


def test_a_bug_fails_its_run_with_its_traceback_and_the_others_complete(workspace: Path):
    summaries = [run.summary() for run in failed_of_three(workspace, "Faulty", workers=1).runs()]
    failed = summaries[-1]
    assert failed and (failed.error, failed.error_type) == ("a bug", "ZeroDivisionError")
    assert failed.traceback and "policies.py" in failed.traceback
    assert {failure.error for failure in failures(summaries)} == {"ZeroDivisionError: a bug"}


def declared(*asked: str) -> Sweep:
    composed = compose(("-m", *asked))
    return declare(expand(composed.asked, composed.conditions))


def test_runs_that_were_open_when_a_worker_died_are_played_again_one_at_a_time(workspace: Path):
    opened: list[int] = []
    with OllamaServer(on_chat=lambda *call: opened.append(len(folder.progress()["0-0"]["open"]))) as server:
        sweep = declared(
            "model=qwen3:4b", "seed=0-2", "world.agents=2", "world.steps=2", f"model.server.hosts={server.url}"
        )
        folder = SweepFolder.create(workspace / "out", sweep, {}, [])
        folder.start_progress("0")
        suspects = tuple(run.id for run in folder.runs())
        spec = LaneSpec("0-0", "0", folder, (), check(sweep), cache="answers.sqlite", suspects=suspects, open_runs=3)
        assert Lane(spec).run() is None
    assert statuses(folder.path) == ["complete"] * 3 and set(opened) == {1}


def test_an_error_of_a_worker_comes_back_as_itself():
    with pytest.raises(FoundryError, match="no luck with 0-0"):
        LaneProcess(failing, SPEC).ended.result()


def test_the_death_of_a_worker_is_told():
    process = LaneProcess(waiting, SPEC)
    process.kill()
    with pytest.raises(WorkerDied, match=str(-signal.SIGKILL)):
        process.ended.result()


def test_a_result_comes_back_whatever_is_printed_or_lies_beside_it_and_no_ctrl_c_reaches_a_worker(workspace: Path):
    (workspace / "asyncio.py").write_text("raise RuntimeError('not that one')")
    assert LaneProcess(echoing, SPEC).ended.result() == "0-0, SIGINT blocked"


@pytest.mark.slow
def test_a_job_of_hydras_for_each_run_records_what_the_plain_command_does_once_and_leaves_ctrl_c_alone(tmp_path: Path):
    launched = (*SWEEP, "output.dir=launched", "hydra/launcher=basic")
    before = signal.getsignal(signal.SIGINT)
    succeeds(*SWEEP, "output.dir=plain", "runner.workers=1", cwd=tmp_path)
    succeeds(*launched, cwd=tmp_path)
    assert statuses(tmp_path / "launched") == ["complete"] * 2
    assert records(tmp_path / "launched") == records(tmp_path / "plain")
    assert calls(tmp_path / "launched") == calls(tmp_path / "plain")
    assert signal.getsignal(signal.SIGINT) == before
    ended = [(file, file.stat().st_mtime_ns) for file in sorted(tmp_path.rglob("run.json"))]
    succeeds(*launched, cwd=tmp_path)
    assert [(file, file.stat().st_mtime_ns) for file, _ in ended] == ended


def sites(**hosts: str) -> dict[str, Site]:
    return {f"tcp://{name}": Site({}, host, sees=name != "blind") for name, host in hosts.items()}


def test_a_cache_in_a_file_and_a_folder_that_a_worker_does_not_see_are_refused_on_several_machines():
    check_cache(sites(a=socket.gethostname()), "answers.sqlite")
    check_cache(sites(a="one", b="two"), "postgresql://host/db")
    with pytest.raises(InputError, match="3 machines cannot share: set cache=postgresql://"):
        check_cache(sites(a="one", b="two"), "answers.sqlite")
    check_folder(sites(a="one", b="two"), Path("sweep"))
    with pytest.raises(InputError, match=r"Worker tcp://blind does not see 'sweep'.*runner\.remote=URL"):
        check_folder(sites(a="one", blind="two"), Path("sweep"))


def test_an_address_is_given_and_a_launcher_that_is_not_installed_is_named_with_those_that_are(tmp_path: Path):
    assert "runner.address has no value" in refusal(*SWEEP, "runner=dask", cwd=tmp_path)
    assert "Launcher 'basik' not found. Did you mean 'basic'?" in refusal(*SWEEP, "hydra/launcher=basik", cwd=tmp_path)
    with pytest.raises(InputError, match="for example, tcp://head:8786"):
        DaskRunner("head:8786")


@pytest.mark.parametrize(
    ("package", "extra", "use"),
    [
        ("distributed", "dask", lambda: connected("tcp://127.0.0.1:1").__enter__()),
        ("psycopg", "postgres", lambda: open_answers("postgresql://127.0.0.1/db")),
        ("fsspec.core", "remote", lambda: RemoteSweep.open("file:///nowhere")),
    ],
)
def test_a_missing_extra_says_how_to_install_it(
    package: str, extra: str, use: Callable[[], object], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=re.escape(f"pip install 'foundry-worlds[{extra}]'")):
        use()


def test_each_worker_draws_with_its_part_of_the_cores_unless_the_environment_says_otherwise(
    monkeypatch: pytest.MonkeyPatch,
):
    cases = {(2, 1): 2, (2, 2): 0, (16, 2): 8, (16, 5): 3, (4, 3): 0, (1, 8): 0}
    assert {case: threads_of(*case) for case in cases} == cases
    monkeypatch.setenv("LP_NUM_THREADS", "7")
    share_cores(2)
    assert os.environ["LP_NUM_THREADS"] == "7"
