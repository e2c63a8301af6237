"""Makes large sweeps out of a few runs that were played: their files are linked, so that they take no disk."""

from __future__ import annotations

import os
from collections import defaultdict
from pathlib import Path

import msgspec
from measuring import run_sweep

from foundry.composing.compose import compose
from foundry.expansion import expand
from foundry.storing.run_writer import write_run_summary
from foundry.storing.store import RunFolder, SweepFolder

PLAYED_SEEDS = 8


def played(folder: Path, models: tuple[str, ...]) -> dict[str, list[RunFolder]]:
    """Play runs of 20 agents and 50 steps; return them by model."""
    names = ",".join(f"scripted/{model}" for model in models)
    swept = run_sweep(folder, f"model={names}", f"seed=0-{PLAYED_SEEDS - 1}", "runner.workers=1")
    found: dict[str, list[RunFolder]] = defaultdict(list)
    for run in swept.folder.runs():
        found[run.config()["model"]["name"]].append(run)
    return found


def create(folder: Path, models: tuple[str, ...], seeds: int) -> SweepFolder:
    """Create a sweep that has not begun."""
    names = ",".join(f"scripted/{model}" for model in models)
    composed = compose(["-m", f"model={names}", f"seed=0-{seeds - 1}", f"output.dir={folder}"])
    assert composed is not None
    return SweepFolder.create(folder, expand(composed.asked, composed.conditions), dict(composed.settings), [])


def fill(sweep: SweepFolder, sources: dict[str, list[RunFolder]], runs: int) -> None:
    """Give that many runs that have none the files of a played one of the same model, summary aside."""
    empty = [run for run in sweep.runs() if not run.ended][:runs]
    for number, run in enumerate(empty):
        mine = sources[run.config()["model"]["name"]]
        link(mine[number % len(mine)], run)


def link(source: RunFolder, run: RunFolder) -> None:
    """Give a run the files of another one."""
    run.path.mkdir(parents=True)
    for file in source.path.iterdir():
        if file.name != "run.json":
            os.link(file, run.path / file.name)
    summary = source.summary()
    assert summary is not None
    write_run_summary(run, msgspec.structs.replace(summary, run=run.id, seed=run.run.seed))
