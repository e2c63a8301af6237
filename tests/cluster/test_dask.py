"""The same sweep on a Dask cluster: real processes, a real database, workers killed for real."""

from __future__ import annotations

import os
import shutil
import signal
from pathlib import Path

import pytest

from commands import SMALL, calls, foundry, is_dead, records, started, statuses, wait_until
from dask_servers import Cluster
from databases import PostgresStore
from foundry import paths
from holding import SWEEP, Holding, assert_nothing_lost_or_paid_twice, working
from ollama_server import OllamaServer
from ports import reserved_port

pytestmark = pytest.mark.cluster
FREE = ("-m", "model=scripted/random", "seed=0-5", *SMALL)
IMPATIENT = ("model.server.retry.wait_initial_s=0.05", "runner.open_runs=1")


def on(cluster: Cluster, *more: str) -> tuple[str, ...]:
    return ("runner=dask", f"runner.address={cluster.address}", *more)


def parent_of(pid: int) -> int:
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


@pytest.mark.parametrize("place", ["shared", "remote"])
def test_a_sweep_on_a_cluster_has_the_records_of_the_local_one(
    place: str, cluster: Cluster, cache: str, undisturbed: Path, tmp_path: Path
):
    more = () if place == "shared" else (f"runner.remote={(tmp_path / 'bucket' / 'one').as_uri()}",)
    with OllamaServer() as server:
        done = foundry(*SWEEP, *on(cluster, *more), cache, "output.dir=sweep", cwd=tmp_path, OLLAMA_HOST=server.url)
        assert done.returncode == 0, done.stdout + done.stderr
        assert_nothing_lost_or_paid_twice(server, tmp_path / "sweep", undisturbed)
    if place == "remote":
        assert foundry("status", more[0].partition("=")[2], "--fetch", "fetched", cwd=tmp_path).returncode == 0
        assert records(tmp_path / "fetched") == records(undisturbed)
        assert calls(tmp_path / "fetched") == calls(undisturbed)


def test_a_worker_that_is_killed_in_the_middle_loses_nothing(
    mortal: Cluster, cache: str, undisturbed: Path, tmp_path: Path
):
    holding = Holding(40)
    arguments = (*SWEEP, *on(mortal, *IMPATIENT), cache, "output.dir=sweep")
    with OllamaServer(holding) as server:
        with started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
            wait_until(lambda: holding.held, "the calls are held back", process)
            wait_until(
                lambda: PostgresStore(cache.partition("=")[2]).rows() == 40, "every answer given is in the cache"
            )
            plain = {worker.pid for worker in mortal.workers[:2]}

            def at_work() -> list[int]:
                return [one["pid"] for one in working(tmp_path / "sweep") if parent_of(one["pid"]) in plain]

            wait_until(lambda: bool(at_work()), "a worker without a nanny has a run open")
            lane = at_work()[0]
            mortal.kill(parent_of(lane))
            wait_until(lambda: is_dead(lane), "its child goes with it")
            holding.free()
            server.drop_hanging()
            output, _ = process.communicate()
        assert process.returncode == 0, output
        assert_nothing_lost_or_paid_twice(server, tmp_path / "sweep", undisturbed)


def test_a_worker_that_is_killed_without_a_shared_folder_loses_nothing(
    mortal: Cluster, cache: str, undisturbed: Path, tmp_path: Path
):
    holding = Holding(40)
    remote = f"runner.remote={(tmp_path / 'bucket').as_uri()}"
    arguments = (*SWEEP, *on(mortal, remote, *IMPATIENT), cache, "output.dir=sweep")
    with OllamaServer(holding) as server:
        with started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
            wait_until(lambda: holding.held, "the calls are held back", process)
            wait_until(
                lambda: PostgresStore(cache.partition("=")[2]).rows() == 40, "every answer given is in the cache"
            )
            os.killpg(mortal.workers[0].pid, signal.SIGKILL)
            mortal.workers[0].wait()
            holding.free()
            server.drop_hanging()
            output, _ = process.communicate()
        assert process.returncode == 0, output
        assert_nothing_lost_or_paid_twice(server, tmp_path / "sweep", undisturbed)


def test_a_stopped_sweep_goes_on_where_it_was(cluster: Cluster, cache: str, undisturbed: Path, tmp_path: Path):
    holding = Holding(40)
    arguments = (*SWEEP, *on(cluster, *IMPATIENT), cache, "output.dir=sweep")
    with OllamaServer(holding) as server:
        with started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
            wait_until(lambda: holding.held, "the calls are held back", process)
            wait_until(lambda: len(working(tmp_path / "sweep")) == 3, "every worker has a run", process)
            os.killpg(process.pid, signal.SIGINT)
            wait_until(lambda: all(one["stopping"] for one in working(tmp_path / "sweep")), "they stop", process)
            holding.free()
            server.drop_hanging()
            output, _ = process.communicate()
        assert process.returncode == 130, output
        assert None in statuses(tmp_path / "sweep")
        done = foundry("resume", "sweep", cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        assert_nothing_lost_or_paid_twice(server, tmp_path / "sweep", undisturbed)


def test_a_run_that_kills_its_process_is_given_up_and_no_worker_of_the_cluster_dies(cluster: Cluster, tmp_path: Path):
    for group in ("model", "prompt", "world"):
        (tmp_path / "mine" / group).mkdir(parents=True)
    mine = tmp_path / "mine"
    (mine / "model" / "deadly.yaml").write_text("_target_: policies.Deadly\nname: deadly\n")
    (mine / "world" / "fate.yaml").write_text("defaults: [cafe_library, _self_]\nname: fate\nagents: 1\nsteps: 2\n")
    (mine / "prompt" / "terse.yaml").write_text(
        "_target_: foundry.prompts.prompt.Prompt\nname: terse\ntemplates: {message: 'Say?', action: 'Act?'}\n"
    )
    done = foundry(
        "-m", "--config-dir", "mine", "model=deadly", "world=fate", "prompt=terse", "seed=0-7", "output.dir=out",
        "++world.personas={fate: {doomed: 1, blessed: 3}}", "analyze=false", *on(cluster), cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 3, done.stdout + done.stderr
    ended = statuses(tmp_path / "out")
    assert ended.count("failed") > 0 and ended.count("failed") + ended.count("complete") == 8
    assert [worker.poll() for worker in cluster.workers] == [None, None, None]


def test_workers_with_another_version_or_none_are_refused_in_one_line(scheduler: Cluster, tmp_path: Path):
    other = tmp_path / "other"
    shutil.copytree(paths.PACKAGE, other / "foundry", ignore=shutil.ignore_patterns("__pycache__"))
    (other / "foundry" / "__init__.py").write_text('"""Another one."""\n\n__version__ = "0.0.9"\n')
    scheduler.add(1, path=[other])
    done = foundry(*FREE, *on(scheduler), "output.dir=sweep", cwd=tmp_path)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "has foundry 0.0.9, this process has" in done.stderr
    assert done.stderr.count("\n") == 1
    assert set(statuses(tmp_path / "sweep")) == {None}
    scheduler.kill(scheduler.workers[0].pid)
    (tmp_path / "no" / "foundry").mkdir(parents=True)
    (tmp_path / "no" / "foundry" / "__init__.py").write_text('"""Something else of this name."""\n')
    scheduler.add(1, path=[tmp_path / "no"])
    done = foundry(*FREE, *on(scheduler), "output.dir=sweep", cwd=tmp_path)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "cannot run this foundry" in done.stderr
    assert done.stderr.count("\n") == 1


def test_an_address_where_no_scheduler_answers_is_told_in_one_line(tmp_path: Path):
    pytest.importorskip("distributed", reason="needs the extra dask: pip install 'foundry-worlds[dask]'")
    with reserved_port() as port:
        address = f"tcp://127.0.0.1:{port}"
        done = foundry(*FREE, "runner=dask", f"runner.address={address}", "output.dir=sweep", cwd=tmp_path)
    assert done.returncode == 2, done.stdout + done.stderr
    assert f"No Dask scheduler answers at runner.address={address}" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_scheduler_that_dies_ends_the_sweep_with_a_clear_line(scheduler: Cluster, cache: str, tmp_path: Path):
    scheduler.add(1)
    holding = Holding(10)
    arguments = (*SWEEP, *on(scheduler, *IMPATIENT), cache, "output.dir=sweep")
    with OllamaServer(holding) as server:
        with started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
            wait_until(lambda: holding.held, "the calls are held back", process)
            scheduler.close()
            output, _ = process.communicate()
        assert process.returncode == 3, output
        assert "lost its workers" in output and "Traceback" not in output


@pytest.mark.parametrize("nanny", [False, True])
@pytest.mark.parametrize("place", ["shared", "remote"])
def test_workers_end_when_their_scheduler_and_the_command_are_gone(
    place: str, nanny: bool, scheduler: Cluster, tmp_path: Path
):
    scheduler.add(1, nanny=nanny)
    holding = Holding(2)
    more = () if place == "shared" else (f"runner.remote={(tmp_path / 'bucket').as_uri()}",)
    arguments = (*SWEEP, *on(scheduler, *IMPATIENT, *more), "output.dir=sweep")
    with OllamaServer(holding) as server, started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
        wait_until(lambda: holding.held, "the calls are held back", process)
        lanes = lanes_below(scheduler.workers[0].pid)
        assert lanes
        os.killpg(process.pid, signal.SIGKILL)
        scheduler.kill_scheduler()
        wait_until(lambda: all(map(is_dead, lanes)), "the workers end")


def lanes_below(pid: int) -> list[int]:
    """Return the processes that play runs among the children of a process and theirs."""
    children = [
        int(one) for task in Path(f"/proc/{pid}/task").iterdir() for one in (task / "children").read_text().split()
    ]
    mine = [one for one in children if b"foundry.running.lane_process" in Path(f"/proc/{one}/cmdline").read_bytes()]
    return [*mine, *(lane for one in children for lane in lanes_below(one))]
