"""The laboratory module: 11 m long, 2.2 m between the racks, a hatch at +x, airlock and windows at -x.

The coordinates are those of the task: the floor lies at z = -0.2358, the axis at y = 20.1, and a start pose at x = 4
with yaw 180 looks along the module. Seen that way starboard is the right side (+y) and port the left (-y).
"""

from dataclasses import dataclass, replace

from scene_building import rack_textures as art
from scene_building.kibo_equipment import add_equipment
from scene_building.kibo_frame import AXIS_Y, CEILING, FLOOR, HALF, PORT_Y, STARBOARD_Y, X_AIRLOCK, X_HATCH
from scene_building.rack_textures import Row
from scene_building.shapes import Shape, Vector, box, cylinder, extrusion, named, quad, ring
from scene_building.stage import REST, Colour, Look, SceneBuilder
from scene_building.textures import WHITE, plain

DEPTH, BAYS, BAY, END = 0.72, 10, 1.05, 0.25
RADIUS, CHAMFER = 2.2, 0.25

PORT: Colour = (206, 192, 164)
STARBOARD: Colour = (164, 184, 204)
OVERHEAD: Colour = (216, 218, 216)
DECK: Colour = (78, 92, 112)
FRAME = Look("frame", (150, 146, 138), plain((150, 146, 138)))
INSIDE_RACK = Look("rack_side", (112, 112, 110))


@dataclass(frozen=True)
class Side:
    """One side of the module: letter of its racks, tint, the face that looks inwards, and the design of each bay."""

    name: str
    letter: str
    tint: Colour
    face: str
    designs: tuple[int, ...]


SIDES = (
    Side("Port", "F", PORT, "y+", (0, 3, 1, 4, 2, 0, 5, 1, 3, 4)),
    Side("Starboard", "A", STARBOARD, "y-", (2, 1, 4, 0, 3, 5, 1, 2, 0, 3)),
    Side("Overhead", "O", OVERHEAD, "z-", (6, 7, 6, 7, 6, 7, 6, 7, 6, 7)),
)
FLOOR_SIDE = Side("Deck", "D", DECK, "z+", ())

DESIGNS: tuple[tuple[Row, ...], ...] = (
    (Row(2, art.panel), Row(4, art.drawers(2, 3)), Row(1, art.vents), Row(2, art.ports)),
    (Row(8, art.drawers(2, 5)), Row(1, art.vents)),
    (Row(3, art.display), Row(3, art.drawers(1, 3)), Row(2, art.ports), Row(1, art.panel)),
    (Row(2, art.drawers(2, 1)), Row(5, art.bags), Row(1, art.vents)),
    (Row(2, art.display), Row(4, art.chamber), Row(2, art.drawers(2, 1)), Row(1, art.vents)),
    (Row(2, art.panel), Row(3, art.ports), Row(3, art.drawers(3, 2)), Row(1, art.panel)),
    (Row(3, art.panel), Row(1, art.vents), Row(3, art.panel)),
    (Row(2, art.drawers(2, 2)), Row(1, art.panel), Row(2, art.drawers(2, 2))),
)


def build() -> SceneBuilder:
    """Return the scene."""
    scene = SceneBuilder("kibo")
    _add_structure(scene)
    _add_racks(scene)
    _add_handrails(scene)
    _add_lamps(scene)
    add_equipment(scene)
    return scene


def _add_structure(scene: SceneBuilder) -> None:
    scene.part("/World/Structure", "wall")
    shell = ring((X_AIRLOCK, AXIS_Y, FLOOR + HALF), (X_HATCH, AXIS_Y, FLOOR + HALF), RADIUS, RADIUS - 0.05, segments=32)
    scene.mesh("/World/Shell", shell, Look("shell", (196, 198, 200)))
    plate = Look("end_plate", (186, 178, 164), art.end_plate())
    centre = FLOOR + HALF
    aft = cylinder((X_AIRLOCK - 0.1, AXIS_Y, centre), (X_AIRLOCK, AXIS_Y, centre), RADIUS, segments=32)
    forward = cylinder((X_HATCH + 0.1, AXIS_Y, centre), (X_HATCH, AXIS_Y, centre), RADIUS, segments=32)
    scene.mesh("/World/Structure/AirlockEnd", aft, plate)
    scene.mesh("/World/Structure/HatchEnd", forward, plate)
    for name, x0, x1 in (("AirlockFrame", X_AIRLOCK, X_AIRLOCK + END), ("HatchFrame", X_HATCH - END, X_HATCH)):
        frame: Shape = ()
        for low, high in _cross_sections():
            frame += box((x0, *low), (x1, *high), tile=(0.5, 0.5))
        scene.mesh(f"/World/Structure/{name}", frame, FRAME)
    inner = CEILING - CHAMFER
    port = [(PORT_Y, inner), (PORT_Y + CHAMFER, CEILING), (PORT_Y, CEILING)]
    starboard = [(STARBOARD_Y, inner), (STARBOARD_Y, CEILING), (STARBOARD_Y - CHAMFER, CEILING)]
    for name, profile in (("Standoff_Port", port), ("Standoff_Starboard", starboard)):
        scene.mesh(
            f"/World/Structure/{name}", extrusion(profile, X_AIRLOCK, X_HATCH), Look("standoff", (128, 132, 138))
        )


def _cross_sections() -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
    """Return the (y, z) corners of the four sides, in the order of SIDES, then the floor."""
    return (
        ((PORT_Y - DEPTH, FLOOR), (PORT_Y, CEILING)),
        ((STARBOARD_Y, FLOOR), (STARBOARD_Y + DEPTH, CEILING)),
        ((PORT_Y, CEILING), (STARBOARD_Y, CEILING + DEPTH)),
        ((PORT_Y, FLOOR - DEPTH), (STARBOARD_Y, FLOOR)),
    )


def _add_racks(scene: SceneBuilder) -> None:
    labels = [f"JPM1{side.letter}{bay + 1}" for bay in range(BAYS) for side in SIDES]
    sheet = Look("rack_labels", WHITE, art.label_sheet(labels, len(SIDES), BAYS))
    for number, side in enumerate(SIDES):
        for bay, design in enumerate(side.designs):
            front = Look(f"{side.name.lower()}_{design}", side.tint, art.rack_front(side.tint, DESIGNS[design]))
            path = _add_rack(scene, side, number, bay, front)
            scene.mesh(f"{path}/Label", _label_quad(number, bay), sheet)
    # No label plates on the floor: they would lift the feet of whoever walks over them.
    plate = Look("deck", DECK, art.deck_plate(DECK))
    for bay in range(BAYS):
        _add_rack(scene, FLOOR_SIDE, len(SIDES), bay, plate)


def _add_rack(scene: SceneBuilder, side: Side, number: int, bay: int, front: Look) -> str:
    low, high = _cross_sections()[number]
    x1 = X_HATCH - END - BAY * bay
    path = scene.thing(f"/World/Racks/{side.name}_{bay + 1:02d}", f"rack JPM1{side.letter}{bay + 1}")
    scene.mesh(f"{path}/Body", box((x1 - BAY, *low), (x1, *high)), {REST: INSIDE_RACK, side.face: front})
    return path


def _label_quad(side: int, bay: int) -> Shape:
    """Return the label of a rack, upright at the top of its front, with its place on the sheet."""
    width, height, gap = 0.27, 0.09, 0.004
    x1 = X_HATCH - END - BAY * bay
    x0, top = x1 - 0.38, CEILING - CHAMFER - 0.13
    shapes = (
        quad((x0 + width, PORT_Y + gap, top), (-width, 0, 0), (0, 0, height)),
        quad((x0, STARBOARD_Y - gap, top), (width, 0, 0), (0, 0, height)),
        quad((x1 - 0.1, AXIS_Y - width / 2, CEILING - gap), (0, width, 0), (height, 0, 0)),
    )
    (face,) = shapes[side]
    uvs = tuple(((side + u) / len(SIDES), 1 - (bay + 1 - v) / BAYS) for u, v in face.uvs)
    return (replace(face, uvs=uvs),)


def _add_handrails(scene: SceneBuilder) -> None:
    pattern = scene.pattern("Handrail")
    rail = cylinder((-0.4, 0.07, 0), (0.4, 0.07, 0), 0.018, segments=8)
    for x in (-0.36, 0.36):
        rail += box((x - 0.02, 0, -0.02), (x + 0.02, 0.07, 0.02))
    scene.mesh(f"{pattern}/Rail", named(rail, "side"), Look("handrail", (214, 158, 40)))
    for name, y, turn, bays in (
        ("Port", PORT_Y, 0.0, (1, 2, 4, 5, 7, 9, 10)),
        ("Starboard", STARBOARD_Y, 180.0, (1, 2, 5, 7, 8, 10)),
    ):
        for bay in bays:
            at: Vector = (X_HATCH - END - BAY * (bay - 0.5), y, FLOOR + 0.62)
            scene.copy(f"/World/Handrails/{name}_{bay:02d}", pattern, "handrail", at=at, turn=turn)


def _add_lamps(scene: SceneBuilder) -> None:
    inner, lift = CEILING - CHAMFER, 0.025
    port = [
        (PORT_Y + 0.08, inner + 0.08), (PORT_Y + 0.08 + lift, inner + 0.08 - lift),
        (PORT_Y + 0.17 + lift, inner + 0.17 - lift), (PORT_Y + 0.17, inner + 0.17),
    ]  # fmt: skip
    starboard = [(2 * AXIS_Y - y, z) for y, z in reversed(port)]
    look = Look("lamp", (250, 248, 236), glows=True)
    for name, profile in (("Port", port), ("Starboard", starboard)):
        for number in range(5):
            x0 = X_AIRLOCK + 0.7 + 2.1 * number
            path = scene.thing(f"/World/Lamps/{name}_{number + 1}", "lamp")
            scene.mesh(f"{path}/Tube", extrusion(profile, x0, x0 + 1.2), look)
