"""Calls per second on a Dask cluster as its workers grow, and the sizes and times that a large sweep is planned with.

Starts a scheduler, workers and a PostgreSQL server on this machine; needs the extras dask and postgres.
"""

from __future__ import annotations

import contextlib
import importlib.util
import pickle
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from measuring import ROOT, Swept, cost_of, fastest, print_table, print_title, run_sweep, scratch, server

from foundry.composing.compose import compose
from foundry.expansion import expand
from foundry.models.answers.opening import open_answers
from foundry.models.base import Reply
from foundry.storing.store import SweepFolder

if TYPE_CHECKING:
    from dask_servers import Cluster
    from postgres_server import PostgresServer

sys.path.extend(str(ROOT / "tests" / room) for room in ("parts", "runs", "servers"))

WORKERS = (1, 2, 4)
LATENCY_S, IN_FLIGHT = 0.1, 4
AGENTS, STEPS, RUNS_PER_WORKER = 20, 10, 4
ROWS, REPEATS = 20, 50
DEFINED = (1_000, 100_000)
MILLION = 1_000_000


@dataclass(frozen=True)
class Ground:
    """What runs beside the benchmark."""

    cluster: Cluster
    postgres: PostgresServer
    url: str


@contextlib.contextmanager
def ground(folder: Path) -> Iterator[Ground]:
    from dask_servers import dask_cluster
    from postgres_server import postgres_server, programs

    installed = programs()
    if installed is None:
        raise RuntimeError("PostgreSQL is not installed.")
    place = folder / "cluster"
    place.mkdir()
    with dask_cluster(place) as cluster, postgres_server(installed) as postgres, server(LATENCY_S) as models:
        cluster.add(max(WORKERS))
        yield Ground(cluster, postgres, models.url)


def sweep(around: Ground, folder: Path, cache: str, workers: int, *more: str) -> Swept:
    """Run so many runs that every worker has a few."""
    limit = IN_FLIGHT * workers
    return run_sweep(
        folder,
        "runner=dask",
        f"runner.address={around.cluster.address}",
        f"runner.workers={workers}",
        "runner.open_runs=1",
        f"model.server.hosts='{around.url}'",
        f"model.server.in_flight={{min: {limit}, max: {limit}, initial: {limit}}}",
        f"world.agents={AGENTS}",
        f"world.steps={STEPS}",
        f"seed=0-{RUNS_PER_WORKER * workers - 1}",
        *more,
        cache=cache,
    )


def throughput(around: Ground, folder: Path) -> None:
    """Print calls per second by workers, and what the last sweep left behind."""
    rows, first = [], 0.0
    for workers in WORKERS:
        cache = around.postgres.database()
        asked = sweep(around, folder / f"asked-{workers}", cache, workers)
        per_s = asked.per_s_once_begun(workers)
        first = first or per_s
        rows.append([workers, asked.calls, f"{per_s:.1f}", f"{per_s / first:.2f}"])
    print_table(["workers", "calls", "calls/s", "times one worker's"], rows)
    sizes(asked, cache)


def sizes(swept: Swept, cache: str) -> None:
    """Print bytes per call, per run and per record."""
    runs, calls = swept.folder.runs(), swept.calls
    files = [file for run in runs for file in run.files()]
    steps = b"".join(run.steps_bytes() for run in runs)
    log = sum(run.stream_path("calls").stat().st_size for run in runs)
    whole = sum(file.stat().st_size for file in files)
    rows = [
        ["a row of the answer cache in PostgreSQL, index included", f"{table_bytes(cache) / calls:,.0f}", "call"],
        ["calls.jsonl.zst", f"{log / calls:,.0f}", "call"],
        ["steps.jsonl", f"{len(steps) / steps.count(10):,.0f}", "record"],
        [f"a run's folder ({calls // len(runs)} calls)", f"{whole / len(runs):,.0f}", "run"],
        ["files of a run", f"{len(files) / len(runs):.1f}", "run (number)"],
    ]
    print_table(["size", "bytes", "per"], rows)


def table_bytes(cache: str) -> int:
    import psycopg

    with psycopg.connect(cache) as database:
        database.execute("ANALYZE answers")
        found = database.execute("SELECT pg_total_relation_size('answers')").fetchone()
        return int(found[0]) if found else 0


def database_times(cache: str) -> None:
    """Print what one exchange with the database costs."""
    answers = open_answers(cache)
    batches = [{f"{number}-{row}": Reply(text="x" * 200) for row in range(ROWS)} for number in range(REPEATS)]
    put = fastest([cost_of(lambda batch=batch: answers.put(batch, "m")) for batch in batches]).wall_s
    get = fastest([cost_of(lambda batch=batch: answers.get(list(batch))) for batch in batches]).wall_s
    answers.close()
    times = [["commit", f"{1e3 * put:.2f}"], ["look up", f"{1e3 * get:.2f}"]]
    print_table([f"PostgreSQL on this machine, {ROWS} answers at once", "ms"], times)


def definitions(folder: Path) -> None:
    """Print what a sweep's definition costs, whose runs are not played."""
    rows = []
    for runs in DEFINED:
        composed = compose(["-m", "model=scripted/random", f"seed=0-{runs - 1}"])
        assert composed is not None
        started = time.perf_counter()
        made = expand(composed.asked, composed.conditions)
        opened = SweepFolder.create(folder / f"defined-{runs}", made, {}, [])
        written_s = time.perf_counter() - started
        size = sum(file.stat().st_size for file in opened.path.iterdir())
        read = cost_of(lambda path=opened.path: SweepFolder.open(path)).wall_s
        walk = cost_of(lambda one=opened: [run.ended for run in one.runs()]).wall_s
        sent = len(pickle.dumps(opened))
        per = MILLION / runs
        cells = [written_s * per, read * per, walk * per, size * per / 1e6, sent * per / 1e6]
        rows.append([f"{runs:,}", *(f"{cell:,.0f}" for cell in cells)])
    columns = ["runs defined", "expand and write s", "read s", "look which have ended s", "sweep.yaml MB", "sent MB"]
    print_table([columns[0], *(f"{name} per million" for name in columns[1:])], rows)


def missing() -> Sequence[str]:
    return [name for name in ("distributed", "psycopg") if importlib.util.find_spec(name) is None]


def main() -> None:
    print_title(
        "A cluster",
        f"Dask workers on this machine, at most {IN_FLIGHT} calls each in flight to a stand-in server that takes",
        f"{1e3 * LATENCY_S:.0f} ms a call; {AGENTS} agents, {STEPS} steps, {RUNS_PER_WORKER} runs per worker.",
    )
    if missing():
        print(f"Left out: {', '.join(missing())} not installed: pip install 'foundry-worlds[dask,postgres]'\n")
        return
    with scratch() as folder, ground(folder) as around:
        throughput(around, folder)
        database_times(around.postgres.database())
        definitions(folder)


if __name__ == "__main__":
    main()
