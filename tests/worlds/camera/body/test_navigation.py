"""Where a body can walk, how far it is, and what can be seen from there."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from foundry.errors import InputError
from foundry.seeding import stream
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.navigation import CELL_M, Field, Navigator
from foundry.worlds.camera.body.walkable import find_walkable
from foundry.worlds.camera.loading.scene import SceneMesh
from foundry.worlds.camera.loading.stage import load_scene
from quad_scenes import box, enclosed, floor, quad, scene, wall

BODY = Body(radius_m=0.25, height_m=1.6, step_m=0.25)
SMALL = Body(radius_m=0.15, height_m=1.0, step_m=0.1)
EYE_M = 1.5


def navigator(*things: SceneMesh) -> Navigator:
    return Navigator(Collider(enclosed(*things)), BODY)


def at(x: float, y: float, z: float = 0.0) -> np.ndarray:
    return np.array([x, y, z])


def field_to(nav: Navigator, x: float, y: float, z: float = 0.0) -> Field:
    cell = nav.cell(at(x, y, z))
    assert cell is not None
    return nav.distance_field(np.array([cell]))


def follow(nav: Navigator, points: np.ndarray) -> np.ndarray:
    foot = points[0]
    for point in points[1:]:
        way = point - foot
        turn, length = math.degrees(math.atan2(way[1], way[0])), math.hypot(way[0], way[1])
        foot = nav.collider.move(foot, turn, length, nav.body, slide=False).foot
    return foot


def test_cells_keep_the_body_clear_of_walls_and_a_way_visits_all_that_are_within_reach():
    nav = navigator()
    assert np.abs(nav.places[:, :2]).max() <= 2.75
    assert len(nav.places) == 54**2
    ends = np.array([at(-2.65, 0.05), at(2.65, 0.05)])
    stations = np.array([at(x, 0.05) for x in np.arange(-2.65, 2.7, 0.1)])
    assert len(nav.visited(ends[:1], 0.0)) == 1
    assert nav.visited(ends, 0.0).tolist() == nav.visited(stations, 0.0).tolist()
    assert len(nav.visited(ends, 0.0)) == 54
    assert 0.3 < len(nav.visited(ends, 1.0)) / len(nav.places) < 0.45


def test_distances_over_open_floor_are_straight_lines():
    nav = navigator()
    for x, y in [(2.05, 0.05), (2.05, 2.05), (2.05, 1.05), (1.05, 2.55), (-2.05, -0.75)]:
        field, straight = field_to(nav, x, y), math.hypot(x + 0.05, y + 0.05)
        assert nav.distance(at(-0.05, -0.05), field) == pytest.approx(straight, rel=0.03)
        route = nav.path(at(-0.05, -0.05), field)
        assert len(route.points) == 2
        assert route.length_m == pytest.approx(straight, rel=1e-6)


def test_the_way_round_a_wall_is_hardly_longer_than_the_shortest_there_is():
    """Two tangents and an arc around the end of the wall at (0, 1)."""
    nav = navigator(wall((0, -3), (0, 1)))
    reach = math.hypot(1.95, 1.05)
    tangent = math.sqrt(reach**2 - BODY.radius_m**2)
    side = math.atan2(1.95, 1.05)
    shortest = 2 * tangent + BODY.radius_m * (math.tau - 2 * side - 2 * math.acos(BODY.radius_m / reach))
    field = field_to(nav, 1.95, -0.05)
    route = nav.path(at(-1.95, -0.05), field)
    assert shortest <= route.length_m + 1e-6
    assert route.length_m <= 1.025 * shortest
    assert route.length_m <= nav.distance(at(-1.95, -0.05), field) <= 1.035 * shortest
    assert follow(nav, route.points) == pytest.approx(route.points[-1], abs=1e-3)


@pytest.mark.parametrize(("gap", "reachable"), [(0.4, False), (0.9, True)])
def test_a_gap_joins_two_rooms_if_the_body_fits(gap: float, reachable: bool):
    nav = navigator(wall((0, -3), (0, -gap / 2)), wall((0, gap / 2), (0, 3), path="/other"))
    field = field_to(nav, 2, 0)
    assert math.isfinite(nav.distance(at(-2, 0), field)) == reachable
    assert (nav.path(at(-2, 0), field) is not None) == reachable
    assert len(nav.reachable(at(-2, 0))) == pytest.approx(len(nav.places) / (1 if reachable else 2), rel=0.01)


@pytest.mark.parametrize(("rise", "reachable"), [(0.2, True), (0.5, False)])
def test_ways_climb_steps_but_no_ledges(rise: float, reachable: bool):
    nav = navigator(box("/stage", (1, -3, 0), (3, 3, rise)))
    field = field_to(nav, 2, 0, rise)
    route = nav.path(at(-2, 0), field)
    assert (route is not None) == reachable
    if route is not None:
        assert route.length_m == pytest.approx(4.05, abs=0.1)
        assert follow(nav, route.points)[2] == pytest.approx(rise)


def test_no_step_of_the_grid_leads_through_what_stands_beside_it():
    """The post is a quarter of the way along a knight's move, and just within the body's radius of it."""
    x, y = 0.1 - 0.247 / math.sqrt(5), 0.075 + 2 * 0.247 / math.sqrt(5)
    collider = Collider(enclosed(box("/post", (x - 1e-4, y - 1e-4, 0), (x + 1e-4, y + 1e-4, 2))))
    walkable = find_walkable(collider.ground, collider.bounds, BODY, CELL_M)
    near = [(one, other) for one, other in walkable.places[walkable.edges] if np.hypot(*(one[:2] - (x, y))) < 0.5]
    assert len(near) > 50 and all(collider.walkable(one, other, BODY) for one, other in near)


def test_a_fixed_floor_height_makes_one_level():
    place = scene(wall((0, -3), (0, 1), low=-2), box("/shelf", (1, 1, 0.5), (2, 2, 0.6)))
    bounds = np.array([[-3, -3, -2], [3, 3, 3]])
    nav = Navigator(Collider(place, floor_height=-0.5, bounds=bounds), BODY)
    assert set(nav.places[:, 2]) == {-0.5}
    assert nav.cell(at(1.5, 1.5, -0.5)) is None
    assert nav.distance(at(-1, 0, -0.5), field_to(nav, 1, 0, -0.5)) > 2.5


def test_the_gap_to_a_target_is_seen_from_above():
    nav = navigator(box("/lamp", (1, -0.5, 2.0), (2, 0.5, 2.2)), box("/lamp/cord", (1.4, 0.8, 2.2), (1.5, 0.9, 2.5)))
    target = nav.target(["/lamp"])
    assert target.gap(at(0, 0)) == pytest.approx(1.0)
    assert target.gap(at(1.5, 0)) == 0
    assert target.gap(at(1.45, 1.9)) == pytest.approx(1.0)


def test_goals_are_cells_near_the_target_that_see_it():
    nav = navigator(box("/vase", (0.5, -0.2, 0), (0.8, 0.2, 0.5)), wall((0.2, -3), (0.2, 3)))
    goals = nav.places[nav.goal_cells(nav.target(["/vase"]), 1.0, EYE_M)]
    assert len(goals)
    assert goals[:, 0].min() > 0.2
    assert np.hypot(np.maximum(goals[:, 0] - 0.8, 0), np.maximum(np.abs(goals[:, 1]) - 0.2, 0)).max() <= 1.0


def test_walls_hide_and_neither_glass_nor_the_wall_behind_a_picture_does():
    vase, glass = box("/vase", (1, -0.2, 0), (1.3, 0.2, 0.5)), wall((0.2, -3), (0.2, 3), opacity=0.2)
    picture = quad("/picture", [[3, -0.5, 1], [3, 0.5, 1], [3, 0.5, 2], [3, -0.5, 2]])
    for shown, hiding, seen in ((vase, [wall((0.2, -3), (0.2, 3))], False), (vase, [glass], True), (picture, [], True)):
        nav = navigator(shown, *hiding)
        assert nav.line_of_sight(at(-1, 0, EYE_M), nav.target([shown.path])) == seen


def test_cells_over_a_wide_carpet_are_near_it():
    nav = navigator(floor(-2.5, -2.5, 2.5, 2.5, z=0.01, path="/carpet"))
    carpet = nav.target(["/carpet"])
    near = carpet.is_near(nav.places, 0.3)
    assert near.tolist() == [carpet.gap(place) <= 0.3 for place in nav.places]
    assert near.all()


def test_a_target_that_does_not_exist_is_refused_and_one_that_can_not_be_reached_is_infinitely_far():
    with pytest.raises(InputError, match=r"Prim '/vaze' not found. Did you mean '/vase'\?"):
        navigator(box("/vase", (1, 0, 0), (2, 1, 1))).target(["/vaze"])
    nav = navigator(box("/vase", (1, 0, 0), (1.2, 0.2, 1)))
    field = nav.distance_field(np.empty(0, np.int64))
    assert nav.distance(at(0, 0), field) == math.inf
    assert nav.path(at(0, 0), field) is None


def test_a_foot_at_the_goal_has_no_way_to_go_and_one_far_from_every_cell_no_distance():
    nav = navigator()
    field = nav.distance_field(nav.visited(np.array([at(1, 1)]), 0.5))
    route = nav.path(at(1.02, 1.01), field)
    assert nav.distance(at(1.02, 1.01), field) == 0
    assert route.length_m == 0
    assert nav.distance(at(9, 9), field_to(nav, 0, 0)) == math.inf
    assert nav.reachable(at(9, 9)).size == 0


def test_cells_are_kept_on_disk_and_read_back_the_same(tmp_path: Path):
    collider = Collider(enclosed(box("/table", (0, 0, 0.6), (1, 1, 0.7))))
    first = Navigator(collider, BODY, cache=tmp_path / "cache")
    (path,) = (tmp_path / "cache").iterdir()
    stamp = path.stat().st_mtime_ns
    second = Navigator(collider, BODY, cache=tmp_path / "cache")
    assert path.stat().st_mtime_ns == stamp
    assert second.places.tolist() == first.places.tolist()
    goal = np.array([0])
    assert second.distance_field(goal).distance.tolist() == first.distance_field(goal).distance.tolist()
    Navigator(collider, Body(0.3, 1.6, 0.25), cache=tmp_path / "cache")
    moved = Navigator(Collider(enclosed(box("/table", (-2, 0, 0.6), (-1, 1, 0.7)))), BODY, cache=tmp_path / "cache")
    assert len(list((tmp_path / "cache").iterdir())) == 3 and moved.places.tolist() != first.places.tolist()


def test_a_damaged_file_is_built_again(tmp_path: Path):
    collider = Collider(scene(floor(-1, -1, 1, 1), wall((-1, -1), (-1, 1))))
    first = Navigator(collider, BODY, cache=tmp_path)
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    for damage in (b"", b"not a zip", whole[: len(whole) // 2] + b"?" + whole[len(whole) // 2 + 1 :]):
        path.write_bytes(damage)
        assert Navigator(collider, BODY, cache=tmp_path).places.tolist() == first.places.tolist()
        assert [path.name for path in tmp_path.iterdir()] == [path.name]
        assert path.read_bytes() == whole


def test_a_random_foot_stands_free_inside_its_region_and_repeats_with_its_seed():
    nav = navigator(wall((0, -3), (0, 2)))
    region = np.array([[-2.5, -2.5], [0.5, 0.5]])
    feet = [nav.random_foot(stream(seed, "start"), region, clearance_m=0.4) for seed in range(40)]
    for foot in feet:
        assert (foot[:2] >= region[0]).all() and (foot[:2] <= region[1]).all() and abs(foot[0]) >= 0.4
    assert len({tuple(foot) for foot in feet}) > 30
    assert nav.random_foot(stream(3, "start"), region, clearance_m=0.4).tolist() == feet[3].tolist()


def test_a_random_foot_is_on_the_floor_and_not_on_the_roof_and_may_need_a_way_to_the_target():
    nav = navigator(box("/roof", (-3, -3, 2.5), (3, 3, 2.6)), box("/table", (0, 0, 1.1), (2, 2, 1.2)))
    assert set(nav.places[:, 2]) == {0, 2.6}
    everywhere = np.array([[-3.0, -3.0], [3.0, 3.0]])
    assert {nav.random_foot(stream(seed, "start"), everywhere)[2] for seed in range(20)} == {0}
    upstairs = np.array([[-3.0, -3.0, 2.0], [3.0, 3.0, 3.0]])
    assert nav.random_foot(stream(0, "start"), upstairs)[2] == 2.6
    nav = navigator(wall((0, -3), (0, 3)))
    everywhere = np.array([[-3.0, -3.0], [3.0, 3.0]])
    field = field_to(nav, 2, 0)
    assert all(nav.random_foot(stream(seed, "start"), everywhere, field=field)[0] > 0 for seed in range(20))


def test_regions_and_scenes_without_room_and_bounds_with_too_many_cells_are_refused():
    with pytest.raises(InputError, match="has no place to start"):
        navigator().random_foot(stream(0, "start"), np.array([[2.8, 2.8], [3.0, 3.0]]))
    low = enclosed(quad("/ceiling", [[-3, -3, 1], [3, -3, 1], [3, 3, 1], [-3, 3, 1]]))
    with pytest.raises(InputError, match="No floor within the bounds"):
        Navigator(Collider(low, bounds=np.array([[-3, -3, 0], [3, 3, 0.5]])), BODY)
    collider = Collider(enclosed(), bounds=np.array([[-500, -500, 0], [500, 500, 3]]))
    with pytest.raises(
        InputError, match=r"1,000 x 1,000 m, but at most 200 x 200 m.*Set world\.bounds=.*world\.scene\.exclude"
    ):
        Navigator(collider, BODY)


def alcove(left: float, right: float) -> Collider:
    """A room of 3 x 4 m with a dead end from y = 3 on, between two thin walls, and another room beside it."""
    corners = [(-1, -1), (2, -1), (2, 5), (-1, 5), (-1, -1)]
    sides = [wall(a, b, path=f"/side_{i}") for i, (a, b) in enumerate(pairwise(corners))]
    ends = [wall((left, 3), (left, 5), path="/left"), wall((right, 3), (right, 5), path="/right")]
    shut = [wall((-1, 3), (left, 3), path="/shut"), wall((right, 3), (2, 3), path="/shut_too")]
    return Collider(scene(floor(-1, -1, 2, 5), *sides, *ends, *shut))


def test_a_dead_end_between_two_rows_of_cells_has_the_distance_of_the_way_out():
    """Cells lie at x = 0.25 and x = 0.35: neither has room between the walls, but the body has."""
    nav = Navigator(alcove(0.03, 0.56), BODY)
    foot = nav.collider.move([0.295, 2, 0], 90, 9, BODY, slide=True).foot
    assert foot == pytest.approx([0.295, 4.75, 0], abs=1e-3)
    field = field_to(nav, 0.25, 0.05)
    route = nav.path(foot, field)
    assert nav.distance(foot, field) == pytest.approx(4.7, rel=0.03)
    assert route.length_m == pytest.approx(4.7, abs=0.03)
    assert len(nav.reachable(foot)) == len(nav.reachable(np.array([0.0, 0, 0])))


def test_a_cell_on_the_other_side_of_a_wall_is_not_where_the_way_begins():
    nav = Navigator(alcove(0.03, 0.36), SMALL)
    foot = nav.collider.move([0.195, 2, 0], 90, 1.9, SMALL, slide=True).foot
    assert nav.distance(foot, field_to(nav, 1.5, 4)) == math.inf
    assert nav.distance(foot, field_to(nav, 0.15, 0.05)) == pytest.approx(3.85, rel=0.03)


def test_who_stands_on_a_pillar_or_in_a_box_gets_nowhere():
    pillar, cage = box("/pillar", (-0.3, -0.3, 0), (0.3, 0.3, 1)), box("/cage", (1.7, 1.7, 0), (2.3, 2.3, 1))
    nav = Navigator(Collider(scene(floor(-2.5, -0.5, 2.5, 2.5), pillar, cage)), BODY)
    field = field_to(nav, -2, 0)
    assert nav.distance(np.array([0.0, 0, 1]), field) == math.inf
    assert nav.distance(np.array([2.0, 2, 0]), field) == math.inf


def walk(nav: Navigator, moves: int, seed: int) -> list[np.ndarray]:
    rng, feet = np.random.default_rng(seed), []
    foot = nav.random_foot(rng, nav.collider.bounds[:, :2], clearance_m=0.35)
    for _ in range(moves):
        motion = nav.collider.move(foot, rng.uniform(0, 360), rng.uniform(0, 3), BODY, slide=True)
        foot = np.round(motion.foot, 9)
        feet.append(foot)
    return feet


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "corners"), [("office", [[8.3, 9.75, 0.0], [8.27, 9.704, 0.0]]), ("kibo", []), ("gallery", [])]
)
def test_every_place_of_a_random_walk_has_a_distance_and_a_way_that_can_be_walked(
    name: str, corners: list[list[float]]
):
    nav = Navigator(Collider(load_scene(f"{name}.usdz")), BODY)
    feet = walk(nav, 20, seed=0)
    field = field_to(nav, *feet[0])
    for foot in [*feet, *map(np.array, corners)]:
        straight = math.hypot(*(foot - feet[0])[:2])
        assert straight - 0.5 <= nav.distance(foot, field) < math.inf, foot
        assert nav.cell(foot) is not None
    route = nav.path(feet[-1], field)
    assert route.length_m <= nav.distance(feet[-1], field) + 1e-6
    assert follow(nav, route.points) == pytest.approx(route.points[-1], abs=1e-3)
