"""Measures the cost of `foundry analyze` and `foundry report` for many runs; baseline: reading and measuring alone."""

import os
import shutil
import subprocess
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
from measuring import (
    ROOT,
    Stopwatch,
    at_most,
    cost_of_command,
    fastest,
    most_runs,
    print_table,
    print_title,
    run_sweep,
    scratch,
)

from analysis import signatures
from analysis.any.general import general_run
from analysis.load import read_records, read_run
from foundry.composing.compose import compose
from foundry.expansion import expand
from foundry.storing.run_writer import write_run_summary
from foundry.storing.store import RunFolder, SweepFolder

MODELS = ("random", "herd", "avoid", "flaky", "stay")
SIZES = (100, 1_000, 5_000)
NEW = 10
ALONE = 40
PLAYED_SEEDS = 8
POLL_S = 0.05
AT_MOST_S = 30.0
"""Target for 1,000 runs on two cores without other work."""
REPORTED, REPORTED_SEEDS, TURNS = ("random", "seek", "herd", "avoid", "echo"), 10, 3
ANALYZED_CPU_S, REPORTED_CPU_S = 4.0, 6.0


@dataclass(frozen=True)
class Used:
    """Resources that a command and its workers used.

    Attributes:
        wall_s: wall-clock time, seconds.
        cpu_s: CPU time of all processes of the command, seconds; the last part before a process ends may be missing.
        parent_mb: greatest memory use of the command itself.
        worker_mb: greatest memory use of a worker.
    """

    wall_s: float
    cpu_s: float
    parent_mb: float
    worker_mb: float


class Watch:
    """Measures a process and the processes that it started, until it ends."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._memory: dict[int, float] = {}
        self._cpu: dict[int, float] = {}

    def look(self) -> None:
        """Record the CPU time of every process so far; a process that has ended keeps its last value."""
        parents = {int(path.name): _parent(path) for path in Path("/proc").iterdir() if path.name.isdigit()}
        for pid in parents:
            if self._descends(pid, parents):
                self._note(pid)

    def _descends(self, pid: int, parents: dict[int, int]) -> bool:
        while pid and pid != self._pid:
            pid = parents.get(pid, 0)
        return pid == self._pid

    def _note(self, pid: int) -> None:
        try:
            status = Path(f"/proc/{pid}/status").read_text()
            user, system = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        except (FileNotFoundError, ProcessLookupError):
            return
        _, rest, peak = status.partition("VmHWM:")
        if rest:
            self._memory[pid] = max(self._memory.get(pid, 0.0), int(peak.split()[0]) / 1024)
            self._cpu[pid] = (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def used(self, wall_s: float) -> Used:
        """Return the measured resources."""
        workers = [mb for pid, mb in self._memory.items() if pid != self._pid]
        return Used(wall_s, sum(self._cpu.values()), self._memory[self._pid], max(workers, default=0.0))


def _parent(path: Path) -> int:
    try:
        return int((path / "stat").read_text().rpartition(")")[2].split()[1])
    except (FileNotFoundError, ProcessLookupError):
        return 0


def analyze(folder: Path) -> Used:
    """Run `foundry analyze` in a process of its own."""
    started = time.perf_counter()
    command = [sys.executable, "-m", "foundry", "analyze", str(folder)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, cwd=ROOT) as process:
        watch, over = Watch(process.pid), threading.Event()
        looking = threading.Thread(target=_look_until, args=(watch, over))
        looking.start()
        code = process.wait()
        over.set()
        looking.join()
    if code:
        raise RuntimeError(f"The analysis failed with exit code {code}.")
    return watch.used(time.perf_counter() - started)


def _look_until(watch: Watch, over: threading.Event) -> None:
    while not over.wait(POLL_S):
        watch.look()


def played(folder: Path, models: tuple[str, ...], seeds: int = PLAYED_SEEDS) -> dict[str, list[RunFolder]]:
    """Play runs of 20 agents and 50 steps, and return the runs of each model."""
    names = ",".join(f"scripted/{model}" for model in models)
    swept = run_sweep(folder, f"model={names}", f"seed=0-{seeds - 1}", "runner.workers=1")
    by_kind: dict[str, list[RunFolder]] = defaultdict(list)
    for run in swept.folder.runs():
        by_kind[run.config()["model"]["name"]].append(run)
    return by_kind


def create(folder: Path, models: tuple[str, ...], seeds: int) -> SweepFolder:
    """Create a sweep without played runs."""
    names = ",".join(f"scripted/{model}" for model in models)
    composed = compose(["-m", f"model={names}", f"seed=0-{seeds - 1}", f"output.dir={folder}"])
    assert composed is not None
    return SweepFolder.create(folder, expand(composed.asked, composed.conditions), dict(composed.settings), [])


def fill(sweep: SweepFolder, sources: dict[str, list[RunFolder]], runs: int) -> None:
    """Give a number of runs without files the files of a played run of the same model, except for the summary."""
    empty = [run for run in sweep.runs() if not run.ended][:runs]
    for number, run in enumerate(empty):
        mine = sources[run.config()["model"]["name"]]
        link(mine[number % len(mine)], run)


def link(source: RunFolder, run: RunFolder) -> None:
    """Give a run the files of another run."""
    run.path.mkdir(parents=True)
    for file in source.path.iterdir():
        if file.name != "run.json":
            os.link(file, run.path / file.name)
    summary = source.summary()
    assert summary is not None
    write_run_summary(run, msgspec.structs.replace(summary, run=run.id, seed=run.run.seed))


def alone_s(runs: Sequence[RunFolder]) -> float:
    """Return the CPU time to read and measure one run, as the mean over several runs."""

    def measure(run: RunFolder) -> None:
        records = read_records(run, run.summary())
        signatures.measure(read_run(run, records), general_run(run, records))

    measure(runs[0])  # what a process computes once
    watch = Stopwatch()
    for run in runs:
        measure(run)
    return watch.cost().cpu_s / len(runs)


def measured(folder: Path, size: int, bare_s: float, sources: dict[str, list[RunFolder]]) -> list[list[str]]:
    """Analyse a sweep of this many runs, then analyse it again, and once more after a few new runs."""
    sweep = create(folder, MODELS, (size + NEW) // len(MODELS))
    fill(sweep, sources, size)
    first, again = analyze(folder), analyze(folder)
    fill(sweep, sources, NEW)
    whats = {f"{size:,}": first, f"{size:,}, again": again, f"{size:,}, and {NEW} new ones": analyze(folder)}
    return [row(what, size, used, bare_s) for what, used in whats.items()]


def reported(folder: Path, bare_s: float) -> list[list[str]]:
    """Analyse five models over ten seeds without stored measures, and then write the report."""
    runs = sum(map(len, played(folder, REPORTED, REPORTED_SEEDS).values()))
    sweep, costs = SweepFolder.open(folder), []
    for _ in range(TURNS):
        shutil.rmtree(sweep.analysis_dir, ignore_errors=True)
        costs.append([cost_of_command(command, str(folder)) for command in ("analyze", "report")])
    rows = []
    for what, most_s, turns in zip(
        ("analysis", "report"), (ANALYZED_CPU_S, REPORTED_CPU_S), zip(*costs, strict=True), strict=True
    ):
        used_s = fastest(turns).cpu_s
        ratio = f"{used_s / (bare_s * runs):.1f}"
        rows.append([f"{what} of {runs} runs", f"{used_s:.1f} s of CPU", ratio, *at_most(used_s, most_s, "s")])
    return rows


def row(what: str, size: int, used: Used, bare_s: float) -> list[str]:
    return [
        what,
        f"{used.wall_s:.1f}",
        f"{used.cpu_s:.1f}",
        f"{1000 * used.cpu_s / size:.1f}",
        f"{used.cpu_s / (bare_s * size):.2f}",
        f"{used.parent_mb:,.0f}",
        f"{used.worker_mb:,.0f}" if used.worker_mb else "",
    ]


def main() -> None:
    most = most_runs(__doc__)
    print_title(
        "Analysis",
        "`foundry analyze` as a command, with its start, over runs of 20 agents and 50 steps of",
        f"{len(MODELS)} scripted models. CPU is the CPU time of all processes. The ratio is to the CPU time",
        f"to read and measure the same number of runs one after another, estimated from {ALONE} runs.",
    )
    with scratch() as folder:
        sources = played(folder / "played", MODELS)
        bare_s = alone_s([run for runs in sources.values() for run in runs][:ALONE])
        rows = [["reading and measuring one run", "", f"{bare_s:.3f}", f"{1000 * bare_s:.1f}", "1.00", "", ""]]
        for size in [size for size in SIZES if size <= most]:
            rows += measured(folder / str(size), size, bare_s, sources)
        judged = reported(folder / "reported", bare_s)
    print_table(["runs", "wall s", "CPU s", "CPU ms a run", "ratio", "MB, command", "MB, a worker"], rows)
    print_targets(rows)
    print_table(["one world", "measured", "ratio", "target", ""], judged)


def print_targets(rows: Sequence[Sequence[str]]) -> None:
    of_1000 = [row for row in rows if row[0] == "1,000"]
    if of_1000:
        half_s = float(of_1000[0][2].replace(",", "")) / 2
        targets = [["CPU of 1,000 runs, on two cores", f"{half_s:.1f} s", *at_most(half_s, AT_MOST_S, "s")]]
        print_table(["analysis", "measured", "target", ""], targets)


if __name__ == "__main__":
    main()
