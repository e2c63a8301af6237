"""Wherever a body can stand it has a distance: also where no cell of the grid has room."""

from __future__ import annotations

import math

import numpy as np
import pytest

from foundry.paths import assets_dir
from foundry.worlds.camera.body.collision import Collider
from foundry.worlds.camera.body.navigation import Navigator
from foundry.worlds.camera.body.size import Body
from foundry.worlds.camera.loading.stage import load_scene
from quad_scenes import box, floor, scene, wall

BODY = Body(radius_m=0.25, height_m=1.6, step_m=0.25)
SMALL = Body(radius_m=0.15, height_m=1.0, step_m=0.1)


def alcove(left: float, right: float, *, deep: float = 2.0) -> Collider:
    """A room of 6 x 6 m with a dead end from y = 3 on, between two thin walls, and another room beside it."""
    corners = [(-3, -3), (3, -3), (3, 3 + deep), (-3, 3 + deep), (-3, -3)]
    sides = [wall(a, b, path=f"/side_{i}") for i, (a, b) in enumerate(zip(corners[:-1], corners[1:], strict=True))]
    ends = [wall((left, 3), (left, 3 + deep), path="/left"), wall((right, 3), (right, 3 + deep), path="/right")]
    shut = [wall((-3, 3), (left, 3), path="/shut"), wall((right, 3), (3, 3), path="/shut_too")]
    return Collider(scene(floor(-3, -3, 3, 3 + deep), *sides, *ends, *shut))


def test_a_dead_end_between_two_rows_of_cells_has_the_distance_of_the_way_out():
    """Cells lie at x = 0.25 and x = 0.35: neither has room between the walls, but the body has."""
    nav = Navigator(alcove(0.03, 0.56), BODY)
    foot = nav.collider.move([0.295, 2, 0], 90, 9, BODY, slide=True).foot
    assert foot == pytest.approx([0.295, 4.75, 0], abs=1e-3)
    goal = nav.cell(np.array([0.25, 0.05, 0]))
    assert goal is not None
    field = nav.distance_field(np.array([goal]))
    route = nav.path(foot, field)
    assert nav.distance(foot, field) == pytest.approx(4.7, rel=0.03)
    assert route is not None and route.length_m == pytest.approx(4.7, abs=0.03)
    assert len(nav.reachable(foot)) == len(nav.reachable(np.array([0.0, 0, 0])))


def test_a_cell_on_the_other_side_of_a_wall_is_not_where_the_way_begins():
    nav = Navigator(alcove(0.03, 0.36), SMALL)
    foot = nav.collider.move([0.195, 2, 0], 90, 1.9, SMALL, slide=True).foot
    other_room = nav.distance_field(np.array([nav.cell(np.array([1.5, 4.0, 0]))]))
    assert nav.distance(foot, other_room) == math.inf
    below = nav.distance_field(np.array([nav.cell(np.array([0.15, 0.05, 0]))]))
    assert nav.distance(foot, below) == pytest.approx(3.85, rel=0.03)


def test_who_stands_on_a_pillar_or_in_a_box_gets_nowhere():
    pillar, cage = box("/pillar", (-0.3, -0.3, 0), (0.3, 0.3, 1)), box("/cage", (1.7, 1.7, 0), (2.3, 2.3, 1))
    nav = Navigator(Collider(scene(floor(-3, -3, 3, 3), pillar, cage)), BODY)
    goal = nav.cell(np.array([-2.0, 0, 0]))
    assert goal is not None
    field = nav.distance_field(np.array([goal]))
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
def test_every_place_of_random_walks_has_a_distance(name: str, corners: list[list[float]]):
    nav = Navigator(Collider(load_scene(assets_dir() / f"{name}.usdz")), BODY)
    for seed in range(3):
        feet = walk(nav, 25, seed)
        field = nav.distance_field(np.array([nav.cell(feet[0])]))
        for foot in [*feet, *map(np.array, corners)]:
            straight = math.hypot(*(foot - feet[0])[:2])
            assert straight - 0.5 <= nav.distance(foot, field) < math.inf, foot
            assert nav.cell(foot) is not None


@pytest.mark.exhaustive
@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", ["office", "kibo", "gallery"])
def test_every_place_of_many_random_walks_has_a_distance(name: str):
    nav = Navigator(Collider(load_scene(assets_dir() / f"{name}.usdz")), BODY)
    missing = [foot for seed in range(40) for foot in walk(nav, 50, seed) if nav.cell(foot) is None]
    assert missing == []
