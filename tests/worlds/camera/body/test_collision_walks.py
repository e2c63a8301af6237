"""Random walks: wherever the body goes, it keeps its distance, its floor and its bounds.

The distance is measured by code of its own, which shares nothing with the collider.
"""

from __future__ import annotations

import itertools
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.paths import assets_dir
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.surfaces import Surfaces
from foundry.worlds.camera.loading.scene import FloatArray, Scene, SceneMesh
from foundry.worlds.camera.loading.stage import load_scene
from quad_scenes import box, floor, quad, scene, wall

BODY = Body(radius_m=0.25, height_m=1.6, step_m=0.25)
TOLERANCE_M = 2e-3
ASSETS = sorted(assets_dir().glob("*.usd*"))

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


def enclosed(*things: SceneMesh) -> Scene:
    corners = [(-3, -3), (3, -3), (3, 3), (-3, 3), (-3, -3)]
    walls = [wall(a, b, path=f"/side_{a}") for a, b in zip(corners[:-1], corners[1:], strict=True)]
    return scene(floor(-3, -3, 3, 3), *walls, *things)


def open_places(world: Collider, body: Body) -> list[np.ndarray]:
    spots = [np.array([x, y, 0.0]) for x in np.linspace(-2.7, 2.7, 7) for y in np.linspace(-2.7, 2.7, 7)]
    return [spot for spot in spots if world.touching(spot, body) is None and world.floor_below(spot, body) == 0]


SAMPLE_M = 0.03


def sampled(place: Scene, spacing: float = SAMPLE_M) -> FloatArray:
    """Return (n, 3) points all over the surfaces, a spacing apart."""
    points = []
    for mesh in place.meshes:
        for a, b, c in mesh.points[mesh.triangles]:
            steps = max(int(np.ceil(max(np.linalg.norm(b - a), np.linalg.norm(c - a)) / spacing)), 1)
            u, v = np.meshgrid(np.linspace(0, 1, steps + 1), np.linspace(0, 1, steps + 1))
            u, v = u[u + v <= 1 + 1e-9], v[u + v <= 1 + 1e-9]
            points.append(a + u[:, None] * (b - a) + v[:, None] * (c - a))
    return np.concatenate(points)


def closest(surface: FloatArray, track: FloatArray, body: Body) -> float:
    """Return how near the axis of the capsule comes to (n, 3) points above its step height, metres."""
    low, high = track.min(axis=0) - body.radius_m, track.max(axis=0) + body.height_m
    surface = surface[((surface >= low) & (surface <= np.append(high[:2] + body.radius_m, high[2]))).all(axis=1)]
    places = [np.linspace(a, b, max(int(np.linalg.norm(b - a) / 0.05), 1) + 1) for a, b in pairwise(track)]
    nearest = np.inf
    for foot in np.concatenate([track[-1:], *places]):
        able = surface[surface[:, 2] > foot[2] + body.step_m + 0.002]
        low_end, high_end = foot[2] + body.radius_m, foot[2] + body.height_m - body.radius_m
        axis = np.clip(able[:, 2], low_end, max(low_end, high_end))
        gaps = np.sqrt(((able[:, :2] - foot[:2]) ** 2).sum(axis=1) + (able[:, 2] - axis) ** 2)
        nearest = min(nearest, gaps.min(initial=np.inf))
    return float(nearest)


@pytest.mark.slow
@given(obstacles(), moves, st.integers(0, 1000))
@settings(max_examples=4)
def test_a_walk_among_random_obstacles_keeps_the_body_clear_of_them(things, walk, start):
    world = Collider(enclosed(*things))
    spots = open_places(world, BODY)
    if not spots:
        return
    surface, foot = sampled(world.scene), spots[start % len(spots)]
    for direction, distance, slide in walk:
        motion = world.move(foot, direction, distance, BODY, slide=slide)
        assert motion.travelled_m <= distance + 1e-6
        assert closest(surface, motion.track, BODY) > BODY.radius_m - TOLERANCE_M
        assert (np.abs(motion.foot[:2]) <= 3 - BODY.radius_m + 1e-6).all()
        assert world.move(foot, direction, distance, BODY, slide=slide).track.tolist() == motion.track.tolist()
        foot = motion.foot


@given(obstacles(), moves, st.integers(0, 1000))
@settings(max_examples=4)
def test_a_sliding_body_comes_no_less_far_than_one_that_stops(things, walk, start):
    world = Collider(enclosed(*things))
    spots = open_places(world, BODY)
    if not spots:
        return
    foot = spots[start % len(spots)]
    for direction, distance, _ in walk:
        stopped = world.move(foot, direction, distance, BODY, slide=False)
        slid = world.move(foot, direction, distance, BODY, slide=True)
        assert slid.travelled_m >= stopped.travelled_m - 1e-9
        assert slid.stopped_by == stopped.stopped_by
        foot = slid.foot


@given(st.floats(0, 359), st.floats(0.3, 2.4), st.floats(-0.9, 0.9), st.floats(0.01, 50))
def test_no_move_tunnels_through_one_thin_wall(turn, gap, aside, length):
    """The wall stands across the way at any angle; its far side is never reached."""
    angle = math.radians(turn)
    ahead = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-ahead[1], ahead[0]])
    ends = [tuple(gap * ahead + side * across) for side in (-30, 30)]
    world = Collider(scene(floor(-60, -60, 60, 60), wall(*ends)), bounds=np.array([[-60, -60, -1], [60, 60, 3]]))
    motion = world.move([0, 0, 0], turn + math.degrees(math.asin(aside)), length, BODY, slide=True)
    assert motion.foot[:2] @ ahead <= gap - BODY.radius_m + 1e-5


def inside_starts(world: Collider, count: int) -> list[np.ndarray]:
    """Return places with room on the lowest floors, spread over the scene by a fixed sequence."""
    rng = np.random.default_rng(7)
    low, high = world.scene.bounds
    found: list[np.ndarray] = []
    for x, y in rng.uniform(low[:2], high[:2], (400, 2)):
        floor_z = world.floor_below(np.array([x, y, low[2] + 1.2]), BODY)
        foot = np.array([x, y, np.nan if floor_z is None else floor_z])
        if floor_z is not None and world.touching(foot, BODY) is None:
            found.append(foot)
    return found[:count]


@pytest.mark.slow
@pytest.mark.parametrize("path", ASSETS, ids=lambda path: path.stem)
def test_walks_in_every_shipped_scene_keep_the_body_clear_and_within_bounds(path):
    world = Collider(load_scene(path))
    low, high = world.bounds
    everything = Surfaces(world.scene).corners
    rng = np.random.default_rng(11)
    starts = inside_starts(world, 4)
    assert starts
    for foot in starts:
        for _ in range(12):
            motion = world.move(foot, rng.uniform(0, 360), rng.uniform(0, 4), BODY, slide=bool(rng.integers(2)))
            assert clear_of_triangles(everything, motion.track)
            assert (motion.foot >= low - 1e-3).all() and (motion.foot <= high + 1e-3).all()
            foot = motion.foot


def clear_of_triangles(corners, track) -> bool:
    """Return whether the axis keeps its distance from (n, 3, 3) triangles; horizontal slices, no code of ours."""
    reach = np.array([0.3, 0.3, BODY.height_m])
    low, high = track.min(axis=0) - reach, track.max(axis=0) + reach
    corners = corners[((corners.min(axis=1) < high) & (corners.max(axis=1) > low)).all(axis=1)]
    for start, end in itertools.pairwise(track):
        parts = np.linspace(0, 1, max(int(np.linalg.norm(end - start) / 0.1), 1) + 1)
        feet = start + parts[:, None] * (end - start)
        for height in np.arange(BODY.step_m + 0.01, BODY.height_m, 0.1):
            if any(slice_distance(corners, foot + [0, 0, height]) < BODY.radius_m - TOLERANCE_M for foot in feet):
                return False
    return True


def slice_distance(corners, centre) -> float:
    """Return the distance from a point to the lines in which its horizontal plane cuts the triangles, metres."""
    above = corners[:, :, 2] > centre[2]
    crossed = corners[above.any(axis=1) & ~above.all(axis=1)]
    following = np.roll(crossed, -1, axis=1)
    cuts = (crossed[..., 2] > centre[2]) != (following[..., 2] > centre[2])
    a, b = crossed[cuts], following[cuts]
    ends = (a + ((centre[2] - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None] * (b - a))[:, :2].reshape(-1, 2, 2)
    along = ends[:, 1] - ends[:, 0]
    share = ((centre[:2] - ends[:, 0]) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-30)
    gaps = centre[:2] - ends[:, 0] - np.clip(share, 0, 1)[:, None] * along
    return float(np.sqrt((gaps**2).sum(axis=1)).min(initial=np.inf))
