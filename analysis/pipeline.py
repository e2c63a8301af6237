"""The whole analysis of one or several sweeps: what `foundry analyze` does."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from analysis.camera_records import CameraRecords
from analysis.comparison import Comparison, Headline, compare, headline
from analysis.grid_records import GridRecords, is_grid
from analysis.groups import group_columns, group_label
from analysis.intervals import FEWEST_FOR_CLAIMS
from analysis.lines import COMPLETE
from analysis.load import Records, has_episode
from analysis.signatures import FAILURE_RATE
from analysis.table import RunResult, SignatureTable, build_table, measure_runs
from foundry.errors import InputError
from foundry.store import SweepFolder, ensure_writable

_READABLE = "outcome.readable"
_READABLE_ENOUGH = 0.95


@dataclass(frozen=True)
class Analysis:
    """What was found, and where it was written.

    Attributes:
        path: the folder of tables and plots.
        runs: one row per run, as in `signatures.csv`.
        comparison: one row per measure and group, as in `comparison.csv`.
        compared: the comparison with its groups.
        notes: what a reader of the tables must know, one line each.
        written: the files.
    """

    path: Path
    runs: pd.DataFrame
    comparison: pd.DataFrame
    compared: Comparison
    notes: tuple[str, ...]
    written: tuple[Path, ...]

    def headline(self) -> Headline:
        """Return the short table for the terminal."""
        return headline(self.compared)


def analyze(dirs: Sequence[Path], *, plots: bool = True) -> Analysis:
    """Compute all signatures, compare the groups, draw the plots, write everything.

    The files go to the `analysis` folder of the first sweep. With several sweeps all their runs are taken
    together and the tables have a column `sweep`.

    Args:
        dirs: folders of sweeps, at least one.
        plots: whether to draw the plots, which take most of the time of a small sweep.

    Raises:
        InputError: a folder is no sweep's, or is given twice.
        RecordError: a recorded file is damaged.
    """
    paths = [Path(path) for path in dirs]
    sweeps = _open(paths)
    folder = sweeps[0].analysis_dir
    ensure_writable(folder)
    results = _measure_and_write_steps(paths, _kinds(sweeps), folder)
    table = build_table(results)
    groups = group_columns(results, table)
    compared = compare(table, groups)
    written = [folder / "steps.parquet", *_write_tables(folder, table, compared)]
    if plots:
        written += _plot(folder, compared)
    return Analysis(
        path=folder,
        runs=table.frame,
        comparison=compared.frame,
        compared=compared,
        notes=tuple([*_notes(table, compared), *_unmeasured(results)]),
        written=tuple(written),
    )


def _open(paths: Sequence[Path]) -> list[SweepFolder]:
    """Open all sweeps before the first is worked on, so that a wrong one is found at once."""
    if not paths:
        raise InputError("No sweep to analyse: give at least one sweep's folder, such as outputs/<sweep>.")
    repeated = [str(path) for path, count in Counter(path.resolve() for path in paths).items() if count > 1]
    if repeated:
        raise InputError(f"'{repeated[0]}' is given more than once: give each sweep's folder once.")
    return [SweepFolder.open(path) for path in paths]


def _kinds(sweeps: Sequence[SweepFolder]) -> set[type[Records]]:
    """Return which kinds of runs there are; the 2D one where nothing says otherwise."""
    runs = [run for sweep in sweeps for run in sweep.runs()]
    found: set[type[Records]] = {CameraRecords for run in runs if has_episode(run, None)}
    if not found or any(is_grid(run.config()) for run in runs):
        found.add(GridRecords)
    return found


def _sweep_names(paths: Sequence[Path]) -> list[str]:
    """Return the names of the folders, or the whole paths where names repeat."""
    names = [path.resolve().name for path in paths]
    return names if len(set(names)) == len(names) else [path.as_posix() for path in paths]


def _measure_and_write_steps(paths: Sequence[Path], kinds: set[type[Records]], folder: Path) -> list[RunResult]:
    from analysis.steps_file import open_steps_file

    results = []
    with open_steps_file(folder / "steps.parquet", kinds, by_sweep=len(paths) > 1) as file:
        for result in measure_runs(paths, _sweep_names(paths)):
            if result.steps is not None:
                file.add(result.sweep, result.steps)
            results.append(result.without_steps())
    return results


def _write_tables(folder: Path, table: SignatureTable, compared: Comparison) -> list[Path]:
    runs, parquet, comparison = (folder / name for name in ("signatures.csv", "signatures.parquet", "comparison.csv"))
    table.frame.to_csv(runs, index=False, lineterminator="\n")
    table.frame.to_parquet(parquet, index=False)
    compared.frame.to_csv(comparison, index=False, lineterminator="\n")
    return [runs, parquet, comparison]


def _plot(folder: Path, compared: Comparison) -> list[Path]:
    from analysis.plots import plot_signatures

    return plot_signatures(compared, folder / "plots")


def _notes(table: SignatureTable, compared: Comparison) -> list[str]:
    notes = ["mean [95 % Student-t interval] over seeds; n where only some have a value; differences: comparison.csv"]
    by_status = Counter(table.frame["status"])
    if by_status[COMPLETE] < len(table.frame):
        others = ", ".join(f"{count} {status}" for status, count in by_status.items() if status != COMPLETE)
        notes.append(f"{by_status[COMPLETE]} of {len(table.frame)} runs are complete; missing: {others}")
    if any(len(values) < FEWEST_FOR_CLAIMS for values in compared.values.values()):
        notes.append(f"fewer than {FEWEST_FOR_CLAIMS} seeds: the numbers describe these runs, and prove nothing")
    for group, values in compared.values.items():
        readable = float(values[_READABLE].mean()) if _READABLE in values else 1.0
        if readable < _READABLE_ENOUGH:
            notes.append(
                f"{group_label(group)}: only {readable:.0%} of the action replies could be read; the others count "
                "as staying, which shows in idle rate, stability, clustering and exploration"
            )
    return notes


def _unmeasured(results: Sequence[RunResult]) -> list[str]:
    complete = [result for result in results if result.keys["status"] == COMPLETE]
    worlds = dict.fromkeys(result.keys["world"] for result in complete if set(result.measures) == {FAILURE_RATE})
    return [f"world {world} is neither a 2D nor a 3D one: its runs are listed, without signatures" for world in worlds]
