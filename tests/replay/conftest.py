"""Runs that are replayed: one sweep of the 2D worlds, one of a 3D world, both with the frames they saved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pxr import Gf

from commands import foundry
from foundry.paths import conf_dir
from foundry.storing.store import RunFolder, SweepFolder
from worlds.camera.usd_files import mesh, write_stage

EVERY = 3
"""Steps between the frames that the 2D runs save; the fires of the shipped world begin at 3 and 5."""


def named(group: str, wanted: str, unwanted: str = "nothing at all") -> str:
    """Return the configs of a group whose text holds a word, and not another, as the value of a sweep."""
    texts = {file.stem: file.read_text(encoding="utf-8") for file in sorted((conf_dir() / group).glob("*.yaml"))}
    return ",".join(name for name, text in texts.items() if wanted in text and unwanted not in text)


def swept(folder: Path, *overrides: str) -> list[RunFolder]:
    arguments = ("-m", *overrides, "output.dir=out", "analyze=false", "runner.workers=1")
    done = foundry(*arguments, cwd=folder, FOUNDRY_CACHE=str(folder / "answers.sqlite"))
    assert done.returncode == 0, done.stdout + done.stderr
    return SweepFolder.open(folder / "out").runs()


@pytest.fixture(scope="session")
def grid_runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """Every 2D world without further parts, with every prompt for such; agents that talk and fires that burn."""
    worlds = named("world", "grid.world.GridScenario", "@package _global_")
    prompts = named("prompt", "message: |", "window")
    overrides = (f"world={worlds}", f"prompt={prompts}", "model=scripted/echo", "world.agents=6", "world.steps=6")
    return swept(tmp_path_factory.mktemp("grid"), *overrides, f"record.frames={EVERY}")


@pytest.fixture(scope="session")
def furnished_runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """Worlds in which agents leave, die and are born."""
    overrides = ("world=evacuation,survival", "model=scripted/shortest_path,scripted/forager", "world.agents=6")
    changes = ("world.steps=9", "world.half_size=8", f"record.frames={EVERY}")
    return swept(tmp_path_factory.mktemp("furnished"), *overrides, *changes)


@pytest.fixture(scope="session")
def camera_runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """The same decisions in the same room, once with the images kept and once without."""
    folder = tmp_path_factory.mktemp("camera")
    scene = write_stage(folder / "room.usda", build_room)
    overrides = (f"scene={scene}", "task=Look", "world.steps=2", "world.keep_images=true,false", "record.frames=true")
    return swept(folder, "world=usd", "model=scripted/wander", *overrides)


def build_room(stage: Any) -> None:
    """Two walls and a floor of 4 m."""
    for name, points in {
        "Floor": ((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)),
        "North": ((-2, 2, 0), (-2, 2, 3), (2, 2, 3), (2, 2, 0)),
        "East": ((2, 2, 0), (2, 2, 3), (2, -2, 3), (2, -2, 0)),
    }.items():
        colour = Gf.Vec3f(*((0.2, 0.5, 0.7) if name == "Floor" else (0.7, 0.3, 0.2)))
        mesh(stage, f"/Room/{name}", points).CreateDisplayColorAttr([colour])
