"""The world that asks after a walk: every answer is known, true, and as likely as its chance says."""

import json
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as settings_of
from hypothesis import strategies as st

from episodes import composed
from foundry.errors import InputError
from foundry.records import Outcome, Pose, SeenImage
from foundry.running.build import build
from foundry.worlds.base import Answer, Question
from foundry.worlds.camera.probing_world import MapProbeScenario, MapProbeWorld, Prepared, ProbeEpisode, ProbeStep
from foundry.worlds.camera.surroundings import turn_between
from foundry.worlds.camera.walk_questions import FARTHER, FARTHER_M, SIDE_DEG, along, spread
from labelled_rooms import THINGS, TINY

KINDS = ("nearer", "side", "count", "order", "distance")
SEEDS = range(2)


@cache
def settings(rooms: Path) -> Mapping[str, Any]:
    return composed("map_probe", "knower", f"scene='{rooms}'", *TINY).conditions[0].config["world"]


@cache
def scenario(rooms: Path, changes: str = "{}") -> MapProbeScenario:
    found = build({**settings(rooms), **json.loads(changes)})
    assert isinstance(found, MapProbeScenario)
    return found


BRIEF = '{"frames": 2, "questions": ["nearer", "side", "count", "distance"]}'


@cache
def brief(rooms: Path) -> Prepared:
    return scenario(rooms, BRIEF).prepared(1)


def told(world: Any) -> Answer:
    (question,) = world.pending()
    return Answer(question.told["answer"])


@cache
def known(rooms: Path, seed: int) -> tuple[ProbeEpisode, list[ProbeStep], list[Question]]:
    """Return the facts, answers and questions of an episode whose every answer is the right one."""
    world = scenario(rooms).start(seed)
    facts, *images = world.opening()
    assert isinstance(facts, ProbeEpisode) and all(isinstance(image, SeenImage) for image in images)
    assert [image.path for image in images] == [frame.image for frame in facts.frames]
    answers: list[ProbeStep] = []
    questions: list[Question] = []
    while not world.finished:
        questions += world.pending()
        (answer,) = world.advance([told(world)])
        assert isinstance(answer, ProbeStep)
        answers.append(answer)
    return facts, answers, questions


def gap(name: str, pose: Pose) -> float:
    """Return how far a thing's box is from a place, seen from above."""
    (x0, y0, _), (x1, y1, _) = THINGS[name]
    return math.hypot(max(x0 - pose.x, 0, pose.x - x1), max(y0 - pose.y, 0, pose.y - y1))


def shown(rooms: Path, facts: ProbeEpisode) -> list[set[str]]:
    """Return the things of which each picture shows anything, by the prims that fill its pixels."""
    around, names = scenario(rooms).surroundings, list(THINGS)
    pictures = [
        around.renderer().visible(around.eye(frame.pose), frame.pose.yaw, frame.pose.pitch) for frame in facts.frames
    ]
    return [{names[int(path[-1])] for path in picture if "Thing_" in path} for picture in pictures]


def named(text: str) -> list[str]:
    return [name for name in THINGS if name in text]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_every_answer_is_true_of_the_rooms_as_they_were_built(rooms: Path, seed: int):
    facts, answers, _ = known(rooms, seed)
    nearer, side, count, order, distance = answers
    assert [answer.kind for answer in answers] == list(KINDS)
    end, seen = facts.frames[-1].pose, shown(rooms, facts)
    by_gap = sorted(nearer.choices.values(), key=lambda name: gap(name, end))
    assert nearer.choices[str(nearer.truth)] == by_gap[0]
    assert gap(by_gap[1], end) >= max(FARTHER * gap(by_gap[0], end), gap(by_gap[0], end) + FARTHER_M) - 1e-6
    assert side.question is not None and count.question is not None and distance.question is not None
    (name,) = named(side.question["english"])
    middle = np.mean(THINGS[name], axis=0)
    aside = turn_between(end.yaw, math.degrees(math.atan2(middle[1] - end.y, middle[0] - end.x)))
    assert side.truth == ("left" if aside > 0 else "right") and SIDE_DEG[0] - 5 < abs(aside) < SIDE_DEG[1] + 5
    assert count.truth == len(set(named(count.question["english"])) & set().union(*seen))
    first = [
        next(number for number, things in enumerate(seen) if name in things)
        for name in order.choices[str(order.truth)].split(" → ")
    ]
    assert first == sorted(first) and len(set(first)) == 3
    (name,) = named(distance.question["english"])
    assert distance.truth == pytest.approx(gap(name, end), abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_who_is_told_the_answers_gives_them_and_who_draws_is_right_as_often_as_chance_says(rooms: Path, seed: int):
    facts, answers, questions = known(rooms, seed)
    for one, question in zip(answers, questions, strict=True):
        assert one.decision == one.truth and one.outcome is Outcome.CHOSEN
        drawn = [json.loads(reply)["action"] for reply in question.options]
        if one.chance is not None:
            assert drawn.count(one.truth) == 1 and one.chance == pytest.approx(1 / len(drawn))
        assert "answer" not in question.observation and len(question.images) == 8 and question.idle is None
    seen = sorted(set().union(*(scenario(rooms).things.seen(frame.pose) for frame in facts.frames)))
    far = [gap(name, facts.frames[-1].pose) for name in seen if gap(name, facts.frames[-1].pose) >= 0.5]
    best = min(np.mean([abs(one - answer) for one in far]) for answer in far)
    assert answers[-1].scale == pytest.approx(best, abs=1e-3), "off by this where the best answer is always the same"


def test_a_walk_of_its_own_ends_where_the_agent_stays_and_shows_what_it_saw(rooms: Path):
    world = scenario(rooms, '{"walk": "own", "frames": 4}').start(2)
    seen = []
    turn = "Turn left 90 degrees."
    for said in (turn, turn, "Move forward 1 m.", turn, "Stay."):
        (question,) = world.pending()
        assert question.kind == "move"
        seen.append(question.images[0])
        step, *images = world.advance([Answer(said)])
        assert isinstance(step, ProbeStep) and step.kind == "move" and step.question is None
    assert len(images) == 2, "the last view goes with the questions"
    (question,) = world.pending()
    assert question.kind in KINDS and len(question.images) == 4
    assert set(question.images[:-1]) <= set(seen) and question.images[0] == seen[0]
    while not world.finished:
        (answer,) = world.advance([told(world)])
        assert isinstance(answer, ProbeStep) and answer.decision == answer.truth and len(answer.frames) == 4


def test_a_walk_of_its_own_ends_when_its_decisions_are_used_up(rooms: Path):
    scene = scenario(rooms, '{"walk": "own", "steps": 2, "questions": ["count"]}')
    world = scene.start(0)
    kinds = []
    while not world.finished:
        kinds.append(world.pending()[0].kind)
        world.advance([Answer("Turn left 60 degrees.")])
    assert kinds == ["move", "move", "count"] and scene.count_calls() == 3


def test_a_scene_that_never_allows_a_question_is_refused_in_one_line(rooms: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("foundry.worlds.camera.probing_world.DRAWS", 3)
    with pytest.raises(
        InputError, match="none that allows order. Name fewer questions, or change world.frames"
    ) as refusal:
        scenario(rooms, '{"frames": 2, "questions": ["order", "side"]}').start(0)
    assert "\n" not in str(refusal.value)


def test_one_answer_about_a_walk_is_read_as_its_episode_reads_it(rooms: Path):
    scene = scenario(rooms, BRIEF)
    world = MapProbeWorld(scene, brief(rooms).frames[-1], 1, brief(rooms))
    while not world.finished:
        (question,) = world.pending()
        record = world.advance([told(world)])[0]
        reading = scene.read(question, Answer(question.told["answer"]))
        assert isinstance(record, ProbeStep)
        assert (reading.outcome, reading.action) == (Outcome.CHOSEN, record.command["answer"])


@settings_of(max_examples=15)
@given(st.text(max_size=40) | st.sampled_from(["A", '{"action": "A"}', "left", "7", '{"action": 7}', "-1", "nan"]))
def test_no_answer_is_made_up_from_any_text(rooms: Path, text: str):
    scene = scenario(rooms, BRIEF)
    world = MapProbeWorld(scene, brief(rooms).frames[-1], 1, brief(rooms))
    for _ in scene.probing.questions:
        (answer,) = world.advance([Answer(text)])
        assert isinstance(answer, ProbeStep)
        legal = scene.actions()[answer.kind]
        read = answer.outcome in (Outcome.CHOSEN, Outcome.REPAIRED)
        assert read == (answer.decision is not None)
        if read and legal.labels:
            assert answer.decision in legal.labels
        elif read:
            assert (legal.low or 0) <= float(str(answer.decision)) <= (legal.high or 0)
    assert world.finished and world.pending() == []


def test_pictures_lie_evenly_on_a_way_and_the_last_one_looks_at_its_goal():
    start = Pose(0.0, 0.0, 0.0, 200.0, 0.0)
    poses = along(start, np.array([(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (4.0, 4.0, 0.0)]), 45.0, 6)
    assert poses[0] == start
    assert [(pose.x, pose.y, pose.yaw) for pose in poses[1:]] == [
        (0, 0, 0), (2, 0, 0), (4, 0, 90), (4, 2, 90), (4, 4, 45)
    ]  # fmt: skip
    assert spread([start] * 9, 3) == [0, 4, 8] and spread([start] * 2, 8) == [0, 1]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"walk": "aimless"}, "oracle, own"),
        ({"questions": ["nearest"]}, "Did you mean 'nearer'"),
        ({"questions": ["side", "side"]}, "the name 'side' twice"),
        ({"targets": [{"name": "n", "prims": ["/World/Floor"], "radius": 1}]}, "not a setting of this world"),
    ],
)
def test_wrong_settings_are_refused_in_one_line(rooms: Path, changes: dict[str, Any], expected: str):
    with pytest.raises(InputError, match=expected) as refusal:
        build({**settings(rooms), **changes}).start(0)
    assert "\n" not in str(refusal.value)
