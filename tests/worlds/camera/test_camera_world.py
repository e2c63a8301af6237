"""The 3D world as a whole: the same seed gives the same episode, and what is recorded is true."""

import asyncio
from functools import cache
from typing import Any

import numpy as np
import pytest
from omegaconf import OmegaConf

from episodes import ROOM, SMALL_PICTURES, PlayedEpisode, composed, episode, play_through
from foundry import seeding
from foundry.composing.preflight import scenario_of
from foundry.errors import InputError
from foundry.records import COMMAND_KINDS, CameraEpisode, CameraStep, Outcome
from foundry.running.build import build
from foundry.worlds.base import Answer
from foundry.worlds.camera.camera_policies import Oracle
from foundry.worlds.camera.camera_world import CameraScenario, CameraWorld
from foundry.worlds.camera.eye.rendering import png
from foundry.worlds.camera.language import command_record

WORLDS = ("kibo", "office", "gallery")
KIBO_FIRST = ("kibo", *(pytest.param(name, marks=pytest.mark.exhaustive) for name in WORLDS[1:]))
NORTH, EAST = (f"{{name: {wall}, prims: [/Room/{wall}], radius: 0.5}}" for wall in ("North", "East"))


@cache
def station(*overrides: str, world: str = "kibo") -> CameraScenario:
    scenario = scenario_of(composed(world, "stay", *overrides).conditions[0].config)
    assert isinstance(scenario, CameraScenario)
    return scenario


def room(*targets: str) -> CameraScenario:
    return station(f"scene={ROOM}", f"world.targets=[{', '.join(targets)}]", *SMALL_PICTURES, world="usd")


def moved(world: CameraWorld, text: str, **ending: str) -> CameraStep:
    step = world.advance([Answer(text, **ending)])[0]
    assert isinstance(step, CameraStep)
    return step


def test_the_seed_draws_the_target_where_there_are_several():
    openings = [record for seed in range(6) for record in room(NORTH, EAST).start(seed).opening()]
    assert {record.target for record in openings if isinstance(record, CameraEpisode)} == {"North", "East"}


@pytest.mark.parametrize("world", KIBO_FIRST)
def test_the_oracle_finds_the_target_by_nearly_the_shortest_way_and_sees_it_under_its_label(world: str):
    played = episode(world, "oracle", seed=7)
    last = played.steps[-1]
    assert last.success and last.command["stay"] and last.line_of_sight
    assert played.opening.shortest_m is not None
    assert sum(step.travelled for step in played.steps) <= played.opening.shortest_m / 0.9
    assert last.target_visible_px == last.visible_px[played.opening.target] > 30


def test_who_stays_near_the_target_with_its_back_to_it_has_not_arrived():
    world, oracle = room(NORTH).start(0), Oracle("oracle")
    while not (told := world.pending()[0].told)["near"]:
        world.advance([Answer(oracle.move(told, seeding.stream(0, "way")))])
    while world.pending()[0].told["in_view"]:
        world.advance([Answer("Turn left 45 degrees.")])
    step = moved(world, "I stay.")
    assert step.command["stay"] and not step.success
    assert not world.finished and world.pending()[0].told["near"]


def test_a_recorded_pose_draws_the_very_image_that_the_model_saw():
    played, around = episode("kibo", "wander", seed=2, steps=3), station().surroundings
    for step, image in zip(played.steps, played.images, strict=True):
        drawn = around.renderer().view(around.eye(step.pose), step.pose.yaw, step.pose.pitch)
        assert png(drawn) == image.content


def test_a_reply_decides_for_a_kind_of_command_and_one_that_cannot_be_read_moves_nothing():
    replies = {
        Answer("I see a wall. Turn left 30 degrees."): ("turn left", Outcome.CHOSEN),
        Answer("Move forward 2 m."): ("forward", Outcome.CHOSEN),
        Answer("Look up 10 degrees, then move right 1 m."): ("right", Outcome.CHOSEN),
        Answer("I stay where I am. Stay."): ("stay", Outcome.CHOSEN),
        Answer("Move forward 0 m."): ("stay", Outcome.CHOSEN),
        Answer("Gate 4 is 3 m away."): (None, Outcome.UNREADABLE),
        Answer(""): (None, Outcome.EMPTY),
        Answer("mov", ending="length"): (None, Outcome.TRUNCATED),
        Answer("", ending="aborted"): (None, Outcome.FAILED),
    }
    world = station().start(0)
    for answer, decided in replies.items():
        reading = station().read(world.pending()[0], answer)
        step = moved(world, answer.text, ending=answer.ending)
        assert (reading.action, reading.outcome) == (step.decision, step.outcome) == decided
        assert reading.message is None
        if decided[0] is None:
            assert (step.pose_next, step.travelled, step.command["stay"]) == (step.pose, 0.0, False)


def test_a_turn_comes_before_the_gaze_which_is_clamped_and_the_translation():
    """The agent of the paper's pose looks along -X: its left is -Y, and its right is +Y."""
    paper = station(world="kibo_paper")
    world = paper.start(0)
    step = moved(world, "Move forward 1 m and turn right 180 degrees, then look up 20 degrees.")
    assert (step.pose.x, step.pose.y, step.pose.pitch) == (4.0, 20.1, 0.0)
    assert step.pose.z == pytest.approx(-0.2358, abs=1e-4)
    assert (step.pose.yaw, step.pose_next.yaw, step.pose_next.pitch) == (180.0, 0.0, 20.0)
    assert step.pose_next.x == pytest.approx(step.pose.x + 1.0)
    steps = [moved(world, "Look up 60 degrees.") for _ in range(2)]
    assert (steps[1].pose_next.pitch, steps[1].boundary) == (80.0, "gaze limit")
    for said, sign in (("left", -1), ("right", 1)):
        step = moved(paper.start(0), f"Move {said} 0.3 m.")
        assert step.command["translate"]["bearing"] == -90 * sign
        assert step.pose_next.y - step.pose.y == pytest.approx(0.3 * sign, abs=1e-6)
        assert (step.pose_next.x, step.pose_next.yaw) == (pytest.approx(step.pose.x, abs=1e-6), step.pose.yaw)


def test_there_is_one_option_for_each_kind_of_command_in_the_order_that_is_declared():
    scenario = station("world.limits.max_distance_m=0.2")
    assert scenario.actions()["move"].labels == COMMAND_KINDS
    for number, kind in enumerate(COMMAND_KINDS):
        world = scenario.start(3)
        (question,) = world.pending()
        step = moved(world, question.options[number])
        assert step.outcome is Outcome.CHOSEN and not any("clamped" in note for note in step.notes)
        assert len(question.options) == len(COMMAND_KINDS) and step.decision == kind
        stays = question.options[number] == question.idle
        assert stays == step.command["stay"] == (scenario.actions()["move"].idle == kind)


@pytest.mark.parametrize("interpreter", ["LastSentenceInterpreter", "JsonInterpreter"])
def test_every_interpreter_reads_the_options(interpreter: str):
    scenario = station(f"world.interpreter._target_=foundry.worlds.camera.language.interpreter.{interpreter}")
    (question,) = scenario.start(0).pending()
    asked = [scenario.interpreter.read(option, scenario.limits) for option in question.options]
    assert len({str(command_record(command)) for command in asked}) == len(COMMAND_KINDS)
    assert all(command.idle == (number == 0) for number, command in enumerate(asked))


def test_a_picture_is_sent_as_jpeg_where_that_is_asked_for():
    (question,), (again,) = (station("world.image_format=jpeg").start(0).pending() for _ in range(2))
    assert question.images[0].startswith(b"\xff\xd8") and question.images == again.images


def test_history_is_bounded_and_idle_decisions_are_counted():
    world = station().start(0)
    for text in (*["I stay."] * 5, "Move forward 0 m.", "Nothing comes to my mind."):
        world.advance([Answer(text)])
    (question,) = world.pending()
    assert [line["step"] for line in question.observation["history"]] == [2, 3, 4, 5, 6]
    assert question.observation["idle_streak"] == 7
    assert question.images[0].startswith(b"\x89PNG")


def test_a_target_that_every_start_is_near_is_refused():
    with pytest.raises(InputError, match="already within 99"):
        room("{name: North, prims: [/Room/North], radius: 99}").start(0)


@pytest.mark.slow
def test_overviews_are_drawn_from_the_records_of_the_episode():
    frames = PlayedEpisode()
    asyncio.run(
        play_through(
            composed("usd", "spin", f"scene={ROOM}", "world.steps=1", *SMALL_PICTURES), 0, frames, frame_every=1
        )
    )
    assert sorted(frames.frames) == [0, 1] and frames.frames[0] != frames.frames[1]


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("scene.asset", "kibbo.usdz", "Did you mean 'kibo.usdz'"),
        ("boundary", "bounce", "stop, slide"),
        ("start", {"region": None, "x": 90.0, "y": 20.0}, "x=90, y=20 is outside the scene, which has x from"),
        ("start", {"region": None, "x": 4.0, "y": None}, "world.start.x is 4, but world.start.y is null"),
        ("targets", [{"name": "n", "prims": ["/World/Emblen"], "radius": 1}], "/World/Emblem"),
        ("limits.max_speed", 3, "max_speed"),
    ],
)
def test_wrong_settings_are_refused_in_one_line(key: str, value: Any, expected: str):
    config = OmegaConf.create(dict(composed("kibo", "stay").conditions[0].config["world"]))
    OmegaConf.update(config, key, value, merge=False, force_add=True)
    with pytest.raises(InputError, match=expected) as refusal:
        build(OmegaConf.to_container(config)).start(0)
    assert "\n" not in str(refusal.value)


@pytest.mark.exhaustive
@pytest.mark.parametrize("world", WORLDS)
def test_the_oracle_succeeds_on_95_of_100_seeds_with_high_spl(world: str):
    played = [episode(world, "oracle", seed=seed) for seed in range(50)]
    spl = [
        one.steps[-1].success
        * one.opening.shortest_m
        / max(one.opening.shortest_m, sum(s.travelled for s in one.steps))
        for one in played
        if one.opening.shortest_m is not None
    ]
    assert len(spl) == 50
    assert np.mean([one.steps[-1].success for one in played]) >= 0.95
    assert np.mean(spl) >= 0.9


def test_a_move_is_told_apart_by_the_target_in_view_and_what_was_in_its_way():
    station, seen = room(NORTH), []
    world = station.start(0)
    for text in ("Turn left 90 degrees.",) * 4 + ("Move forward 3 m.",) * 3:
        before = station.strata(world.pending()[0])
        step = moved(world, text)
        assert before["target"] == (step.target_visible_px > 0)
        assert station.strata(world.pending()[0])["wall"] == (step.boundary is not None)
        seen.append(before)
    assert {one["target"] for one in seen} == {one["wall"] for one in seen} == {True, False}
