"""The world that tells ways: what is told is true, and who follows it arrives."""

import asyncio
import json
import math
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from episodes import PlayedEpisode, composed
from foundry.episode import Asker, play
from foundry.errors import InputError
from foundry.models.base import Model
from foundry.paths import conf_dir
from foundry.prompts.prompt import Prompt
from foundry.records import CameraStep
from foundry.running.build import build
from foundry.worlds.any.any_policies import Stay
from foundry.worlds.base import Answer
from foundry.worlds.camera.camera_policies import Oracle
from foundry.worlds.camera.following_world import FollowEpisode, FollowScenario
from foundry.worlds.camera.surroundings import make_pose, turn_between
from foundry.worlds.camera.told_route import AHEAD_DEG, NEAR_M, TOWARDS_DEG, straightened
from labelled_rooms import THINGS, TINY, write_rooms

SEEDS = range(4)


@cache
def settings(rooms: Path) -> Mapping[str, Any]:
    found = composed("follow", "oracle", f"scene='{rooms}'", *TINY)
    return found.conditions[0].config["world"]


@cache
def scenario(rooms: Path, changes: str = "{}") -> FollowScenario:
    found = build({**settings(rooms), **json.loads(changes)})
    assert isinstance(found, FollowScenario)
    return found


@cache
def facts(world: FollowScenario, seed: int) -> FollowEpisode:
    (record,) = world.start(seed).opening()
    assert isinstance(record, FollowEpisode)
    return record


def test_only_things_whose_label_is_theirs_alone_are_spoken_of(rooms: Path):
    world = scenario(rooms)
    assert world.things.names == tuple(sorted(THINGS))
    fewer = scenario(rooms, '{"things": {"ignore": ["re*"], "largest": 4, "pixels": 4}}')
    assert fewer.things.names == ("blue box", "green box", "white post", "yellow box")


@pytest.mark.parametrize("seed", SEEDS)
def test_a_told_way_leads_to_the_goal_and_what_a_leg_names_is_seen_there_near_it_and_on_that_side(
    rooms: Path, seed: int
):
    world = scenario(rooms)
    episode = facts(world, seed)
    here, yaw = (episode.start.x, episode.start.y, episode.start.z), episode.start.yaw
    for leg in episode.legs:
        yaw += leg.turn
        x, y = here[0] + leg.metres * math.cos(math.radians(yaw)), here[1] + leg.metres * math.sin(math.radians(yaw))
        assert (x, y) == pytest.approx(leg.end[:2], abs=1e-6)
        first, last = (make_pose(np.array(foot), yaw, 0.0) for foot in (here, leg.end))
        if leg.towards:
            assert leg.towards in world.things.seen(first)
            assert abs(world.things.aside(leg.towards, first)) <= TOWARDS_DEG
        if leg.near:
            assert leg.near in world.things.seen(last) and world.things.gap(leg.near, last) <= NEAR_M
            middle = np.mean(THINGS[leg.near], axis=0)
            aside = turn_between(yaw, math.degrees(math.atan2(middle[1] - last.y, middle[0] - last.x)))
            assert leg.side == ("ahead" if abs(aside) <= AHEAD_DEG else "left" if aside > 0 else "right")
            assert world.things.gap(leg.near, last) < world.things.gap(leg.near, first)
        here = leg.end
    assert episode.shortest_m is not None and 2 <= episode.shortest_m <= 15
    assert here[:2] == pytest.approx(episode.shortest_path[-1][:2], abs=0.1)


def test_the_same_seed_tells_the_same_way_another_one_another_and_things_and_sides_are_named(rooms: Path):
    scenario(rooms).start(0)
    (again,) = scenario(rooms).start(3).opening()
    episodes = [facts(scenario(rooms), seed) for seed in SEEDS]
    assert again == episodes[3] and len({episode.start for episode in episodes}) == len(SEEDS)
    legs = [leg for episode in episodes for leg in episode.legs]
    assert any(leg.side for leg in legs) and any(leg.towards for leg in legs)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS[:2])
def test_who_does_to_the_letter_what_the_fine_grain_says_arrives_without_looking(rooms: Path, seed: int):
    world = scenario(rooms, '{"grain": "fine", "steps": 60}').start(seed)
    (record,) = world.opening()
    assert isinstance(record, FollowEpisode)
    numbers = re.findall(
        r"(?:Turn (left|right) by (\d+) degrees and w|W)alk ([\d.]+) m\.", record.instruction["english"]
    )
    assert len(numbers) == len(record.legs)
    walked = [(side or "left", turn or "0", metres) for side, turn, metres in numbers]
    aside, above = record.facing
    for side, turn, metres in (*walked, ("left" if aside > 0 else "right", f"{abs(aside):.0f}", "0")):
        world.advance([Answer(f"Turn {side} {turn} degrees.")])
        for _ in range(4):  # a quarter each: one command goes 3 m at most
            world.advance([Answer(f"Move forward {float(metres) / 4:.3f} m.")])
    world.advance([Answer(f"Look {'up' if above > 0 else 'down'} {abs(above):.0f} degrees.")])
    (last, _) = world.advance([Answer("Stay.")])
    assert isinstance(last, CameraStep) and last.success and world.finished


def played(world: FollowScenario, policy: Model, prompt: str, seed: int) -> PlayedEpisode:
    kept = PlayedEpisode()
    asked = Prompt(prompt, yaml.safe_load((conf_dir() / f"prompt/{prompt}.yaml").read_text("utf-8"))["templates"])
    asker = Asker.create(policy, asked, digest=None, seed=seed)
    asyncio.run(play(world.start(seed), asker, kept, frame_every=0))
    return kept


def test_the_oracle_follows_a_way_to_its_end(rooms: Path):
    kept = played(scenario(rooms), Oracle("scripted/oracle"), "follow", seed=0)
    length = sum(step.travelled for step in kept.steps)
    assert kept.steps[-1].success and kept.steps[-1].command["stay"]
    assert kept.opening.shortest_m is not None and kept.opening.shortest_m / length > 0.98


def test_every_grain_tells_the_same_way_and_each_tells_more(rooms: Path):
    told = {grain: facts(scenario(rooms, f'{{"grain": "{grain}"}}'), 1) for grain in ("coarse", "medium", "fine")}
    assert len({str(episode.shortest_path) + episode.target for episode in told.values()}) == 1
    lengths = [len(episode.instruction["english"]) for episode in told.values()]
    assert lengths == sorted(lengths) and len(set(lengths)) == 3
    for episode in told.values():
        assert episode.target in episode.instruction["english"] and episode.target in episode.instruction["japanese"]
    assert "m." in told["fine"].instruction["english"] and "メートル" in told["fine"].instruction["japanese"]


def test_the_words_stand_in_the_observation_in_the_task_and_in_the_prompts_of_both_languages(rooms: Path):
    for prompt, language in (("follow", "english"), ("follow_japanese", "japanese")):
        kept = played(scenario(rooms, '{"steps": 1}'), Stay("scripted/stay"), prompt, seed=1)
        assert isinstance(kept.opening, FollowEpisode)
        (message,) = kept.calls[0].messages
        assert kept.opening.instruction[language] in str(message["content"])
    (question,) = scenario(rooms).start(1).pending()
    assert question.observation["instruction"]["english"] in question.observation["task"]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"scene": {"exclude": [], "root": None}}, "0 things with a unique label"),
        ({"grain": "rough"}, "coarse, medium, fine"),
        ({"way": {"shortest": 5, "longest": 1, "radius": 1}}, "Swap the two values"),
        ({"way": {"shortest": 50, "longest": 60, "radius": 1}}, "no path of 50 to 60 m"),
        (
            {"targets": [{"name": "n", "prims": ["/World/Floor"], "radius": 1}]},
            "world.targets is not a setting of this world",
        ),
    ],
)
def test_wrong_settings_and_a_scene_without_labels_are_refused_in_one_line(
    rooms: Path, tmp_path: Path, changes: dict[str, Any], expected: str
):
    if "scene" in changes:
        changes["scene"]["asset"] = str(write_rooms(tmp_path / "bare.usda", labelled=False))
    with pytest.raises(InputError, match=expected) as refusal:
        build({**settings(rooms), **changes}).start(0)
    assert "\n" not in str(refusal.value)


@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=2, max_size=12), st.floats(0.01, 2))
def test_a_straightened_way_keeps_its_ends_and_passes_every_corner_nearby(
    places: list[tuple[float, float]], far: float
):
    points = np.array([(x, y, 0.0) for x, y in places])
    kept = straightened(points, far, lambda *_: True)
    assert (kept[0] == points[0]).all() and (kept[-1] == points[-1]).all()
    for point in points:
        assert min(_distance(point, *piece) for piece in zip(kept[:-1], kept[1:], strict=True)) <= far + 1e-9
    assert len(straightened(points, far, lambda *_: False)) == len(points)


def _distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    way = end - start
    share = np.clip((point - start) @ way / max(way @ way, 1e-12), 0, 1)
    return float(np.linalg.norm(point - start - share * way))
