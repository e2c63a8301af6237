"""What stops a body, what it slides along, and what carries it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from foundry.errors import InputError
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.loading.scene import Scene, SceneMesh
from quad_scenes import box, floor, quad, scene, wall

BODY = Body(radius_m=0.25, height_m=1.6, step_m=0.25)
EXACT = 1e-4


def room(*things: SceneMesh) -> Scene:
    """A floor of 8 x 8 m around the origin, with 3 m of headroom in its bounds, and things on it."""
    return scene(floor(-4, -4, 4, 4), *things, wall((-4, -4), (-4, -3.9), high=3.0, path="/post"))


def collider(*things: SceneMesh) -> Collider:
    return Collider(room(*things))


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("length", [0.8, 3.0, 7.9, 1000.0])
def test_a_thin_wall_stops_moves_of_any_length_from_both_sides(length: float, flipped: bool):
    place = collider(wall((1, -2), (1, 2), flipped=flipped))
    there = place.move([0, 0, 0], 0, length, BODY, slide=False)
    assert there.stopped_by == "/wall"
    assert there.foot == pytest.approx([0.75 if length > 0.75 else length, 0, 0], abs=EXACT)
    back = place.move([2, 0, 0], 180, length, BODY, slide=False)
    assert back.foot == pytest.approx([1.25, 0, 0], abs=EXACT)


def test_a_free_move_ends_where_it_was_asked_to_and_a_label_names_what_stopped_another():
    motion = collider().move([0, 0, 0], 90, 1.5, BODY, slide=False)
    assert (motion.stopped_by, motion.travelled_m) == (None, pytest.approx(1.5))
    assert motion.foot == pytest.approx([0, 1.5, 0])
    assert motion.track[0].tolist() == [0, 0, 0]
    mesh = wall((1, -2), (1, 2))
    named = SceneMesh("/wall", points=mesh.points, triangles=mesh.triangles, label="partition")
    assert collider(named).move([0, 0, 0], 0, 3, BODY, slide=False).stopped_by == "partition"


def test_a_sliding_body_keeps_the_part_of_its_motion_along_the_wall_and_stops_in_a_corner_and_head_on():
    motion = collider(wall((1, -4), (1, 4))).move([0, 0, 0], 45, 2.0, BODY, slide=True)
    assert motion.stopped_by == "/wall"
    assert motion.foot == pytest.approx([0.75, math.sqrt(2), 0], abs=EXACT)
    assert motion.travelled_m == pytest.approx(0.75 * math.sqrt(2) + math.sqrt(2) - 0.75, abs=EXACT)
    place = collider(wall((1, -4), (1, 4)), wall((-4, 1), (4, 1), path="/other"))
    motion = place.move([0, 0.3, 0], 45, 5.0, BODY, slide=True)
    assert motion.foot == pytest.approx([0.75, 0.75, 0], abs=EXACT)
    motion = collider(wall((1, -4), (1, 4))).move([0, 0, 0], 0, 5.0, BODY, slide=True)
    assert motion.foot == pytest.approx([0.75, 0, 0], abs=EXACT)


def test_a_sliding_body_goes_round_a_pillar():
    turns = np.linspace(0, math.tau, 25)
    corners = [(2 + 0.4 * math.cos(t), 0.4 * math.sin(t)) for t in turns]
    pillar = [wall(a, b, path="/pillar") for a, b in zip(corners[:-1], corners[1:], strict=True)]
    motion = collider(*pillar).move([0, 0.3, 0], 0, 4.0, BODY, slide=True)
    assert motion.foot[1] == pytest.approx(0.65, abs=0.05)
    assert motion.foot[0] > 3


@pytest.mark.parametrize("turn", [90, -90, 180, 120])
def test_a_body_that_touches_a_wall_can_walk_along_it_and_away(turn: float):
    """The wall is made of many quads, whose corners must not catch."""
    parts = [wall((1, y), (1, y + 0.5), path=f"/part_{y}") for y in np.arange(-4, 4, 0.5)]
    place = collider(*parts)
    touching = place.move([0, 0, 0], 0, 3, BODY, slide=False).foot
    motion = place.move(touching, turn, 2.0, BODY, slide=False)
    assert (motion.stopped_by, motion.travelled_m) == (None, pytest.approx(2.0))


@pytest.mark.parametrize(("gap", "passes"), [(0.48, False), (0.52, True)])
def test_a_gap_lets_a_body_through_that_is_narrower(gap: float, passes: bool):
    place = collider(wall((1, -4), (1, -gap / 2)), wall((1, gap / 2), (1, 4), path="/other"))
    motion = place.move([0, 0, 0], 0, 2.0, BODY, slide=False)
    assert (motion.stopped_by is None) == passes


def test_a_table_and_a_low_ceiling_stop_what_is_taller_and_let_the_small_pass_under():
    table = box("/table", (1, -1, 0.7), (2, 1, 0.75))
    assert collider(table).move([0, 0, 0], 0, 3.0, BODY, slide=False).foot[0] == pytest.approx(0.75, abs=EXACT)
    assert collider(table).move([0, 0, 0], 0, 3.0, Body(0.25, 0.6, 0.1), slide=False).stopped_by is None
    ceiling = quad("/ceiling", [[1, -4, 1.5], [4, -4, 1.5], [4, 4, 1.5], [1, 4, 1.5]])
    motion = collider(ceiling).move([0, 0, 0], 0, 3.0, BODY, slide=False)
    assert (motion.stopped_by, motion.foot[0]) == ("/ceiling", pytest.approx(0.75, abs=EXACT))


@pytest.mark.parametrize(("height", "climbs"), [(0.2, True), (0.25, True), (0.27, False)])
def test_a_body_climbs_steps_up_to_its_step_height_and_comes_down_again(height: float, climbs: bool):
    place = collider(box("/step", (1, -1, 0), (2, 1, height)))
    up = place.move([0, 0, 0], 0, 1.5, BODY, slide=False)
    assert (up.stopped_by is None) == climbs
    if climbs:
        assert up.foot == pytest.approx([1.5, 0, height], abs=EXACT)
        assert place.move(up.foot, 0, 1.5, BODY, slide=False).foot == pytest.approx([3, 0, 0], abs=EXACT)


def test_a_body_climbs_a_staircase_step_by_step():
    stairs = [box(f"/stair_{i}", (1 + 0.3 * i, -1, 0), (4, 1, 0.18 * (i + 1))) for i in range(5)]
    motion = collider(*stairs).move([0, 0, 0], 0, 3.0, BODY, slide=False)
    assert motion.foot == pytest.approx([3, 0, 0.9], abs=EXACT)


def test_a_body_follows_a_slope_up_and_down_unless_it_is_too_steep_or_leads_into_a_ceiling():
    slope = quad("/slope", [[0, -1, 0], [2, -1, 1], [2, 1, 1], [0, 1, 0]])
    place = collider(slope)
    up = place.move([-1, 0, 0], 0, 2.5, BODY, slide=False)
    assert up.foot == pytest.approx([1.5, 0, 0.75], abs=EXACT)
    assert place.move(up.foot, 180, 2.5, BODY, slide=False).foot == pytest.approx([-1, 0, 0], abs=EXACT)
    slope = quad("/slope", [[0, -1, 0], [1, -1, 2], [1, 1, 2], [0, 1, 0]])
    assert collider(slope).move([-1, 0, 0], 0, 2.5, BODY, slide=False).stopped_by == "/slope"
    slope = quad("/slope", [[0, -4, 0], [4, -4, 1], [4, 4, 1], [0, 4, 0]])
    ceiling = quad("/ceiling", [[-4, -4, 2], [4, -4, 2], [4, 4, 2], [-4, 4, 2]])
    motion = collider(slope, ceiling).move([-1, 0, 0], 0, 5.0, BODY, slide=False)
    assert motion.stopped_by == "/ceiling"
    assert 1.5 < motion.foot[0] < 1.6 + 1e-6


def test_a_move_over_the_edge_of_the_floor_stops_there_and_can_go_back():
    island = scene(floor(-1, -1, 1, 1, z=1.0), floor(-3, -3, 3, 3, z=0.0, path="/ground"))
    motion = Collider(island).move([0, 0, 1], 0, 2.0, BODY, slide=True)
    assert (motion.stopped_by, motion.foot[2]) == ("edge", 1.0)
    assert motion.foot[0] == pytest.approx(1.0, abs=1e-3)
    edge = Collider(island).move([0, 0, 1], 30, 2.0, BODY, slide=False).foot
    back = Collider(island).move(edge, 210, 1.0, BODY, slide=False)
    assert (back.stopped_by, back.travelled_m) == (None, pytest.approx(1.0))


@pytest.mark.parametrize(("gap", "crosses"), [(0.01, True), (0.2, True), (0.4, False)])
def test_a_crack_in_the_floor_narrower_than_the_radius_is_walked_over(gap: float, crosses: bool):
    planks = scene(floor(-3, -1, 0, 1), floor(gap, -1, 3, 1, path="/plank"), floor(-3, -1, 3, 1, z=-2, path="/below"))
    motion = Collider(planks).move([-1.01, 0, 0], 0, 2.0, BODY, slide=False)
    assert motion.stopped_by == (None if crosses else "edge")


def test_a_body_never_leaves_the_bounds():
    place = Collider(room(), bounds=np.array([[-1, -2, 0], [1, 2, 2]]))
    stopped = place.move([0, 0, 0], 45, 9.0, BODY, slide=False)
    assert (stopped.stopped_by, stopped.foot) == ("bounds", pytest.approx([1, 1, 0], abs=EXACT))
    slid = place.move([0, 0, 0], 45, 9.0, BODY, slide=True)
    assert (slid.stopped_by, slid.foot) == ("bounds", pytest.approx([1, 2, 0], abs=EXACT))


@pytest.mark.parametrize("rise", [0.2, -0.2])
def test_a_body_neither_climbs_nor_sinks_out_of_the_bounds(rise: float):
    levels = scene(floor(-4, -4, 1, 4), floor(1, -4, 4, 4, z=rise, path="/level"))
    place = Collider(levels, bounds=np.array([[-4, -4, -0.1], [4, 4, 0.1]]))
    motion = place.move([0, 0, 0], 0, 3, BODY, slide=False)
    assert motion.stopped_by == "bounds" and motion.foot[2] == 0


def test_a_fixed_floor_height_needs_no_floor():
    place = Collider(scene(wall((1, -2), (1, 2), low=-2)), floor_height=-1.0, bounds=np.array([[-9] * 3, [9] * 3]))
    motion = place.move([0, 0, 0], 0, 3, BODY, slide=False)
    assert (motion.stopped_by, motion.foot) == ("/wall", pytest.approx([0.75, 0, -1], abs=EXACT))
    assert place.move([0, 0, 0], 180, 3, BODY, slide=False).foot == pytest.approx([-3, 0, -1], abs=EXACT)


def test_a_start_that_overlaps_something_leaves_the_ways_out_open():
    place = collider(wall((1, -2), (1, 2)))
    inside = np.array([0.9, 0.0, 0.0])
    assert place.touching(inside, BODY) == "/wall"
    assert place.move(inside, 0, 1.0, BODY, slide=False).travelled_m == 0
    assert place.move(inside, 180, 1.0, BODY, slide=False).foot == pytest.approx([-0.1, 0, 0])
    assert place.move(inside, 100, 1.0, BODY, slide=False).stopped_by is None
    assert collider(wall((1, -2), (1, 2))).touching(np.array([0.7, 0.0, 0.0]), BODY) is None
    table = quad("/table", [[-3, -3, 0.7], [3, -3, 0.7], [3, 3, 0.7], [-3, 3, 0.7]])
    assert collider(table).touching(np.zeros(3), BODY) == "/table"


def test_the_floor_below_is_the_highest_surface_that_can_be_stood_on_from_there():
    place = collider(box("/table", (1, -1, 0.7), (2, 1, 0.75)))
    assert place.floor_below(np.array([1.5, 0, 2.0]), BODY) == pytest.approx(0.75)
    assert place.floor_below(np.array([1.5, 0, 0.2]), BODY) == pytest.approx(0.0)
    assert place.floor_below(np.array([9.0, 0, 0.2]), BODY) is None


def test_flat_triangles_and_points_that_are_no_numbers_do_no_harm():
    odd = SceneMesh(
        "/odd", np.array([[1, 0, 0], [1, 0, 2.0], [1, 0, 1], [np.nan] * 3]), np.array([[0, 1, 2], [0, 1, 3]])
    )
    place = Collider(scene(floor(-4, -4, 4, 4)), bounds=np.array([[-4, -4, -1], [4, 4, 3]]))
    assert place.move([0, 0, 0], 0, 3, BODY, slide=False).stopped_by is None
    sound = Collider(scene(floor(-4, -4, 4, 4), odd), bounds=np.array([[-4, -4, -1], [4, 4, 3]]))
    assert sound.move([0, 0, 0], 0, 3, BODY, slide=False).foot[0] == pytest.approx(0.75, abs=EXACT)


def test_a_scene_without_surfaces_is_refused():
    nothing = SceneMesh("/points", np.zeros((1, 3)), np.zeros((0, 3), np.int64))
    with pytest.raises(InputError, match="no surface"):
        Collider(scene(nothing))


@pytest.mark.parametrize("sizes", [(0, 1, 0.2), (0.2, 0.2, 0.25), (0.2, 1, -0.1), (0.2, math.inf, 0), (math.nan, 1, 0)])
def test_an_impossible_body_is_refused(sizes: tuple[float, float, float]):
    with pytest.raises(InputError, match="can not move"):
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
