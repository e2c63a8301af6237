"""An empty stage to fill, and a room that the 3D tests look around in."""

from pathlib import Path
from typing import Any

import pytest
from pxr import Gf

from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.loading.stage import load_scene
from labelled_rooms import write_rooms
from worlds.camera.usd_files import mesh, new_stage, write_stage

WALLS = {
    "Floor": ((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)),
    "Ceiling": ((-2, -2, 4), (-2, 2, 4), (2, 2, 4), (2, -2, 4)),
    "East": ((2, -2, 0), (2, -2, 4), (2, 2, 4), (2, 2, 0)),
    "West": ((-2, -2, 0), (-2, 2, 0), (-2, 2, 4), (-2, -2, 4)),
    "North": ((-2, 2, 0), (2, 2, 0), (2, 2, 4), (-2, 2, 4)),
    "South": ((-2, -2, 0), (-2, -2, 4), (2, -2, 4), (2, -2, 0)),
}
"""The six sides of a cube of 4 m, each facing inwards."""


def build_room(stage: Any) -> None:
    for name, points in WALLS.items():
        mesh(stage, f"/Room/{name}", points).CreateDisplayColorAttr([Gf.Vec3f(0.5)])


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return new_stage(tmp_path / "scene.usda")


@pytest.fixture(scope="session")
def room(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return load_scene(write_stage(tmp_path_factory.mktemp("room") / "room.usda", build_room))


@pytest.fixture(scope="session")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_rooms(tmp_path_factory.mktemp("rooms") / "rooms.usda")
