"""Runs that are replayed: one sweep of a 2D world, one of a 3D world, both with the frames they saved."""

import shutil
from pathlib import Path

import pytest

from commands import succeeds
from episodes import ROOM
from foundry.storing.store import RunFolder, SweepFolder

EVERY = 3
"""Steps between the frames that the 2D runs save; the fires of the shipped world begin at 3 and 5."""


def swept(folder: Path, *overrides: str) -> list[RunFolder]:
    arguments = ("-m", *overrides, "output.dir=out", "analyze=false", "runner.workers=1")
    succeeds(*arguments, cwd=folder, FOUNDRY_CACHE=str(folder / "answers.sqlite"))
    return SweepFolder.open(folder / "out").runs()


@pytest.fixture(scope="session")
def grid_runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """The same run with two prompts; agents that talk and fires that burn."""
    prompts = "prompt=paper,japanese"
    overrides = ("world=cafe_library", prompts, "model=scripted/echo", "world.agents=6", "world.steps=6")
    return swept(tmp_path_factory.mktemp("grid"), *overrides, f"record.frames={EVERY}")


@pytest.fixture(scope="session")
def camera_runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """The same decisions in the same room, once with the images kept and once without."""
    folder = tmp_path_factory.mktemp("camera")
    room = shutil.copy(ROOM, folder)
    overrides = (f"scene={room}", "task=Look", "world.steps=2", "world.keep_images=true,false", "record.frames=true")
    return swept(folder, "world=usd", "model=scripted/wander", *overrides)
