"""One sweep of each form, one as the command leaves it, and one that has not begun, served together."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import made_up_camera
import made_up_rounds
import made_up_runs
from analysis.measuring.events import Event, EventsFile
from analysis.pipeline import analyze
from commands import succeeds
from foundry.records import Outcome
from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer, serving

GROUPS = """measure,model,baseline,runs,n,mean,sd,low,high,interval,note
idle_rate.share,first,False,2,2,0.5,0.1,0.25,0.75,t,
idle_rate.share,second,False,2,2,0.125,0.0,,,,no variation
idle_rate.share,random,True,2,2,0.1,0.1,0,0.2,t,
"""


OVERVIEW = {
    "matrix": {
        "caption": "Scores.",
        "columns": [
            {"title": world, "label": "Score", "measure": "idle_rate.share", "world": world}
            for world in ("made_up", "elsewhere")
        ],
        "rows": [
            {
                "name": model,
                "groups": [[model]],
                "cells": [{"text": text, "reach": reach, "end": ""} for text, reach in cells],
            }
            for model, cells in (
                ("first", (("0.5 [0.25, 0.75]", 0.8), ("0.25", 0.1))),
                ("second", (("0.125", None),) * 2),
            )
        ],
    },
    "furthest": [],
}


@dataclass(frozen=True)
class Forms:
    """Sweeps of two models each and the server of them, and of `probe`, `found` and `growing`."""

    grid: SweepFolder
    rounds: SweepFolder
    camera: SweepFolder
    server: ViewServer

    def run(self, form: str, index: int = 0) -> str:
        return f"run/{form}/{getattr(self, form).runs()[index].id}"

    def compared(self, form: str) -> str:
        runs = getattr(self, form).runs()
        return f"compare/{form}/{runs[0].id}/{runs[len(runs) // 2].id}"


@pytest.fixture(scope="session")
def forms(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forms]:
    folder = tmp_path_factory.mktemp("forms")
    grid, rounds, camera = write_grid(folder), write_rounds(folder), write_camera(folder)
    for made in (grid, rounds, camera):
        write_events(made)
    ask_probe(folder)
    play(folder)
    made_up_runs.sweep(folder / "growing")
    with serving(folder, trusted=("made_up_rounds",)) as server:
        yield Forms(grid, rounds, camera, server)


def write_grid(folder: Path) -> SweepFolder:
    """Write mishaps, another way, and a failed run; its measures are analysed."""
    made = made_up_runs.whole_sweep(folder / "grid")
    failed = made_up_runs.Playing(made.runs()[3])
    failed.play(1, 2)
    failed.end("the server is gone")
    made.analysis_dir.mkdir()
    values = [f"{run.id},{value}" for run, value in zip(made.runs(), ("0.25", "0.5", "0.125", ""), strict=True)]
    tables = {"comparison": GROUPS, "contrasts": "measure,headline\nidle_rate.share,True\n"}
    made.signatures_path.write_text("\n".join(["run,idle_rate.share", *values, ""]), encoding="utf-8")
    for name, text in tables.items():
        (made.analysis_dir / f"{name}.csv").write_text(text, encoding="utf-8")
    (made.analysis_dir / "action.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>', encoding="utf-8")
    (made.analysis_dir / "overview.json").write_text(json.dumps(OVERVIEW), encoding="utf-8")
    return made


def write_rounds(folder: Path) -> SweepFolder:
    made = made_up_rounds.sweep(folder / "rounds")
    first, second = made.runs()
    made_up_rounds.whole_run(first)
    made_up_rounds.whole_run(second, made_up_rounds.otherwise)
    return made


def write_camera(folder: Path) -> SweepFolder:
    """Write two ways that part at step 2, where the first reply had to be repaired."""
    made = made_up_camera.sweep(folder / "camera")
    first, second = made.runs()
    made_up_camera.whole(first, outcome=Outcome.REPAIRED)
    turned = {"translate": None, "turn": 30.0, "gaze": None, "stay": False}
    made_up_camera.whole(second, command=turned, reply="I turn.")
    return made


def write_events(made: SweepFolder) -> None:
    """Write an event of each run, as an analysis would."""
    made.analysis_dir.mkdir(exist_ok=True)
    if not made.signatures_path.exists():
        made.signatures_path.write_text("\n".join(["run", *(run.id for run in made.runs())]), encoding="utf-8")
    events = EventsFile()
    for run in made.runs():
        arrived, fled = Event(2, 0, "arrived", "agent 0 arrives <b>somewhere</b>"), Event(5, 2, "fled", "agent 2 flees")
        events.add(made.path.name, run.id, [arrived, fled] if made.path.name == "grid" else [arrived])
    events.write(made.analysis_dir)


def play(folder: Path) -> None:
    """Play and analyse a sweep, `found`, as the command does."""
    models, world = "model=scripted/avoid,scripted/herd", ("world.agents=8", "world.steps=12")
    succeeds("-m", models, "seed=0-1", *world, "analyze=false", "output.dir=found", cwd=folder)
    analyze([folder / "found"], plots=False)


def ask_probe(folder: Path) -> None:
    """Ask two policies in a few moments, with and without the fire."""
    models, recorded = "model=scripted/herd,scripted/avoid", folder.parent / "recorded"
    world = (
        "world.agents=4",
        "world.steps=4",
        "world.fires=[{name: great, start: 2, position: [0, 0], intensity: 1.0, radius: 99}]",
    )
    for arguments in (
        ("-m", models, "seed=0", *world, "analyze=false", f"output.dir={recorded}"),
        (
            "probe",
            str(recorded),
            "-m",
            models,
            "moments=6",
            "repeats=2",
            "edit=no_fire",
            f"output.dir={folder / 'probe'}",
        ),
    ):
        succeeds(*arguments, cwd=folder.parent)
