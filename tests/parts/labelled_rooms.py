"""Two rooms with a door between them and five things with labels of their own: small, quick to draw, known by heart."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pxr import Gf, Usd

from worlds.camera.usd_files import mesh, write_stage

Point = tuple[float, float, float]

THINGS: Mapping[str, tuple[Point, Point]] = {
    "red box": ((0.6, 0.6, 0.0), (1.2, 1.2, 1.4)),
    "blue box": ((0.6, 4.8, 0.0), (1.2, 5.4, 1.4)),
    "green box": ((6.8, 0.6, 0.0), (7.4, 1.2, 1.4)),
    "yellow box": ((6.8, 4.8, 0.0), (7.4, 5.4, 1.4)),
    "white post": ((3.85, 5.6, 0.0), (4.15, 5.9, 1.2)),
}
"""Lowest and highest corner of each thing, metres; the rooms are 8 x 6, with a door in the wall at x = 4."""

STOOLS = (((2.0, 2.6, 0.0), (2.3, 2.9, 0.3)), ((5.6, 2.6, 0.0), (5.9, 2.9, 0.3)))
"""Two things of one name."""

TINY = (
    "world.camera.width=96",
    "world.camera.height=72",
    "world.things.pixels=4",
    "world.steps=25",
    "world.way.shortest=2",
)
"""Settings with which the rooms are quick to play in."""


def write_rooms(path: Path, *, labelled: bool = True) -> Path:
    def build(stage: Any) -> None:
        mesh(stage, "/World/Floor", ((0, 0, 0), (8, 0, 0), (8, 6, 0), (0, 6, 0)))
        sides = (((-0.1, -0.1, 0), (8.1, 0, 3)), ((-0.1, 6, 0), (8.1, 6.1, 3)), ((-0.1, 0, 0), (0, 6, 3)),
                 ((8, 0, 0), (8.1, 6, 3)), ((3.9, 0, 0), (4.1, 4, 3)))  # fmt: skip
        for number, (low, high) in enumerate(sides):
            _box(stage, f"/World/Wall_{number}", low, high, (0.7, 0.7, 0.7))
        for number, (low, high) in enumerate(STOOLS):
            _named(stage, f"/World/Stool_{number}", "stool", low, high, labelled=labelled)
        for number, (name, (low, high)) in enumerate(THINGS.items()):
            _named(stage, f"/World/Thing_{number}", name, low, high, labelled=labelled)

    return write_stage(path, build)


def _named(stage: Any, path: str, name: str, low: Point, high: Point, *, labelled: bool) -> None:
    prim = _box(stage, path, low, high, (0.9, 0.2, 0.2)).GetPrim()
    if labelled:
        Usd.ModelAPI(prim).SetKind("component")
        prim.SetDisplayName(name)


def _box(stage: Any, path: str, low: Sequence[float], high: Sequence[float], colour: Sequence[float]) -> Any:
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    made = mesh(stage, path, corners, faces)
    made.CreateDisplayColorAttr([Gf.Vec3f(*colour)])
    return made
