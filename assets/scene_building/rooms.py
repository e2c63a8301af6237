"""Walls with openings, floors and ceilings: a building without gaps, its rooms told apart by their colours."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from scene_building.shapes import Shape, box
from scene_building.stage import REST, Colour, Look, SceneBuilder
from scene_building.textures import shade, wall

Opening = tuple[float, float]
WALL_TILE = 2.0
THIN, THICK = 0.1, 0.16


@dataclass(frozen=True)
class Wall:
    """A wall along x or y.

    Attributes:
        name: of its prim.
        along: `x` or `y`.
        at: its middle line on the other axis, metres.
        span: where it begins and ends.
        looks: of the lower and of the higher side: names of rooms.
        openings: where doors begin and end.
        thickness: metres.
    """

    name: str
    along: str
    at: float
    span: tuple[float, float]
    looks: tuple[str, str]
    openings: Sequence[Opening] = ()
    thickness: float = THIN


@dataclass(frozen=True)
class Room:
    """A rectangle of floor: two corners (x, y), and its look; `tile` is metres per repetition."""

    low: tuple[float, float]
    high: tuple[float, float]
    floor: Look
    tile: tuple[float, float] = (1.0, 1.0)


def wall_look(name: str, colour: Colour) -> Look:
    """Return the look of a wall, its texture over the whole height."""
    return Look(f"wall_{name}", colour, wall(colour, shade(colour, 0.5)))


def add_wall(scene: SceneBuilder, spec: Wall, looks: Mapping[str, Look], *, height: float, door: float) -> None:
    """Add a wall with its lintels; `door` is the height of the openings."""
    shape: Shape = ()
    start = spec.span[0]
    for begin, end in sorted(spec.openings):
        shape += _piece(spec, (start, begin), (0.0, height), height)
        shape += _piece(spec, (begin, end), (door, height), height)
        start = end
    shape += _piece(spec, (start, spec.span[1]), (0.0, height), height)
    low, high = ("y-", "y+") if spec.along == "x" else ("x-", "x+")
    edge = Look("wall_edge", (120, 112, 104))
    scene.mesh(f"/World/Walls/{spec.name}", shape, {REST: edge, low: looks[spec.looks[0]], high: looks[spec.looks[1]]})


def _piece(spec: Wall, span: tuple[float, float], rise: tuple[float, float], height: float) -> Shape:
    low, high = spec.at - spec.thickness / 2, spec.at + spec.thickness / 2
    if spec.along == "x":
        shape = box((span[0], low, rise[0]), (span[1], high, rise[1]), tile=(WALL_TILE, height))
    else:
        shape = box((low, span[0], rise[0]), (high, span[1], rise[1]), tile=(WALL_TILE, height))
    # A lintel shows the upper part of the texture, not another skirting board.
    lift = rise[0] / height
    return tuple(replace(face, uvs=tuple((u, v + lift) for u, v in face.uvs)) for face in shape)


def add_floor(scene: SceneBuilder, name: str, room: Room) -> None:
    """Add the floor of a room, 0.1 m thick, its top at z = 0."""
    slab = box((*room.low, -0.1), (*room.high, 0.0), tile=room.tile)
    scene.mesh(f"/World/Floor/{name}", slab, {REST: Look("slab", (110, 110, 108)), "z+": room.floor})


def add_ceiling(
    scene: SceneBuilder, size: tuple[float, float], height: float, look: Look, lamps: Sequence[tuple[float, float]]
) -> None:
    """Add the ceiling over the whole building and square lamps under it, all under /World/Ceiling."""
    slab = box((-THICK, -THICK, height), (size[0] + THICK, size[1] + THICK, height + 0.1), tile=(1.2, 1.2))
    scene.mesh("/World/Ceiling/Slab", slab, {REST: Look("slab", (110, 110, 108)), "z-": look})
    shine = Look("lamp", (250, 248, 236), glows=True)
    for number, (x, y) in enumerate(lamps, start=1):
        path = scene.thing(f"/World/Ceiling/Lamp_{number:02d}", "ceiling lamp", at=(x, y, height - 0.04))
        scene.mesh(f"{path}/Panel", box((-0.3, -0.3, 0.0), (0.3, 0.3, 0.04)), shine)


def outer_walls(size: tuple[float, float], looks: Sequence[str]) -> list[Wall]:
    """Return the four outer walls; `looks` are those inside on the south, north, west and east."""
    (x, y), half = size, THICK / 2
    south, north, west, east = looks
    return [
        Wall("South", "x", -half, (-THICK, x + THICK), ("outside", south), thickness=THICK),
        Wall("North", "x", y + half, (-THICK, x + THICK), (north, "outside"), thickness=THICK),
        Wall("West", "y", -half, (0.0, y), ("outside", west), thickness=THICK),
        Wall("East", "y", x + half, (0.0, y), (east, "outside"), thickness=THICK),
    ]
