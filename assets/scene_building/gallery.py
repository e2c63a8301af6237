"""A gallery of four halls, 16 x 12 m, with twelve numbered pictures; floor at z = 0, the halls in a row A-B-C-D."""

from scene_building import furniture as items
from scene_building.pictures import MOTIFS, picture
from scene_building.rooms import Room, Wall, add_ceiling, add_floor, add_wall, outer_walls, wall_look
from scene_building.shapes import block, box, cylinder, named, quad, sphere
from scene_building.stage import REST, Look, SceneBuilder
from scene_building.textures import INK, WHITE, grid, plain, planks, sign

SIZE = (16.0, 12.0)
HEIGHT, DOOR = 3.0, 2.4

WALLS = (
    *outer_walls(SIZE, ("cream", "cream", "cream", "cream")),
    Wall("Between_A_B", "y", 8.0, (0.0, 5.95), ("sand", "blue"), ((2.2, 3.8),)),
    Wall("Between_D_C", "y", 8.0, (6.05, 12.0), ("rose", "green"), ((8.2, 9.8),)),
    Wall("Between_A_D", "x", 6.0, (0.0, 8.0), ("sand", "rose")),
    Wall("Between_B_C", "x", 6.0, (8.0, 16.0), ("blue", "green"), ((11.2, 12.8),)),
    Wall("Partition_B", "x", 2.9, (10.4, 13.0), ("blue", "blue"), thickness=0.2),
    Wall("Partition_D", "y", 4.2, (7.7, 10.3), ("rose", "rose"), thickness=0.2),
)
COLOURS = {
    "outside": (150, 146, 140),
    "cream": (234, 226, 208),
    "sand": (212, 188, 140),
    "blue": (148, 174, 206),
    "green": (156, 194, 160),
    "rose": (208, 162, 162),
}
HALLS = {
    "A": Room((0.0, 0.0), (8.0, 6.0), Look("parquet", (168, 118, 74), planks((168, 118, 74))), (2.0, 0.8)),
    "B": Room((8.0, 0.0), (16.0, 6.0), Look("stone", (146, 146, 148), grid((146, 146, 148), (112, 112, 114)))),
    "C": Room((8.0, 6.0), (16.0, 12.0), Look("dark_parquet", (112, 74, 52), planks((112, 74, 52))), (2.0, 0.8)),
    "D": Room(
        (0.0, 6.0),
        (8.0, 12.0),
        Look("checker", (188, 184, 176), grid((188, 184, 176), (96, 92, 90), other=(112, 116, 124))),
    ),
}
LAMPS = tuple((x, y) for y in (1.6, 4.4, 7.6, 10.4) for x in (2.0, 5.6, 10.2, 13.8))

PLACES = (
    (2.2, 0.0, 180), (0.0, 3.6, 90), (5.2, 5.95, 0),
    (15.98, 4.4, 270), (13.2, 0.0, 180), (11.7, 3.0, 180),
    (15.98, 9.4, 270), (11.0, 12.0, 0), (9.6, 6.05, 180),
    (5.6, 12.0, 0), (0.0, 10.4, 90), (4.1, 9.0, 270),
)  # fmt: skip
"""The position (x, y) and the rotation of each picture, in the order of the pictures' numbers."""


def build() -> SceneBuilder:
    """Return the scene."""
    scene = SceneBuilder("gallery")
    looks = {name: wall_look(name, colour) for name, colour in COLOURS.items()}
    scene.part("/World/Walls", "wall")
    for wall in WALLS:
        add_wall(scene, wall, looks, height=HEIGHT, door=DOOR)
    for name, room in HALLS.items():
        add_floor(scene, f"Hall_{name}", room)
    ceiling = Look("ceiling", (226, 224, 218), grid((226, 224, 218), (170, 168, 162)))
    add_ceiling(scene, SIZE, HEIGHT, ceiling, LAMPS)
    for number in range(1, len(MOTIFS) + 1):
        _add_picture(scene, number)
    _add_furniture(scene)
    _add_signs(scene)
    return scene


def _add_picture(scene: SceneBuilder, number: int) -> None:
    x, y, turn = PLACES[number - 1]
    words = MOTIFS[number - 1].words
    path = scene.thing(f"/World/Pictures/Picture_{number:02d}", f"picture {number}", words, at=(x, y, 1.55), turn=turn)
    frame = Look("picture_frame", (58, 44, 34))
    canvas = Look(f"picture_{number:02d}", MOTIFS[number - 1].ground, picture(number))
    scene.mesh(f"{path}/Frame", box((-0.66, -0.04, -0.52), (0.66, 0, 0.52)), frame)
    scene.mesh(f"{path}/Canvas", box((-0.6, -0.05, -0.4667), (0.6, -0.04, 0.4667)), {REST: frame, "y-": canvas})
    plate = Look(f"plate_{number:02d}", WHITE, sign(str(number), paper=WHITE, ink=INK, size=(64, 48)))
    scene.mesh(f"{path}/Plate", quad((-0.14, -0.01, -0.78), (0.28, 0, 0), (0, 0, 0.21)), plate)


def _add_furniture(scene: SceneBuilder) -> None:
    bench = scene.pattern("Bench")
    items.add_bench(scene, bench)
    for name, x, y, turn in (("A", 3.6, 3.0, 0), ("B", 12.0, 1.5, 0), ("C", 13.0, 9.0, 90), ("D", 1.9, 8.6, 90)):
        scene.copy(f"/World/Benches/Bench_{name}", bench, "bench", at=(x, y, 0), turn=turn)
    desk = scene.thing("/World/InformationDesk", "information desk", at=(1.0, 5.3, 0))
    front = Look("desk_front", (40, 70, 130), sign("i  INFO", paper=(40, 70, 130), ink=WHITE, size=(256, 128)))
    scene.mesh(
        f"{desk}/Body", box((-0.7, -0.3, 0), (0.7, 0.3, 1.0)), {REST: Look("desk_side", (46, 60, 96)), "y-": front}
    )
    scene.mesh(f"{desk}/Top", box((-0.75, -0.35, 1.0), (0.75, 0.35, 1.04)), items.PALE)
    statue = scene.thing("/World/Sculpture", "sculpture", at=(14.6, 7.2, 0))
    scene.mesh(f"{statue}/Plinth", block((0.6, 0.6, 0.8)), Look("plinth", (196, 192, 186), plain((196, 192, 186))))
    balls = sphere((0, 0, 1.05), 0.25) + sphere((0, 0, 1.45), 0.18) + sphere((0, 0, 1.74), 0.12)
    scene.mesh(f"{statue}/Balls", balls, Look("bronze", (186, 128, 50)))
    vase = scene.thing("/World/Vase", "vase", at=(7.3, 11.3, 0))
    pot = cylinder((0, 0, 0), (0, 0, 0.5), 0.16, end_radius=0.28) + cylinder(
        (0, 0, 0.5), (0, 0, 0.9), 0.28, end_radius=0.12
    )
    scene.mesh(f"{vase}/Pot", named(pot, "side"), Look("vase", (40, 130, 150)))
    items.add_plant(scene, scene.thing("/World/Plant", "plant", "potted plant", at=(8.6, 0.5, 0)), 1.6)


def _add_signs(scene: SceneBuilder) -> None:
    door = scene.thing("/World/ExitDoor", "exit door", at=(6.6, 0.0, 0), turn=180)
    items.add_exit_door(scene, door)
    over_doors = (("B", 7.95, 3.0, 270), ("A", 8.05, 3.0, 90), ("C", 12.0, 5.95, 0), ("D", 8.05, 9.0, 90))
    for hall, x, y, turn in over_doors:
        path = scene.thing(f"/World/Signs/To_Hall_{hall}", f"sign to hall {hall}", at=(x, y, 2.5), turn=turn)
        look = Look(f"sign_{hall}", WHITE, sign(f"HALL {hall}", paper=WHITE, ink=(130, 40, 40), size=(192, 64)))
        scene.mesh(f"{path}/Plate", quad((-0.42, -0.01, 0), (0.84, 0, 0), (0, 0, 0.28)), look)
