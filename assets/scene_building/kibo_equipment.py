"""The equipment of the laboratory module; a task may ask an agent to find it."""

from scene_building import rack_textures as art
from scene_building.furniture import BLACK, EXIT_SIGN, RED, STEEL, add_extinguisher
from scene_building.kibo_frame import AXIS_Y, FLOOR, PORT_Y, STARBOARD_Y, X_AIRLOCK, X_HATCH
from scene_building.shapes import Shape, block, box, cylinder, named, quad, ring, sphere
from scene_building.stage import REST, Look, SceneBuilder
from scene_building.textures import INK, WHITE, plain, screen, sign

YELLOW = (236, 196, 60)


def add_equipment(scene: SceneBuilder) -> None:
    """Add everything that is not the module itself."""
    _add_hatch(scene)
    _add_airlock(scene)
    _add_windows(scene)
    _add_emblem(scene)
    _add_table(scene)
    _add_glovebox(scene)
    _add_bags(scene)
    _add_flyer(scene)
    bottle = scene.thing("/World/FireExtinguisher", "fire extinguisher", at=(3.95, PORT_Y, FLOOR + 0.95), turn=180)
    add_extinguisher(scene, bottle)
    _add_signs(scene)


def _add_hatch(scene: SceneBuilder) -> None:
    path = scene.thing("/World/Hatch", "hatch", at=(X_HATCH, AXIS_Y, FLOOR + 1.0))
    scene.mesh(f"{path}/Frame", box((-0.08, -0.78, -0.78), (0, 0.78, 0.78)), Look("hatch_frame", (150, 120, 70)))
    door = Look("hatch_door", (214, 214, 206), plain((214, 214, 206)))
    scene.mesh(f"{path}/Door", box((-0.12, -0.64, -0.64), (-0.08, 0.64, 0.64), tile=(0.6, 0.6)), door)
    pane = Look("hatch_window", (30, 40, 60))
    scene.mesh(f"{path}/Window", cylinder((-0.12, 0, 0.2), (-0.14, 0, 0.2), 0.14, segments=20), pane)
    scene.mesh(f"{path}/WindowRing", ring((-0.12, 0, 0.2), (-0.15, 0, 0.2), 0.18, 0.14), STEEL)
    lever: Shape = cylinder((-0.17, -0.3, -0.22), (-0.17, 0.3, -0.22), 0.025, segments=8)
    for y in (-0.28, 0.28):
        lever += cylinder((-0.12, y, -0.22), (-0.17, y, -0.22), 0.02, segments=8)
    scene.mesh(f"{path}/Lever", named(lever, "side"), Look("lever", (206, 120, 30)))


def _add_airlock(scene: SceneBuilder) -> None:
    path = scene.thing("/World/Airlock", "airlock", at=(X_AIRLOCK, AXIS_Y, FLOOR + 0.68))
    looks = {REST: STEEL, "end": Look("airlock_lid", (168, 174, 178), art.lid())}
    scene.mesh(f"{path}/Barrel", ring((0, 0, 0), (0.3, 0, 0), 0.58, 0.46), Look("barrel", (132, 138, 146)))
    scene.mesh(f"{path}/Lid", cylinder((0, 0, 0), (0.22, 0, 0), 0.46, segments=24), looks)


def _add_windows(scene: SceneBuilder) -> None:
    view = Look("earth", (40, 90, 160), art.earth())
    for name, y in (("Port", AXIS_Y - 0.46), ("Starboard", AXIS_Y + 0.46)):
        path = scene.thing(f"/World/Windows/{name}", "window", "round window", at=(X_AIRLOCK, y, FLOOR + 1.6))
        scene.mesh(f"{path}/Ring", ring((0, 0, 0), (0.09, 0, 0), 0.31, 0.24), Look("window_ring", (92, 96, 104)))
        scene.mesh(f"{path}/Pane", cylinder((0, 0, 0), (0.03, 0, 0), 0.24, segments=24), {REST: STEEL, "end": view})


def _add_emblem(scene: SceneBuilder) -> None:
    path = scene.thing("/World/Emblem", "JAXA logo", "emblem", at=(-3.375, STARBOARD_Y, FLOOR + 1.36))
    front = Look("emblem", WHITE, art.emblem())
    looks = {REST: Look("emblem_edge", art.EMBLEM_BLUE), "y-": front}
    scene.mesh(f"{path}/Panel", box((-0.4, -0.03, -0.2125), (0.4, 0, 0.2125)), looks)


def _add_table(scene: SceneBuilder) -> None:
    path = scene.thing("/World/WorkTable", "work table", at=(1.85, PORT_Y + 0.25, FLOOR))
    scene.mesh(f"{path}/Top", box((-0.45, -0.25, 0.8), (0.45, 0.25, 0.84)), Look("table_top", (226, 224, 216)))
    legs: Shape = ()
    for x in (-0.41, 0.41):
        for y in (-0.21, 0.21):
            legs += box((x - 0.02, y - 0.02, 0), (x + 0.02, y + 0.02, 0.8))
    scene.mesh(f"{path}/Legs", named(legs, "side"), STEEL)
    laptop = scene.thing("/World/Laptop", "laptop", at=(1.95, PORT_Y + 0.24, FLOOR + 0.84))
    scene.mesh(f"{laptop}/Base", block((0.36, 0.25, 0.025)), BLACK)
    looks = {REST: BLACK, "y+": Look("laptop_screen", (24, 38, 62), screen(1))}
    scene.mesh(f"{laptop}/Lid", box((-0.18, -0.13, 0.025), (0.18, -0.11, 0.28)), looks)


def _add_glovebox(scene: SceneBuilder) -> None:
    path = scene.thing("/World/Glovebox", "glovebox", at=(-0.22, STARBOARD_Y, FLOOR))
    body = Look("glovebox", (232, 232, 226), plain((226, 228, 224)))
    scene.mesh(f"{path}/Body", box((-0.48, -0.55, 0.75), (0.48, 0, 1.65), tile=(0.5, 0.5)), body)
    scene.mesh(f"{path}/Pane", box((-0.38, -0.56, 1.22), (0.38, -0.55, 1.56)), Look("glovebox_pane", (70, 110, 130)))
    gloves: Shape = ()
    for x in (-0.22, 0.22):
        gloves += ring((x, -0.55, 1.0), (x, -0.6, 1.0), 0.12, 0.09, segments=20)
        gloves += named(cylinder((x, -0.55, 1.0), (x, -0.565, 1.0), 0.09, segments=20), "glove")
    scene.mesh(f"{path}/Gloves", gloves, {REST: STEEL, "glove": Look("glove", (214, 96, 40))})
    scene.mesh(f"{path}/Support", box((-0.4, -0.12, 0), (0.4, 0, 0.75)), STEEL)


def _add_bags(scene: SceneBuilder) -> None:
    pattern = scene.pattern("StowageBag")
    cloth = Look("bag", (222, 216, 198), plain((218, 210, 190), 4))
    scene.mesh(f"{pattern}/Cloth", block((0.52, 0.46, 0.38), tile=(0.4, 0.4)), cloth)
    straps = block((0.06, 0.48, 0.385), (-0.15, 0, 0)) + block((0.06, 0.48, 0.385), (0.15, 0, 0))
    scene.mesh(f"{pattern}/Straps", named(straps, "side"), Look("strap", (150, 92, 36)))
    stacks = (("A", 2.5, STARBOARD_Y - 0.25, 0), ("B", 2.52, STARBOARD_Y - 0.25, 1), ("C", -1.9, PORT_Y + 0.25, 0))
    for name, x, y, level in stacks:
        at = (x, y, FLOOR + 0.39 * level)
        scene.copy(f"/World/StowageBags/Bag_{name}", pattern, "stowage bag", at=at)


def _add_flyer(scene: SceneBuilder) -> None:
    path = scene.thing("/World/FreeFlyer", "free flyer", "camera robot", at=(-4.45, PORT_Y + 0.3, FLOOR + 1.35))
    scene.mesh(f"{path}/Ball", sphere((0, 0, 0), 0.13, segments=16), Look("flyer", (236, 238, 240)))
    eyes: Shape = ()
    for y in (-0.045, 0.045):
        eyes += cylinder((0.1, y, 0.02), (0.135, y, 0.02), 0.028, segments=12)
    scene.mesh(f"{path}/Eyes", named(eyes, "side"), Look("flyer_eye", (20, 150, 190)))
    scene.mesh(f"{path}/Band", ring((0, 0, -0.02), (0, 0, -0.05), 0.133, 0.1), Look("flyer_band", (40, 44, 52)))


def _add_signs(scene: SceneBuilder) -> None:
    airlock = Look("sign_airlock", YELLOW, sign("AIRLOCK", paper=YELLOW, ink=INK, size=(320, 80)))
    fire = Look("sign_fire", RED.colour, sign("FIRE", paper=RED.colour, ink=WHITE))
    kibo = Look("sign_kibo", WHITE, sign("KIBO\nlaboratory", paper=WHITE, ink=(150, 60, 30), size=(256, 112)))
    plates = (
        (
            "Exit",
            "exit sign",
            quad((X_HATCH - 0.02, AXIS_Y + 0.25, FLOOR + 1.84), (0, -0.5, 0), (0, 0, 0.19)),
            EXIT_SIGN,
        ),
        (
            "Airlock",
            "airlock sign",
            quad((X_AIRLOCK + 0.02, AXIS_Y - 0.3, FLOOR + 1.97), (0, 0.6, 0), (0, 0, 0.15)),
            airlock,
        ),
        ("Fire", "fire sign", quad((4.1, PORT_Y + 0.006, FLOOR + 1.52), (-0.3, 0, 0), (0, 0, 0.11)), fire),
        ("Kibo", "module sign", quad((3.1, STARBOARD_Y - 0.006, FLOOR + 1.35), (0.6, 0, 0), (0, 0, 0.26)), kibo),
    )
    for name, label, shape, look in plates:
        scene.mesh(f"{scene.thing(f'/World/Signs/{name}', label)}/Plate", shape, look)
