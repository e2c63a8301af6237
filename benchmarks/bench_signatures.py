"""CPU time of one run's analysis: reading the lines, all signatures over all and over the readable decisions."""

from __future__ import annotations

from collections.abc import Callable

from measuring import Stopwatch, at_most, print_table, print_title, run_sweep, scratch

from analysis import signatures
from analysis.any.any_run import AnyRun
from analysis.any.general import general_run
from analysis.grid.grid_run import GridRun
from analysis.load import read_records, read_run
from foundry.storing.store import RunFolder

MODELS = ("random", "herd", "avoid", "flaky")
REPEATS = 20
TARGET_MS = 40.0


def milliseconds(what: Callable[[], object]) -> float:
    """Return the CPU time of one call, after a first one that fills what is kept for a whole process."""
    what()
    watch = Stopwatch()
    for _ in range(REPEATS):
        what()
    return 1000 * watch.cost().cpu_s / REPEATS


def row(folder: RunFolder) -> list[str]:
    def read() -> tuple[GridRun, AnyRun]:
        records = read_records(folder, folder.summary())
        return read_run(folder, records), general_run(folder, records)

    reading = milliseconds(read)
    whole = milliseconds(lambda: signatures.measure(*read()))
    readable = f"{read()[0].readable.mean():.2f}"
    return [folder.id.rpartition("-s")[0], readable, f"{reading:.1f}", f"{whole:.1f}", *at_most(whole, TARGET_MS, "ms")]


def first(folder: RunFolder) -> float:
    """Return the seconds of the first run of a process, which computes what later ones share."""
    watch = Stopwatch()
    records = read_records(folder, folder.summary())
    signatures.measure(read_run(folder, records), general_run(folder, records))
    return watch.cost().cpu_s


def main() -> None:
    print_title("Analysis of one run of 20 agents and 50 steps")
    with scratch() as folder:
        names = ",".join(f"scripted/{model}" for model in MODELS)
        runs = run_sweep(folder / "runs", f"model={names}", "seed=0", "runner.workers=1").folder.runs()
        once = first(runs[0])
        print_table(["model", "readable", "reading, ms", "and measuring, ms", "target", ""], [row(run) for run in runs])
    print(f"\nThe first run of a process: {once:.2f} s.")


if __name__ == "__main__":
    main()
