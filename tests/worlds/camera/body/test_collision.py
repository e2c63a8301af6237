"""What stops a body, what it slides along, and what carries it; wherever it goes, it keeps clear of everything."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.errors import InputError
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.surfaces import Surfaces
from foundry.worlds.camera.loading.scene import FloatArray, Scene, SceneMesh
from quad_scenes import box, enclosed, floor, quad, scene, wall

BODY = Body(radius_m=0.25, height_m=1.6, step_m=0.25)
EXACT, TOLERANCE_M = 1e-4, 2e-3


def room(*things: SceneMesh) -> Scene:
    """A floor of 8 x 8 m around the origin, with 3 m of headroom in its bounds, and things on it."""
    return scene(floor(-4, -4, 4, 4), *things, wall((-4, -4), (-4, -3.9), high=3.0, path="/post"))


def collider(*things: SceneMesh) -> Collider:
    return Collider(room(*things))


WALL, ACROSS = wall((1, -4), (1, 4)), wall((-4, 1), (4, 1), path="/across")
TABLE = box("/table", (1, -1, 0.7), (2, 1, 0.75))
LOW = quad("/ceiling", [[1, -4, 1.5], [4, -4, 1.5], [4, 4, 1.5], [1, 4, 1.5]])
STAIRS = [box(f"/stair_{i}", (1 + 0.3 * i, -1, 0), (4, 1, 0.18 * (i + 1))) for i in range(5)]
SLOPE = quad("/slope", [[0, -1, 0], [2, -1, 1], [2, 1, 1], [0, 1, 0]])
STEEP = quad("/steep", [[0, -1, 0], [1, -1, 2], [1, 1, 2], [0, 1, 0]])
OPEN = (0.0, 0.0, 0.0)


def island() -> Collider:
    return Collider(scene(floor(-1, -1, 1, 1, z=1.0), floor(-3, -3, 3, 3, z=0.0, path="/ground")))


def test_a_move_ends_where_it_must():
    narrow = Collider(room(), bounds=np.array([[-1, -2, 0], [1, 2, 2]]))
    fixed = Collider(scene(wall((1, -2), (1, 2), low=-2)), floor_height=-1.0, bounds=np.array([[-9] * 3, [9] * 3]))
    along = 0.75 * math.sqrt(2) + math.sqrt(2) - 0.75
    moves = {
        "a free move ends where it was asked to": (collider(), OPEN, 90, 1.5, False, None, (0, 1.5, 0), 1.5),
        "a sliding body keeps its part": (collider(WALL), OPEN, 45, 2, True, "/wall", (0.75, math.sqrt(2), 0), along),
        "it stops in a corner": (collider(WALL, ACROSS), (0, 0.3, 0), 45, 5, True, "/across", (0.75, 0.75, 0), None),
        "it stops head on": (collider(WALL), OPEN, 0, 5, True, "/wall", (0.75, 0, 0), 0.75),
        "a table stops": (collider(TABLE), OPEN, 0, 3, False, "/table", (0.75, 0, 0), 0.75),
        "a low ceiling stops": (collider(LOW), OPEN, 0, 3, False, "/ceiling", (0.75, 0, 0), 0.75),
        "stairs carry": (collider(*STAIRS), OPEN, 0, 3, False, None, (3, 0, 0.9), None),
        "a slope carries up": (collider(SLOPE), (-1, 0, 0), 0, 2.5, False, None, (1.5, 0, 0.75), 2.5),
        "a slope carries down": (collider(SLOPE), (1.5, 0, 0.75), 180, 2.5, False, None, (-1, 0, 0), 2.5),
        "a steep slope stops": (collider(STEEP), (-1, 0, 0), 0, 2.5, False, "/steep", (-0.1245, 0, 0), None),
        "an edge stops": (island(), (0, 0, 1), 0, 2, True, "edge", (0.9997, 0, 1), None),
        "bounds stop": (narrow, OPEN, 45, 9, False, "bounds", (1, 1, 0), math.sqrt(2)),
        "a body slides along bounds": (narrow, OPEN, 45, 9, True, "bounds", (1, 2, 0), None),
        "a fixed height needs no floor": (fixed, OPEN, 180, 3, False, None, (-3, 0, -1), 3),
        "a fixed height does not lead through walls": (fixed, OPEN, 0, 3, False, "/wall", (0.75, 0, -1), 0.75),
    }
    for case, (place, start, turn, length, slide, stopped_by, foot, travelled) in moves.items():
        motion = place.move(start, turn, length, BODY, slide=slide)
        assert motion.stopped_by == stopped_by, case
        assert motion.foot == pytest.approx(foot, abs=1e-3 if stopped_by == "edge" else EXACT), case
        assert travelled is None or motion.travelled_m == pytest.approx(travelled, abs=EXACT), case
        assert motion.track[0, :2].tolist() == list(start[:2]), case


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("length", [0.8, 3.0, 7.9, 1000.0])
def test_a_thin_wall_stops_moves_of_any_length_from_both_sides(length: float, flipped: bool):
    mesh = wall((1, -2), (1, 2), flipped=flipped)
    place = collider(SceneMesh("/wall", points=mesh.points, triangles=mesh.triangles, label="partition"))
    there = place.move(OPEN, 0, length, BODY, slide=False)
    assert there.stopped_by == "partition"
    assert there.foot == pytest.approx([0.75, 0, 0], abs=EXACT)
    back = place.move([2, 0, 0], 180, length, BODY, slide=False)
    assert back.foot == pytest.approx([1.25, 0, 0], abs=EXACT)


@pytest.mark.parametrize("turn", [90, -90, 180, 120])
def test_a_body_that_touches_a_wall_of_many_parts_or_an_edge_can_walk_along_it_and_away(turn: float):
    place = collider(*(wall((1, y), (1, y + 0.5), path=f"/part_{y}") for y in np.arange(-4, 4, 0.5)))
    touching = place.move(OPEN, 0, 3, BODY, slide=False).foot
    motion = place.move(touching, turn, 2.0, BODY, slide=False)
    assert (motion.stopped_by, motion.travelled_m) == (None, pytest.approx(2.0))
    place = island()
    edge = place.move([0, 0, 1], 30, 2.0, BODY, slide=False).foot
    back = place.move(edge, 210, 1.0, BODY, slide=False)
    assert (back.stopped_by, back.travelled_m) == (None, pytest.approx(1.0))


@pytest.mark.parametrize(("gap", "passes"), [(0.48, False), (0.52, True)])
def test_a_gap_lets_a_body_through_that_is_narrower_and_a_table_one_that_is_lower(gap: float, passes: bool):
    place = collider(wall((1, -4), (1, -gap / 2)), wall((1, gap / 2), (1, 4), path="/other"))
    motion = place.move(OPEN, 0, 2.0, BODY, slide=False)
    assert (motion.stopped_by is None) == passes
    assert collider(TABLE).move(OPEN, 0, 3.0, Body(0.25, 0.6, 0.1), slide=False).stopped_by is None


@pytest.mark.parametrize(("height", "climbs"), [(0.2, True), (0.25, True), (0.27, False)])
def test_a_body_climbs_steps_up_to_its_step_height_and_comes_down_again(height: float, climbs: bool):
    place = collider(box("/step", (1, -1, 0), (2, 1, height)))
    up = place.move(OPEN, 0, 1.5, BODY, slide=False)
    assert (up.stopped_by is None) == climbs
    if climbs:
        assert up.foot == pytest.approx([1.5, 0, height], abs=EXACT)
        assert place.move(up.foot, 0, 1.5, BODY, slide=False).foot == pytest.approx([3, 0, 0], abs=EXACT)


@pytest.mark.parametrize(("gap", "crosses"), [(0.01, True), (0.2, True), (0.4, False)])
def test_a_crack_in_the_floor_narrower_than_the_radius_is_walked_over(gap: float, crosses: bool):
    planks = scene(floor(-3, -1, 0, 1), floor(gap, -1, 3, 1, path="/plank"), floor(-3, -1, 3, 1, z=-2, path="/below"))
    motion = Collider(planks).move([-1.01, 0, 0], 0, 2.0, BODY, slide=False)
    assert motion.stopped_by == (None if crosses else "edge")


@pytest.mark.parametrize("rise", [0.2, -0.2])
def test_a_body_neither_climbs_nor_sinks_out_of_the_bounds(rise: float):
    levels = scene(floor(-4, -4, 1, 4), floor(1, -4, 4, 4, z=rise, path="/level"))
    place = Collider(levels, bounds=np.array([[-4, -4, -0.1], [4, 4, 0.1]]))
    motion = place.move(OPEN, 0, 3, BODY, slide=False)
    assert motion.stopped_by == "bounds" and motion.foot[2] == 0


def test_a_start_that_overlaps_something_leaves_the_ways_out_open():
    place = collider(wall((1, -2), (1, 2)))
    inside = np.array([0.9, 0.0, 0.0])
    assert place.touching(inside, BODY) == "/wall"
    assert place.move(inside, 0, 1.0, BODY, slide=False).travelled_m == 0
    assert place.move(inside, 180, 1.0, BODY, slide=False).foot == pytest.approx([-0.1, 0, 0])
    assert place.move(inside, 100, 1.0, BODY, slide=False).stopped_by is None
    assert place.touching(np.array([0.7, 0.0, 0.0]), BODY) is None
    table = quad("/table", [[-3, -3, 0.7], [3, -3, 0.7], [3, 3, 0.7], [-3, 3, 0.7]])
    assert collider(table).touching(np.zeros(3), BODY) == "/table"


def test_the_floor_below_is_the_highest_surface_that_can_be_stood_on_from_there():
    place = collider(TABLE)
    heights = [place.floor_below(np.array(foot), BODY) for foot in ((1.5, 0, 2.0), (1.5, 0, 0.2), (9.0, 0, 0.2))]
    assert heights == [pytest.approx(0.75), pytest.approx(0.0), None]


def test_flat_triangles_and_points_that_are_no_numbers_do_no_harm_but_no_surface_at_all_is_refused():
    points, bounds = [[1, 0, 0], [1, 0, 2.0], [1, 0, 1], [np.nan] * 3], np.array([[-4, -4, -1], [4, 4, 3]])
    odd = SceneMesh("/odd", np.array(points), np.array([[0, 1, 2], [0, 1, 3]]))
    sound = Collider(scene(floor(-4, -4, 4, 4), odd), bounds=bounds)
    assert sound.move(OPEN, 0, 3, BODY, slide=False).foot[0] == pytest.approx(0.75, abs=EXACT)
    nothing = SceneMesh("/points", np.zeros((1, 3)), np.zeros((0, 3), np.int64))
    with pytest.raises(InputError, match="no surface"):
        Collider(scene(nothing))


@pytest.mark.parametrize("sizes", [(0, 1, 0.2), (0.2, 0.2, 0.25), (0.2, 1, -0.1), (0.2, math.inf, 0), (math.nan, 1, 0)])
def test_an_impossible_body_is_refused(sizes: tuple[float, float, float]):
    with pytest.raises(InputError, match="cannot move"):
        Body(*sizes)


@pytest.mark.parametrize("bend", [15.0, 25.0, 40.0])
@pytest.mark.parametrize("downwards", [2.0, 6.0, 12.0])
def test_a_body_in_the_bend_of_a_wall_slides_on_along_the_part_that_leads_away(bend: float, downwards: float):
    """It touches both parts: along the nearer to the wish it would run into the other, along the other it is free."""
    slope = math.radians(bend)
    end = (3 * math.cos(slope), 3 * math.sin(slope))
    place = collider(wall((-3, 0), (0, 0), path="/level"), wall((0, 0), end, path="/rising"))
    settled = place.move([-2, 1, 0], 270, 3.0, BODY, slide=False).foot
    in_bend = place.move(settled, 0, 9.0, BODY, slide=False)
    assert in_bend.stopped_by == "/rising"
    on = place.move(in_bend.foot, -downwards, 1.0, BODY, slide=True)
    way = (on.foot - in_bend.foot)[:2]
    assert on.travelled_m == pytest.approx(math.cos(slope + math.radians(downwards)), abs=1e-3)
    assert math.degrees(math.atan2(way[1], way[0])) == pytest.approx(bend, abs=0.1)


place = st.floats(-2.8, 2.8)
turns = st.one_of(st.sampled_from([0.0, 45.0, 90.0, 180.0, 270.0]), st.floats(0, 360))
moves = st.lists(st.tuples(turns, st.floats(0, 7), st.booleans()), min_size=1, max_size=8)


@st.composite
def obstacles(draw: st.DrawFn) -> list[SceneMesh]:
    """Thin walls of both windings, boxes from steps to pillars, tables, low ceilings and slopes."""
    things: list[SceneMesh] = []
    for number in range(draw(st.integers(1, 6))):
        x, y, turn = draw(place), draw(place), draw(turns)
        size = draw(st.floats(0.05, 2))
        end = (x + size * math.cos(math.radians(turn)), y + size * math.sin(math.radians(turn)))
        low, high = sorted((draw(st.floats(0, 2)), draw(st.floats(0.05, 2))))
        path = f"/thing_{number}"
        kind = draw(st.sampled_from(["wall", "box", "slope"]))
        if kind == "wall":
            things.append(wall((x, y), end, low, high, path, flipped=draw(st.booleans())))
        elif kind == "box":
            things.append(box(path, (x, y, low), (x + size, y + 0.6, high)))
        else:
            things.append(quad(path, [[x, y, 0], [x + size, y, high], [x + size, y + 1, high], [x, y + 1, 0]]))
    return things


def sampled(corners: FloatArray, spacing: float = 0.03) -> FloatArray:
    """Return (n, 3) points all over (m, 3, 3) triangles, a spacing apart."""
    points = [np.empty((0, 3))]
    for a, b, c in corners:
        steps = max(int(np.ceil(max(np.linalg.norm(b - a), np.linalg.norm(c - a)) / spacing)), 1)
        u, v = np.meshgrid(np.linspace(0, 1, steps + 1), np.linspace(0, 1, steps + 1))
        u, v = u[u + v <= 1 + 1e-9], v[u + v <= 1 + 1e-9]
        points.append(a + u[:, None] * (b - a) + v[:, None] * (c - a))
    return np.concatenate(points)


def is_clear(corners: FloatArray, track: FloatArray, body: Body) -> bool:
    """Tell whether the axis of the capsule keeps its radius from (n, 3, 3) triangles above its step height.

    The distance is measured by code of its own, which shares nothing with the collider.
    """
    low, high = track.min(axis=0) - body.radius_m, track.max(axis=0) + (body.radius_m, body.radius_m, body.height_m)
    near = ((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1)
    surface = sampled(corners[near])
    surface = surface[((surface >= low) & (surface <= high)).all(axis=1)]
    places = [np.linspace(a, b, max(int(np.linalg.norm(b - a) / 0.05), 1) + 1) for a, b in pairwise(track)]
    nearest = np.inf
    for foot in np.concatenate([track[-1:], *places]):
        able = surface[surface[:, 2] > foot[2] + body.step_m + 0.002]
        low_end, high_end = foot[2] + body.radius_m, foot[2] + body.height_m - body.radius_m
        axis = np.clip(able[:, 2], low_end, max(low_end, high_end))
        gaps = np.sqrt(((able[:, :2] - foot[:2]) ** 2).sum(axis=1) + (able[:, 2] - axis) ** 2)
        nearest = min(nearest, gaps.min(initial=np.inf))
    return bool(nearest > body.radius_m - TOLERANCE_M)


def places_with_room(world: Collider) -> list[np.ndarray]:
    """Return places with room on the lowest floors, spread over the scene by a fixed sequence."""
    low, high = world.scene.bounds
    feet = []
    for x, y in np.random.default_rng(7).uniform(low[:2], high[:2], (100, 2)):
        floor_z = world.floor_below(np.array([x, y, low[2] + 1.2]), BODY)
        foot = np.array([x, y, np.nan if floor_z is None else floor_z])
        if floor_z is not None and world.touching(foot, BODY) is None:
            feet.append(foot)
    return feet


@pytest.mark.slow
@given(obstacles(), moves, st.integers(0, 1000))
@settings(max_examples=4)
def test_a_walk_among_random_obstacles_keeps_clear_and_comes_no_less_far_when_it_slides(things, walk, start):
    world = Collider(enclosed(*things))
    corners, spots = Surfaces(world.scene).corners, [one for one in places_with_room(world) if one[2] == 0]
    if not spots:
        return
    foot = spots[start % len(spots)]
    for direction, distance, slide in walk:
        stopped, slid = (world.move(foot, direction, distance, BODY, slide=slide) for slide in (False, True))
        assert stopped.travelled_m - 1e-9 <= slid.travelled_m <= distance + 1e-6
        assert slid.stopped_by == stopped.stopped_by
        motion = slid if slide else stopped
        assert is_clear(corners, motion.track, BODY)
        assert (np.abs(motion.foot[:2]) <= 3 - BODY.radius_m + 1e-6).all()
        assert world.move(foot, direction, distance, BODY, slide=slide).track.tolist() == motion.track.tolist()
        foot = motion.foot
