"""Furniture: each function adds its meshes under a path, standing on the local origin.

Furniture of walls hangs on the plane y = 0 and looks towards -y. Furniture that stands at a wall also looks towards -y.
"""

from scene_building.shapes import Shape, add, block, box, cylinder, named, quad, sphere
from scene_building.stage import REST, Colour, Look, SceneBuilder
from scene_building.textures import WHITE, books, paper_mark, plain, screen, sign, wood

STEEL = Look("steel", (158, 164, 170))
BLACK = Look("black", (44, 46, 50))
RED = Look("red", (204, 36, 30))
PALE = Look("pale", (226, 226, 220))
DARK_WOOD = Look("dark_wood", (128, 84, 52), wood((128, 84, 52)))
LIGHT_WOOD = Look("light_wood", (206, 166, 112), wood((206, 166, 112)))
EXIT_SIGN = Look("sign_exit", (24, 120, 70), sign("EXIT", paper=(24, 120, 70), ink=WHITE))
LEAF = Look("leaf", (48, 128, 58), plain((48, 128, 58), 9))


def add_desk(scene: SceneBuilder, path: str) -> None:
    """Add a desk of 1.4 x 0.7 m with a monitor and a keyboard; one sits at its -y side."""
    scene.mesh(f"{path}/Top", box((-0.7, -0.35, 0.71), (0.7, 0.35, 0.75)), LIGHT_WOOD)
    legs = _legs(0.66, 0.31, 0.71, 0.025)
    scene.mesh(f"{path}/Legs", legs, STEEL)
    looks = {REST: BLACK, "y-": Look("monitor", (24, 38, 62), screen(2))}
    scene.mesh(f"{path}/Monitor", box((-0.28, 0.14, 0.86), (0.28, 0.18, 1.2)), looks)
    stand = block((0.05, 0.04, 0.16), (0, 0.18, 0.75)) + block((0.24, 0.16, 0.015), (0, 0.18, 0.75))
    scene.mesh(f"{path}/Stand", named(stand, "side"), BLACK)
    scene.mesh(f"{path}/Keyboard", block((0.42, 0.14, 0.02), (0, -0.1, 0.75)), PALE)


def add_office_chair(scene: SceneBuilder, path: str) -> None:
    """Add a swivel chair that looks towards +y."""
    cloth = Look("chair_cloth", (52, 78, 128), plain((52, 78, 128), 6))
    scene.mesh(f"{path}/Seat", block((0.46, 0.46, 0.08), (0, 0, 0.42)), cloth)
    scene.mesh(f"{path}/Back", block((0.42, 0.06, 0.46), (0, -0.22, 0.56)), cloth)
    foot: Shape = cylinder((0, 0, 0.06), (0, 0, 0.42), 0.035, segments=8)
    foot += block((0.5, 0.06, 0.06)) + block((0.06, 0.5, 0.06)) + block((0.04, 0.04, 0.16), (0, -0.21, 0.42))
    scene.mesh(f"{path}/Foot", named(foot, "side"), BLACK)


def add_chair(scene: SceneBuilder, path: str) -> None:
    """Add a wooden chair that looks towards +y."""
    scene.mesh(f"{path}/Seat", block((0.42, 0.42, 0.04), (0, 0, 0.44)), DARK_WOOD)
    scene.mesh(f"{path}/Back", block((0.42, 0.04, 0.3), (0, -0.19, 0.62)), DARK_WOOD)
    legs = _legs(0.18, 0.18, 0.44, 0.02) + block((0.04, 0.03, 0.16), (-0.18, -0.19, 0.48))
    scene.mesh(f"{path}/Legs", named(legs + block((0.04, 0.03, 0.16), (0.18, -0.19, 0.48)), "side"), DARK_WOOD)


def add_table(scene: SceneBuilder, path: str, size: tuple[float, float], height: float = 0.74) -> None:
    """Add a table of this size."""
    x, y = size[0] / 2, size[1] / 2
    scene.mesh(f"{path}/Top", box((-x, -y, height - 0.05), (x, y, height), tile=(0.8, 0.8)), DARK_WOOD)
    scene.mesh(f"{path}/Legs", _legs(x - 0.08, y - 0.08, height - 0.05, 0.035), BLACK)


def add_round_table(scene: SceneBuilder, path: str) -> None:
    """Add a round table of 0.9 m on one foot."""
    scene.mesh(f"{path}/Top", cylinder((0, 0, 0.7), (0, 0, 0.74), 0.45, segments=24), PALE)
    foot = cylinder((0, 0, 0.03), (0, 0, 0.7), 0.05, segments=10) + cylinder((0, 0, 0), (0, 0, 0.03), 0.26)
    scene.mesh(f"{path}/Foot", named(foot, "side"), STEEL)


def add_bookshelf(scene: SceneBuilder, path: str) -> None:
    """Add a shelf of 1.0 x 0.35 x 1.9 m with five rows of books."""
    frame = box((-0.5, -0.02, 0), (0.5, 0, 1.9)) + box((-0.5, -0.35, 0), (-0.46, -0.02, 1.9))
    frame += box((0.46, -0.35, 0), (0.5, -0.02, 1.9))
    for level in range(6):
        z = 0.06 + 0.36 * level
        frame += box((-0.46, -0.35, z - 0.04), (0.46, -0.02, z))
    scene.mesh(f"{path}/Frame", named(frame, "side"), DARK_WOOD)
    rows: Shape = ()
    for level in range(5):
        z = 0.06 + 0.36 * level
        rows += box((-0.46, -0.3, z), (0.46, -0.02, z + 0.29))
    looks = {REST: Look("book_block", (120, 96, 80)), "y-": Look("books", (120, 80, 70), books())}
    scene.mesh(f"{path}/Books", rows, looks)


def add_plant(scene: SceneBuilder, path: str, height: float = 1.4) -> None:
    """Add a potted plant; its crown is about 0.6 m wide."""
    pot = Look("pot", (186, 92, 52))
    scene.mesh(f"{path}/Pot", cylinder((0, 0, 0), (0, 0, 0.35), 0.15, end_radius=0.2), pot)
    scene.mesh(f"{path}/Stem", cylinder((0, 0, 0.35), (0, 0, height - 0.3), 0.03, segments=8), DARK_WOOD)
    crown: Shape = ()
    for x, y, z in ((0, 0, -0.25), (0.14, 0.08, -0.45), (-0.13, 0.1, -0.5), (0.02, -0.15, -0.55)):
        crown += sphere((x, y, height + z), 0.2, squash=1.2, segments=10)
    scene.mesh(f"{path}/Crown", crown, LEAF)


def add_extinguisher(scene: SceneBuilder, path: str) -> None:
    """Add a fire extinguisher that hangs on a wall."""
    scene.mesh(f"{path}/Bottle", cylinder((0, -0.1, 0), (0, -0.1, 0.42), 0.075), RED)
    top = cylinder((0, -0.1, 0.42), (0, -0.1, 0.48), 0.03, segments=10) + block((0.14, 0.03, 0.03), (0.03, -0.1, 0.48))
    scene.mesh(f"{path}/Valve", named(top, "side"), BLACK)
    scene.mesh(f"{path}/Bracket", box((-0.06, -0.03, 0.15), (0.06, 0, 0.25)), STEEL)


def add_printer(scene: SceneBuilder, path: str) -> None:
    """Add a large office printer."""
    scene.mesh(f"{path}/Body", box((-0.35, -0.6, 0), (0.35, 0, 0.8)), Look("printer", (206, 208, 210)))
    scene.mesh(f"{path}/Scanner", box((-0.35, -0.6, 0.84), (0.35, 0, 1.02)), Look("printer_dark", (74, 80, 90)))
    scene.mesh(f"{path}/Neck", box((-0.35, -0.2, 0.8), (0.35, 0, 0.84)), BLACK)
    drawers: Shape = ()
    for z in (0.1, 0.34, 0.58):
        drawers += box((-0.32, -0.62, z), (0.32, -0.6, z + 0.2))
    scene.mesh(f"{path}/Drawers", named(drawers, "side"), Look("printer_drawer", (236, 238, 238)))
    scene.mesh(f"{path}/Paper", box((-0.15, -0.5, 0.8), (0.15, -0.22, 0.82)), Look("paper", (252, 252, 250)))
    display = {REST: BLACK, "y-": Look("printer_screen", (24, 38, 62), screen(0))}
    scene.mesh(f"{path}/Display", box((0.05, -0.62, 0.88), (0.3, -0.6, 1.0)), display)


def add_fridge(scene: SceneBuilder, path: str) -> None:
    """Add a refrigerator of 0.65 x 0.65 x 1.8 m."""
    scene.mesh(f"{path}/Body", box((-0.32, -0.6, 0), (0.32, 0, 1.8)), Look("fridge_body", (176, 182, 188)))
    doors = box((-0.32, -0.65, 0.05), (0.32, -0.6, 1.15)) + box((-0.32, -0.65, 1.18), (0.32, -0.6, 1.78))
    scene.mesh(f"{path}/Doors", named(doors, "side"), Look("fridge_door", (214, 222, 228)))
    handles = box((-0.28, -0.69, 0.7), (-0.25, -0.65, 1.1)) + box((-0.28, -0.69, 1.22), (-0.25, -0.65, 1.5))
    scene.mesh(f"{path}/Handles", named(handles, "side"), BLACK)


def add_counter(scene: SceneBuilder, path: str, length: float) -> None:
    """Add a kitchen counter with cupboards below and a sink."""
    half = length / 2
    scene.mesh(f"{path}/Cupboards", box((-half, -0.58, 0), (half, 0, 0.86)), Look("cupboard", (92, 132, 138)))
    scene.mesh(f"{path}/Top", box((-half, -0.62, 0.86), (half, 0, 0.9)), Look("counter_top", (72, 68, 66)))
    doors: Shape = ()
    count = round(length / 0.6)
    for number in range(count):
        x = -half + number * length / count
        doors += box((x + 0.02, -0.6, 0.1), (x + length / count - 0.02, -0.58, 0.82))
    scene.mesh(f"{path}/Doors", named(doors, "side"), Look("cupboard_door", (122, 166, 170)))
    scene.mesh(f"{path}/Sink", box((-0.25, -0.5, 0.9), (0.25, -0.12, 0.91)), STEEL)
    tap = cylinder((0, -0.08, 0.9), (0, -0.08, 1.16), 0.015, segments=8)
    tap += cylinder((0, -0.08, 1.15), (0, -0.26, 1.15), 0.015, segments=8)
    scene.mesh(f"{path}/Tap", named(tap, "side"), STEEL)


def add_coffee_machine(scene: SceneBuilder, path: str) -> None:
    """Add a coffee machine with a red front and a cup."""
    scene.mesh(f"{path}/Body", box((-0.15, -0.22, 0), (0.15, 0, 0.4)), RED)
    scene.mesh(f"{path}/Head", box((-0.15, -0.38, 0.28), (0.15, -0.22, 0.4)), BLACK)
    scene.mesh(f"{path}/Tray", box((-0.14, -0.38, 0), (0.14, -0.22, 0.03)), STEEL)
    scene.mesh(f"{path}/Cup", cylinder((0, -0.3, 0.03), (0, -0.3, 0.12), 0.035, end_radius=0.045), PALE)


def add_microwave(scene: SceneBuilder, path: str) -> None:
    """Add a microwave oven."""
    scene.mesh(f"{path}/Body", box((-0.25, -0.36, 0), (0.25, 0, 0.3)), PALE)
    scene.mesh(f"{path}/Door", box((-0.23, -0.38, 0.03), (0.12, -0.36, 0.27)), BLACK)


def add_sofa(scene: SceneBuilder, path: str, colour: Colour) -> None:
    """Add a sofa of 1.8 x 0.8 m."""
    cloth = Look("sofa", colour, plain(colour, 5))
    scene.mesh(f"{path}/Seat", box((-0.7, -0.8, 0.05), (0.7, -0.2, 0.42), tile=(0.7, 0.5)), cloth)
    scene.mesh(f"{path}/Back", box((-0.9, -0.2, 0.05), (0.9, 0, 0.82), tile=(0.7, 0.5)), cloth)
    arms = box((-0.9, -0.8, 0.05), (-0.7, -0.2, 0.6)) + box((0.7, -0.8, 0.05), (0.9, -0.2, 0.6))
    scene.mesh(f"{path}/Arms", named(arms, "side"), Look("sofa_arm", _darker(colour)))


def add_water_cooler(scene: SceneBuilder, path: str) -> None:
    """Add a water cooler with a blue bottle."""
    scene.mesh(f"{path}/Body", box((-0.16, -0.34, 0), (0.16, 0, 0.95)), PALE)
    scene.mesh(f"{path}/Bottle", cylinder((0, -0.17, 0.95), (0, -0.17, 1.35), 0.14), Look("bottle", (70, 150, 220)))
    taps = block((0.04, 0.06, 0.05), (-0.06, -0.36, 0.75)) + block((0.04, 0.06, 0.05), (0.06, -0.36, 0.75))
    scene.mesh(f"{path}/Taps", named(taps, "side"), RED)


def add_whiteboard(scene: SceneBuilder, path: str) -> None:
    """Add a whiteboard of 2.0 x 1.1 m, its middle on the origin."""
    drawing = Look("whiteboard", WHITE, paper_mark((320, 176), WHITE, (40, 60, 160)))
    scene.mesh(f"{path}/Board", box((-1.0, -0.04, -0.55), (1.0, 0, 0.55)), {REST: STEEL, "y-": drawing})
    scene.mesh(f"{path}/Tray", box((-0.5, -0.12, -0.58), (0.5, -0.04, -0.55)), STEEL)


def add_bin(scene: SceneBuilder, path: str, colour: Colour) -> None:
    """Add a waste bin."""
    shape = cylinder((0, 0, 0), (0, 0, 0.36), 0.12, end_radius=0.16)
    scene.mesh(f"{path}/Bin", shape, Look("bin_{}_{}_{}".format(*colour), colour))


def add_bench(scene: SceneBuilder, path: str) -> None:
    """Add a bench of 1.6 x 0.45 m without a back."""
    scene.mesh(f"{path}/Seat", block((1.6, 0.45, 0.08), (0, 0, 0.38)), DARK_WOOD)
    feet = block((0.08, 0.4, 0.38), (-0.65, 0, 0)) + block((0.08, 0.4, 0.38), (0.65, 0, 0))
    scene.mesh(f"{path}/Feet", named(feet, "side"), BLACK)


def add_exit_door(scene: SceneBuilder, path: str) -> None:
    """Add a closed door of 1.0 x 2.05 m in a wall and the sign above it."""
    scene.mesh(f"{path}/Leaf", box((-0.5, -0.04, 0), (0.5, 0, 2.05)), Look("door", (120, 60, 44)))
    scene.mesh(f"{path}/Handle", box((0.34, -0.09, 1.0), (0.44, -0.04, 1.03)), STEEL)
    scene.mesh(f"{path}/Sign", quad((-0.25, -0.01, 2.12), (0.5, 0, 0), (0, 0, 0.19)), EXIT_SIGN)


def _legs(x: float, y: float, height: float, half: float) -> Shape:
    legs: Shape = ()
    for sx in (-x, x):
        for sy in (-y, y):
            legs += box(add((sx, sy, 0), (half, half, 0), -1), add((sx, sy, height), (half, half, 0)))
    return named(legs, "side")


def _darker(colour: Colour) -> Colour:
    return colour[0] * 3 // 4, colour[1] * 3 // 4, colour[2] * 3 // 4
