"""Recorded sweeps that the tests verify, continue and hand on; the server that answered them is gone."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from commands import succeeds
from foundry.storing.store import RunFolder, SweepFolder, to_yaml
from ollama_server import OllamaServer
from worlds.camera.usd_files import bind, mesh, picture, texture_coordinates, textured, write_stage

MIX = "mix/qwen3:4b@50%+scripted/herd@50%"
SMALL = ("world.agents=4", "world.steps=4", "analyze=false", "runner.workers=1")


def play(folder: Path, *overrides: str, **variables: str) -> Path:
    cache = {"FOUNDRY_CACHE": str(folder / "answers.sqlite")}
    succeeds(*overrides, "output.dir=out", cwd=folder, **cache, **variables)
    return folder / "out"


def runs(path: Path) -> list[RunFolder]:
    return SweepFolder.open(path).runs()


def rewrite(sweep: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Change what a sweep's folder says of itself, as whoever hands it on can."""
    file = sweep / "sweep.yaml"
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    change(content)
    file.write_text(to_yaml(content), encoding="utf-8")


def run_of(path: Path, model: str, seed: int = 0) -> RunFolder:
    return next(run for run in runs(path) if (run.config()["model"]["name"], run.run.seed) == (model, seed))


@pytest.fixture(scope="session")
def grid_sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grid")
    with OllamaServer() as server:
        overrides = ("-m", f"model=qwen3:4b,{MIX}", "seed=0-1", *SMALL)
        return play(folder, *overrides, OLLAMA_HOST=server.url)


@pytest.fixture(scope="session")
def camera_sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A room of two layers and a picture, in folders beside each other."""
    return play_in_a_room(tmp_path_factory.mktemp("camera"))


def play_in_a_room(folder: Path) -> Path:
    for name in ("room", "parts"):
        (folder / name).mkdir(parents=True)
    picture(folder / "parts" / "wall.png", np.arange(48).reshape(4, 4, 3) * 5)
    write_stage(folder / "parts" / "wall.usda", build_wall)
    scene = write_stage(folder / "room" / "scene.usda", build_room)
    room = (f"scene={scene}", f"world.scene.root={folder}", "world.camera.width=96", "world.camera.height=72")
    overrides = ("task=Look", "world.steps=3", "model=scripted/wander", "record.frames=3")
    return play(folder, "world=usd", *room, *overrides, "analyze=false", "runner.workers=1")


def build_wall(stage: Any) -> None:
    made = mesh(stage, "/Wall", ((-2, 2, 0), (-2, 2, 3), (2, 2, 3), (2, 2, 0)))
    texture_coordinates(made, ((0, 0), (0, 1), (1, 1), (1, 0)))
    bind(made, textured(stage, "/Wall/Paint", "./wall.png"))


def build_room(stage: Any) -> None:
    room = stage.DefinePrim("/Room", "Xform")
    mesh(stage, "/Room/Floor", ((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)))
    stage.DefinePrim("/Room/North").GetReferences().AddReference("../parts/wall.usda")
    assert room


@pytest.fixture
def copied(grid_sweep: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(grid_sweep, tmp_path / "copy"))
