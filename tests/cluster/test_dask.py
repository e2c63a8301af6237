"""The same sweep on a Dask cluster and by Hydra's launchers: real processes, a real database, workers killed."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import SMALL, calls, foundry, is_dead, records, refusal, started, statuses, succeeds, wait_until
from dask_servers import Cluster, dask_cluster
from databases import PostgresStore
from foundry import paths
from holding import SWEEP, HeldSweep, assert_nothing_lost_or_paid_twice, held_sweep, working
from ollama_server import OllamaServer
from policies import DOOMED, write_fate
from ports import reserved_port
from postgres_server import PostgresServer

pytestmark = pytest.mark.cluster
LAUNCHED = ("-m", "model=scripted/random,scripted/herd", "seed=0", *SMALL)
FREE = ("-m", "model=scripted/random", "seed=0-5", *SMALL)
IMPATIENT = ("model.server.retry.wait_initial_s=0.05", "runner.open_runs=1")
LAUNCHERS = {
    "hydra_submitit_launcher": ("hydra/launcher=submitit_local", "hydra.launcher.submitit_folder=jobs"),
    "hydra_joblib_launcher": ("hydra/launcher=joblib", "hydra.launcher.n_jobs=2"),
}


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[Cluster]:
    """A cluster of a test's own, without workers."""
    pytest.importorskip("distributed", reason="needs the extra dask: pip install 'foundry-worlds[dask]'")
    folder = tmp_path / "cluster"
    folder.mkdir()
    with dask_cluster(folder) as running:
        yield running


@pytest.fixture
def mortal(scheduler: Cluster) -> Cluster:
    """A cluster of a test's own with three workers, two of which stay dead when they are killed."""
    scheduler.add(2)
    scheduler.add(1, nanny=True)
    return scheduler


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A cluster with three workers, one of them with a nanny, that nobody kills."""
    pytest.importorskip("distributed", reason="needs the extra dask: pip install 'foundry-worlds[dask]'")
    with dask_cluster(tmp_path_factory.mktemp("cluster")) as running:
        running.add(2)
        running.add(1, nanny=True)
        yield running


@pytest.fixture
def cache(postgres: PostgresServer) -> str:
    """The override that names an empty database."""
    return f"cache={postgres.database()}"


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    workspace = tmp_path_factory.mktemp("undisturbed")
    with OllamaServer() as server:
        done = foundry(*SWEEP, "output.dir=sweep", "runner.workers=1", cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stdout + done.stderr
    return workspace / "sweep"


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
        succeeds(*SWEEP, *on(cluster, *more), cache, "output.dir=sweep", cwd=tmp_path, OLLAMA_HOST=server.url)
        assert_nothing_lost_or_paid_twice(server, tmp_path / "sweep", undisturbed)
    if place == "remote":
        succeeds("status", more[0].partition("=")[2], "--fetch", "fetched", cwd=tmp_path)
        assert records(tmp_path / "fetched") == records(undisturbed)
        assert calls(tmp_path / "fetched") == calls(undisturbed)


@contextlib.contextmanager
def held_on(cluster: Cluster, cache: str, cwd: Path, *more: str) -> Iterator[HeldSweep]:
    """Start the sweep on a cluster; yield when its first 40 answers are in the database and all other calls held."""
    with held_sweep(40, *SWEEP, *on(cluster, *more, *IMPATIENT), cache, "output.dir=sweep", cwd=cwd) as sweep:
        store = PostgresStore(cache.partition("=")[2])
        wait_until(lambda: store.rows() == 40, "every answer given is in the cache", sweep.process)
        yield sweep


def test_a_worker_that_is_killed_in_the_middle_loses_nothing(
    mortal: Cluster, cache: str, undisturbed: Path, tmp_path: Path
):
    plain = {worker.pid for worker in mortal.workers[:2]}

    def at_work() -> list[int]:
        return [report["pid"] for report in working(tmp_path / "sweep") if parent_of(report["pid"]) in plain]

    with held_on(mortal, cache, tmp_path) as sweep:
        wait_until(lambda: bool(at_work()), "a worker without a nanny has a run open")
        lane = at_work()[0]
        mortal.kill(parent_of(lane))
        wait_until(lambda: is_dead(lane), "its child goes with it")
        output = sweep.finish()
        assert sweep.process.returncode == 0, output
        assert_nothing_lost_or_paid_twice(sweep.server, tmp_path / "sweep", undisturbed)


def test_a_worker_that_is_killed_without_a_shared_folder_loses_nothing(
    mortal: Cluster, cache: str, undisturbed: Path, tmp_path: Path
):
    with held_on(mortal, cache, tmp_path, f"runner.remote={(tmp_path / 'bucket').as_uri()}") as sweep:
        os.killpg(mortal.workers[0].pid, signal.SIGKILL)
        mortal.workers[0].wait()
        output = sweep.finish()
        assert sweep.process.returncode == 0, output
        assert_nothing_lost_or_paid_twice(sweep.server, tmp_path / "sweep", undisturbed)


def test_a_stopped_sweep_goes_on_where_it_was(cluster: Cluster, cache: str, undisturbed: Path, tmp_path: Path):
    with held_on(cluster, cache, tmp_path) as sweep:
        wait_until(lambda: len(working(tmp_path / "sweep")) == 3, "every worker has a run", sweep.process)
        os.killpg(sweep.process.pid, signal.SIGINT)
        wait_until(lambda: all(one["stopping"] for one in working(tmp_path / "sweep")), "they stop", sweep.process)
        output = sweep.finish()
        assert sweep.process.returncode == 130, output
        assert None in statuses(tmp_path / "sweep")
        succeeds("resume", "sweep", cwd=tmp_path)
        assert_nothing_lost_or_paid_twice(sweep.server, tmp_path / "sweep", undisturbed)


def test_a_run_that_kills_its_process_is_given_up_and_no_worker_of_the_cluster_dies(cluster: Cluster, tmp_path: Path):
    write_fate(tmp_path, "Deadly")
    asked = ("-m", "--config-dir", "mine", *DOOMED, "seed=0-7", "output.dir=out", "analyze=false")
    done = foundry(*asked, *on(cluster), cwd=tmp_path)
    assert done.returncode == 3, done.stdout + done.stderr
    ended = statuses(tmp_path / "out")
    assert ended.count("failed") > 0 and ended.count("failed") + ended.count("complete") == 8
    assert [worker.poll() for worker in cluster.workers] == [None, None, None]


def test_workers_with_another_version_or_none_are_refused_in_one_line(scheduler: Cluster, tmp_path: Path):
    def refused_on(place: Path) -> str:
        scheduler.add(1, path=[place])
        return refusal(*FREE, *on(scheduler), "output.dir=sweep", cwd=tmp_path)

    shutil.copytree(paths.PACKAGE, tmp_path / "other" / "foundry", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "other" / "foundry" / "version.py").write_text('"""Another one."""\n\n__version__ = "0.0.9"\n')
    assert "has foundry 0.0.9, this process has" in refused_on(tmp_path / "other")
    assert set(statuses(tmp_path / "sweep")) == {None}
    scheduler.kill(scheduler.workers[0].pid)
    (tmp_path / "no" / "foundry").mkdir(parents=True)
    (tmp_path / "no" / "foundry" / "__init__.py").write_text('"""Something else of this name."""\n')
    assert "cannot run this foundry" in refused_on(tmp_path / "no")


def test_an_address_where_no_scheduler_answers_is_told_in_one_line(tmp_path: Path):
    pytest.importorskip("distributed", reason="needs the extra dask: pip install 'foundry-worlds[dask]'")
    with reserved_port() as port:
        address = f"tcp://127.0.0.1:{port}"
        line = refusal(*FREE, "runner=dask", f"runner.address={address}", "output.dir=sweep", cwd=tmp_path)
    assert f"No Dask scheduler answers at runner.address={address}" in line


def test_a_scheduler_that_dies_ends_the_sweep_with_a_clear_line(scheduler: Cluster, cache: str, tmp_path: Path):
    scheduler.add(1)
    asked = (*SWEEP, *on(scheduler, *IMPATIENT), cache, "output.dir=sweep")
    with held_sweep(10, *asked, cwd=tmp_path) as sweep:
        scheduler.close()
        output, _ = sweep.process.communicate()
    assert sweep.process.returncode == 3, output
    assert "lost its workers" in output and "Traceback" not in output


@pytest.mark.parametrize("nanny", [False, True])
@pytest.mark.parametrize("place", ["shared", "remote"])
def test_workers_end_when_their_scheduler_and_the_command_are_gone(
    place: str, nanny: bool, scheduler: Cluster, tmp_path: Path
):
    scheduler.add(1, nanny=nanny)
    more = () if place == "shared" else (f"runner.remote={(tmp_path / 'bucket').as_uri()}",)
    asked = (*SWEEP, *on(scheduler, *IMPATIENT, *more), "output.dir=sweep")
    with held_sweep(2, *asked, cwd=tmp_path) as sweep:
        lanes = lanes_below(scheduler.workers[0].pid)
        assert lanes
        os.killpg(sweep.process.pid, signal.SIGKILL)
        scheduler.kill_scheduler()
        wait_until(lambda: all(map(is_dead, lanes)), "the workers end")


def lanes_below(pid: int) -> list[int]:
    """Return the processes that play runs among the children of a process and theirs."""
    children = [
        int(one) for task in Path(f"/proc/{pid}/task").iterdir() for one in (task / "children").read_text().split()
    ]
    mine = [one for one in children if b"foundry.running.lane_process" in Path(f"/proc/{one}/cmdline").read_bytes()]
    return [*mine, *(lane for one in children for lane in lanes_below(one))]


@pytest.mark.parametrize("plugin", LAUNCHERS)
def test_a_launcher_of_hydra_runs_the_same_sweep(plugin: str, tmp_path: Path):
    pytest.importorskip(f"hydra_plugins.{plugin}", reason=f"pip install {plugin.replace('_', '-')}")
    succeeds(*LAUNCHED, "output.dir=plain", cwd=tmp_path)
    with started(*LAUNCHED, "output.dir=launched", *LAUNCHERS[plugin], cwd=tmp_path) as process:
        output, _ = process.communicate()
    assert process.returncode == 0, output
    assert statuses(tmp_path / "launched") == ["complete"] * 2
    assert records(tmp_path / "launched") == records(tmp_path / "plain")
    assert calls(tmp_path / "launched") == calls(tmp_path / "plain")
