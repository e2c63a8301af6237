"""An office floor of 14 x 10 m: six rooms on both sides of a corridor, doors 1 m wide, floor at z = 0."""

from scene_building import furniture as items
from scene_building.rooms import Room, Wall, add_ceiling, add_floor, add_wall, outer_walls, wall_look
from scene_building.shapes import block, box, cylinder, named, quad, sphere
from scene_building.stage import REST, Look, SceneBuilder
from scene_building.textures import INK, WHITE, canvas, grid, outdoors, paper_mark, planks, screen, servers, sign

SIZE = (14.0, 10.0)
HEIGHT, DOOR = 2.6, 2.1

WALLS = (
    *outer_walls(SIZE, ("cream", "cream", "cream", "cream")),
    Wall("Corridor_South", "x", 4.3, (0.0, 14.0), ("cream", "grey"), ((2.5, 3.5), (7.7, 8.7), (11.5, 12.5))),
    Wall("Corridor_North", "x", 5.8, (0.0, 14.0), ("grey", "cream"), ((1.4, 2.4), (5.5, 6.5), (10.5, 11.5))),
    Wall("OpenOffice_Meeting", "y", 6.2, (0.0, 4.25), ("blue", "green"), ((2.6, 3.6),)),
    Wall("Meeting_Copy", "y", 10.2, (0.0, 4.25), ("green", "ochre")),
    Wall("Manager_Kitchen", "y", 4.0, (5.85, 10.0), ("brown", "teal")),
    Wall("Kitchen_Lounge", "y", 8.6, (5.85, 10.0), ("teal", "rose"), ((6.6, 7.6),)),
)
COLOURS = {
    "outside": (150, 146, 140),
    "cream": (232, 224, 204),
    "grey": (200, 204, 210),
    "blue": (150, 178, 208),
    "green": (158, 194, 158),
    "ochre": (216, 186, 122),
    "brown": (190, 162, 136),
    "teal": (146, 196, 196),
    "rose": (212, 164, 158),
}
CARPET = Look("carpet", (92, 104, 124), grid((92, 104, 124), (80, 90, 108), strength=4))
GREEN_CARPET = Look("green_carpet", (92, 118, 98), grid((92, 118, 98), (82, 104, 88), strength=4))
TILES = Look("tiles", (204, 200, 190), grid((204, 200, 190), (130, 126, 120), other=(150, 158, 164)))
LINOLEUM = Look("linoleum", (142, 138, 130), grid((142, 138, 130), (122, 118, 110)))
PARQUET = Look("parquet", (174, 124, 78), planks((174, 124, 78)))
ROOMS = {
    "OpenOffice": Room((0.0, 0.0), (6.2, 4.3), CARPET),
    "Meeting": Room((6.2, 0.0), (10.2, 4.3), GREEN_CARPET),
    "Copy": Room((10.2, 0.0), (14.0, 4.3), LINOLEUM),
    "Corridor": Room((0.0, 4.3), (14.0, 5.8), LINOLEUM, (1.5, 1.5)),
    "Manager": Room((0.0, 5.8), (4.0, 10.0), PARQUET, (2.0, 0.8)),
    "Kitchen": Room((4.0, 5.8), (8.6, 10.0), TILES, (0.8, 0.8)),
    "Lounge": Room((8.6, 5.8), (14.0, 10.0), PARQUET, (2.0, 0.8)),
}
LAMPS = (
    *((x, 2.1) for x in (1.5, 4.5, 7.2, 9.2, 12.1)),
    *((x, 5.05) for x in (1.0, 4.6, 8.2, 11.8)),
    *((x, 7.9) for x in (2.0, 5.2, 7.4, 10.0, 12.6)),
)

SIGNS = (
    ("Open_Office", "OFFICE", 2.1, 4.35, 180),
    ("Meeting", "MEETING", 7.3, 4.35, 180),
    ("Copy", "COPY ROOM", 11.1, 4.35, 180),
    ("Manager", "MANAGER", 2.8, 5.75, 0),
    ("Kitchen", "KITCHEN", 6.9, 5.75, 0),
    ("Lounge", "LOUNGE", 11.9, 5.75, 0),
)
"""Door signs: prim, text, place (x, y) and turn."""


def build() -> SceneBuilder:
    """Return the scene."""
    scene = SceneBuilder("office")
    looks = {name: wall_look(name, colour) for name, colour in COLOURS.items()}
    scene.part("/World/Walls", "wall")
    for wall in WALLS:
        add_wall(scene, wall, looks, height=HEIGHT, door=DOOR)
    for name, room in ROOMS.items():
        add_floor(scene, name, room)
    ceiling = Look("ceiling", (228, 226, 220), grid((228, 226, 220), (176, 174, 168)))
    add_ceiling(scene, SIZE, HEIGHT, ceiling, LAMPS)
    _add_windows(scene)
    _furnish_open_office(scene)
    _furnish_meeting(scene)
    _furnish_copy(scene)
    _furnish_manager(scene)
    _furnish_kitchen(scene)
    _furnish_lounge(scene)
    _furnish_corridor(scene)
    return scene


def _add_windows(scene: SceneBuilder) -> None:
    view = Look("outdoors", (150, 196, 232), outdoors())
    places = [(f"South_{k}", x, 0.0, 180) for k, x in enumerate((1.4, 4.6, 12.4), start=1)]
    places += [(f"North_{k}", x, SIZE[1], 0) for k, x in enumerate((1.5, 12.2), start=1)]
    for name, x, y, turn in places:
        path = scene.thing(f"/World/Windows/{name}", "window", at=(x, y, 1.55), turn=turn)
        looks = {REST: Look("window_frame", WHITE), "y-": view}
        scene.mesh(f"{path}/Pane", box((-0.6, -0.03, -0.6), (0.6, 0, 0.6)), looks)


def _furnish_open_office(scene: SceneBuilder) -> None:
    desk, chair = scene.pattern("Desk"), scene.pattern("OfficeChair")
    items.add_desk(scene, desk)
    items.add_office_chair(scene, chair)
    seats = ((1.3, 0.45, 180), (3.0, 0.45, 180), (4.7, 0.45, 180), (0.45, 2.6, 90))
    for number, (x, y, turn) in enumerate(seats, start=1):
        scene.copy(f"/World/OpenOffice/Desk_{number}", desk, "desk", at=(x, y, 0), turn=turn)
    for number, (x, y, turn) in enumerate(
        ((1.3, 1.1, 170), (3.0, 1.15, 205), (4.7, 1.1, 180), (1.15, 2.6, 80)), start=1
    ):
        scene.copy(f"/World/OpenOffice/Chair_{number}", chair, "office chair", at=(x, y, 0), turn=turn)
    plant = scene.thing("/World/OpenOffice/Plant", "plant", "potted plant", at=(5.75, 3.9, 0))
    items.add_plant(scene, plant)
    waste = scene.thing("/World/OpenOffice/Bin", "waste bin", at=(5.85, 0.3, 0))
    items.add_bin(scene, waste, (70, 74, 80))
    cabinet = scene.thing("/World/OpenOffice/FilingCabinet", "filing cabinet", at=(0.5, 4.25, 0))
    scene.mesh(f"{cabinet}/Body", box((-0.45, -0.45, 0), (0.45, 0, 1.2)), Look("cabinet", (94, 110, 122)))
    fronts = box((-0.42, -0.47, 0.06), (0.42, -0.45, 0.4)) + box((-0.42, -0.47, 0.44), (0.42, -0.45, 0.78))
    fronts += box((-0.42, -0.47, 0.82), (0.42, -0.45, 1.16))
    scene.mesh(f"{cabinet}/Drawers", named(fronts, "side"), Look("cabinet_drawer", (132, 150, 162)))


def _furnish_meeting(scene: SceneBuilder) -> None:
    table = scene.thing("/World/Meeting/Table", "meeting table", at=(8.2, 1.9, 0))
    items.add_table(scene, table, (2.0, 0.9))
    chair = scene.pattern("Chair")
    items.add_chair(scene, chair)
    for number, x in enumerate((7.55, 8.2, 8.85)):
        scene.copy(f"/World/Meeting/Chair_S{number + 1}", chair, "chair", at=(x, 1.2, 0))
        scene.copy(f"/World/Meeting/Chair_N{number + 1}", chair, "chair", at=(x, 2.6, 0), turn=180)
    board = scene.thing("/World/Meeting/Whiteboard", "whiteboard", at=(8.2, 0.0, 1.45), turn=180)
    items.add_whiteboard(scene, board)
    wall_screen = scene.thing("/World/Meeting/Screen", "wall screen", at=(10.15, 2.1, 1.5), turn=270)
    looks = {REST: items.BLACK, "y-": Look("wall_screen", (24, 38, 62), screen(1))}
    scene.mesh(f"{wall_screen}/Screen", box((-0.7, -0.05, -0.42), (0.7, 0, 0.42)), looks)


def _furnish_copy(scene: SceneBuilder) -> None:
    items.add_printer(scene, scene.thing("/World/Copy/Printer", "printer", at=(13.95, 2.2, 0), turn=270))
    cabinet = scene.thing("/World/Copy/ServerCabinet", "server cabinet", at=(10.75, 0.02, 0), turn=180)
    rows = {REST: items.BLACK, "y-": Look("servers", (34, 38, 46), servers())}
    scene.mesh(f"{cabinet}/Body", box((-0.35, -0.8, 0), (0.35, 0, 1.95)), rows)
    pattern = scene.pattern("Carton")
    scene.mesh(f"{pattern}/Carton", block((0.5, 0.4, 0.36)), Look("carton", (190, 148, 96)))
    scene.mesh(f"{pattern}/Tape", block((0.06, 0.405, 0.364)), Look("tape", (226, 206, 160)))
    for number, (x, y, z) in enumerate(((13.6, 0.3, 0), (13.05, 0.3, 0), (13.5, 0.3, 0.36)), start=1):
        scene.copy(f"/World/Copy/Carton_{number}", pattern, "cardboard box", at=(x, y, z))
    waste = scene.thing("/World/Copy/RecyclingBin", "recycling bin", at=(13.7, 3.9, 0))
    items.add_bin(scene, waste, (40, 110, 200))


def _furnish_manager(scene: SceneBuilder) -> None:
    scene.copy("/World/Manager/Desk", "/Pattern_Desk", "desk", at=(1.9, 8.4, 0), turn=180)
    scene.copy("/World/Manager/Chair", "/Pattern_OfficeChair", "office chair", at=(1.9, 9.1, 0), turn=175)
    items.add_bookshelf(scene, scene.thing("/World/Manager/Bookshelf", "bookshelf", at=(0.02, 7.4, 0), turn=90))
    safe = scene.thing("/World/Manager/Safe", "safe", at=(3.6, 9.65, 0))
    scene.mesh(f"{safe}/Body", block((0.55, 0.5, 0.7)), Look("safe", (62, 82, 70)))
    dial = cylinder((0, -0.25, 0.45), (0, -0.29, 0.45), 0.07) + block((0.12, 0.05, 0.03), (-0.15, -0.27, 0.44))
    scene.mesh(f"{safe}/Dial", named(dial, "side"), items.STEEL)
    items.add_plant(scene, scene.thing("/World/Manager/Plant", "plant", "potted plant", at=(0.4, 9.6, 0)), 1.7)


def _furnish_kitchen(scene: SceneBuilder) -> None:
    items.add_counter(scene, scene.thing("/World/Kitchen/Counter", "kitchen counter", at=(5.6, 10.0, 0)), 3.0)
    items.add_coffee_machine(scene, scene.thing("/World/Kitchen/CoffeeMachine", "coffee machine", at=(4.5, 9.97, 0.9)))
    items.add_microwave(scene, scene.thing("/World/Kitchen/Microwave", "microwave", at=(6.75, 9.97, 0.9)))
    items.add_fridge(scene, scene.thing("/World/Kitchen/Refrigerator", "refrigerator", "fridge", at=(7.7, 9.98, 0)))
    items.add_round_table(scene, scene.thing("/World/Kitchen/Table", "kitchen table", at=(5.3, 7.7, 0)))
    for number, (x, y, turn) in enumerate(((4.6, 7.7, 270), (6.0, 7.7, 90)), start=1):
        scene.copy(f"/World/Kitchen/Chair_{number}", "/Pattern_Chair", "chair", at=(x, y, 0), turn=turn)
    items.add_bin(scene, scene.thing("/World/Kitchen/Bin", "waste bin", at=(8.25, 6.15, 0)), (60, 140, 80))


def _furnish_lounge(scene: SceneBuilder) -> None:
    items.add_sofa(scene, scene.thing("/World/Lounge/Sofa", "sofa", at=(13.98, 8.2, 0), turn=270), (196, 84, 40))
    items.add_table(scene, scene.thing("/World/Lounge/LowTable", "coffee table", at=(12.5, 8.2, 0)), (0.6, 1.1), 0.42)
    for number, x in enumerate((9.2, 10.5), start=1):
        path = scene.thing(f"/World/Lounge/Bookshelf_{number}", "bookshelf", at=(x + 0.1 * (number - 1), 9.98, 0))
        items.add_bookshelf(scene, path)
    items.add_plant(scene, scene.thing("/World/Lounge/Plant", "plant", "potted plant", at=(13.5, 9.5, 0)), 1.6)
    clock = scene.thing("/World/Lounge/Clock", "wall clock", at=(9.4, 5.85, 1.8), turn=180)
    scene.mesh(
        f"{clock}/Case", cylinder((0, 0, 0), (0, -0.05, 0), 0.22, segments=24), {REST: items.BLACK, "end": _face()}
    )
    globe = scene.thing("/World/Lounge/Globe", "globe", at=(13.5, 6.3, 0))
    scene.mesh(f"{globe}/Stand", cylinder((0, 0, 0), (0, 0, 0.62), 0.16, end_radius=0.04), items.DARK_WOOD)
    scene.mesh(f"{globe}/Ball", sphere((0, 0, 0.85), 0.25, segments=16), Look("globe", (40, 104, 190)))


def _face() -> Look:
    picture, draw = canvas((128, 128), WHITE)
    for hour in range(12):
        draw.pieslice((10, 10, 118, 118), 30 * hour - 3, 30 * hour + 3, fill=INK)
    draw.ellipse((20, 20, 108, 108), fill=WHITE)
    draw.line((64, 64, 38, 48), fill=INK, width=7)
    draw.line((64, 64, 92, 28), fill=(200, 40, 30), width=5)
    return Look("clock_face", WHITE, picture)


def _furnish_corridor(scene: SceneBuilder) -> None:
    items.add_water_cooler(
        scene, scene.thing("/World/Corridor/WaterCooler", "water cooler", at=(0.02, 5.1, 0), turn=90)
    )
    bottle = scene.thing("/World/Corridor/FireExtinguisher", "fire extinguisher", at=(9.6, 4.35, 1.0), turn=180)
    items.add_extinguisher(scene, bottle)
    notices = scene.thing("/World/Corridor/NoticeBoard", "notice board", at=(4.0, 5.75, 1.5))
    cork = Look("notices", (182, 136, 86), paper_mark((200, 120), (182, 136, 86), (250, 246, 230)))
    scene.mesh(f"{notices}/Board", box((-0.6, -0.03, -0.36), (0.6, 0, 0.36)), {REST: items.DARK_WOOD, "y-": cork})
    door = scene.thing("/World/Corridor/ExitDoor", "exit door", at=(13.995, 5.05, 0), turn=270)
    items.add_exit_door(scene, door)
    for name, text, x, y, turn in SIGNS:
        path = scene.thing(f"/World/Signs/{name}", f"{text.lower()} sign", at=(x, y, 1.65), turn=turn)
        look = Look(f"sign_{name.lower()}", WHITE, sign(text, paper=WHITE, ink=(30, 60, 120), size=(192, 64)))
        scene.mesh(f"{path}/Plate", quad((-0.24, -0.008, 0), (0.48, 0, 0), (0, 0, 0.16)), look)
