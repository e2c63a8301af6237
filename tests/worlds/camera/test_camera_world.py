"""The 3D world as a whole: the same seed gives the same episode, and what is recorded is true."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest

from episodes import ROOM, Kept, composed, episode, play_through
from foundry import paths, seeding
from foundry.composing.compose import compose
from foundry.composing.preflight import scenario_of
from foundry.errors import InputError
from foundry.records import COMMAND_KINDS, CameraEpisode, CameraStep, Outcome, Pose
from foundry.worlds.base import Answer
from foundry.worlds.camera.camera_policies import Oracle
from foundry.worlds.camera.eye.rendering import png
from foundry.worlds.camera.language import command_record

WORLDS = ("kibo", "office", "gallery")
KIBO_FIRST = ("kibo", *(pytest.param(name, marks=pytest.mark.exhaustive) for name in WORLDS[1:]))


@pytest.mark.slow
@pytest.mark.parametrize("world", KIBO_FIRST)
def test_another_seed_starts_elsewhere_and_the_same_seed_starts_alike_for_every_model(world: str):
    def start(policy: str, seed: int) -> Pose:
        (opening,) = scenario_of(composed(world, policy).conditions[0].config).start(seed).opening()
        assert isinstance(opening, CameraEpisode)
        return opening.start

    assert start("spin", 0) == start("wander", 0) != start("spin", 1) == start("wander", 1)


def test_the_seed_draws_the_target_where_there_are_several():
    walls = ", ".join(f"{{name: {wall}, prims: [/Room/{wall}], radius: 0.5}}" for wall in ("North", "East"))
    settings = (f"scene={ROOM}", f"world.targets=[{walls}]")
    room = scenario_of(composed("usd", "stay", *settings).conditions[0].config)
    openings = [record for seed in range(6) for record in room.start(seed).opening()]
    assert {record.target for record in openings if isinstance(record, CameraEpisode)} == {"North", "East"}


@pytest.mark.slow
@pytest.mark.parametrize("world", KIBO_FIRST)
def test_the_oracle_finds_the_target_by_nearly_the_shortest_way(world: str):
    played = episode(world, "oracle", seed=7)
    last = played.steps[-1]
    assert last.success and last.command["stay"]
    assert played.opening.shortest_m is not None
    assert sum(step.travelled for step in played.steps) <= played.opening.shortest_m / 0.9


def test_who_stays_near_the_target_with_its_back_to_it_has_not_arrived():
    world, oracle = scenario_of(composed("kibo", "stay").conditions[0].config).start(0), Oracle("oracle")
    while not (told := world.pending()[0].told)["near"]:
        world.advance([Answer(oracle.move(told, seeding.stream(0, "way")))])
    while world.pending()[0].told["in_view"]:
        world.advance([Answer("Turn left 45 degrees.")])
    (step, _) = world.advance([Answer("I stay.")])
    assert isinstance(step, CameraStep) and step.command["stay"] and not step.success
    assert not world.finished and world.pending()[0].told["near"]


def test_a_recorded_pose_draws_the_very_image_that_the_model_saw():
    played = episode("kibo", "wander", seed=2, steps=5)
    around = scenario_of(composed("kibo", "wander").conditions[0].config).surroundings
    for step, image in zip(played.steps, played.images, strict=True):
        drawn = around.renderer().view(around.eye(step.pose), step.pose.yaw, step.pose.pitch)
        assert png(drawn) == image.content


def test_what_cannot_be_read_moves_nothing():
    world = scenario_of(composed("kibo", "stay").conditions[0].config).start(0)
    answers = [Answer("Gate 4 is 3 m away."), Answer(""), Answer("mov", ending="length"), Answer("", ending="aborted")]
    outcomes = []
    for answer in answers:
        step = world.advance([answer])[0]
        assert isinstance(step, CameraStep)
        assert (step.pose_next, step.travelled, step.command["stay"]) == (step.pose, 0.0, False)
        outcomes.append(step.outcome)
    assert outcomes == [Outcome.UNREADABLE, Outcome.EMPTY, Outcome.TRUNCATED, Outcome.FAILED]


def test_a_turn_comes_before_the_gaze_which_is_clamped_and_the_translation():
    world = scenario_of(composed("kibo_paper", "stay").conditions[0].config).start(0)
    step = world.advance([Answer("Move forward 1 m and turn right 180 degrees, then look up 20 degrees.")])[0]
    assert isinstance(step, CameraStep)
    assert (step.pose.yaw, step.pose_next.yaw, step.pose_next.pitch) == (180.0, 0.0, 20.0)
    assert step.pose_next.x == pytest.approx(step.pose.x + 1.0)
    steps = [world.advance([Answer("Look up 60 degrees.")])[0] for _ in range(2)]
    assert isinstance(steps[1], CameraStep)
    assert (steps[1].pose_next.pitch, steps[1].boundary) == (80.0, "gaze limit")


@pytest.mark.parametrize("number", range(len(COMMAND_KINDS)))
def test_there_is_one_option_for_each_kind_of_command_in_the_order_that_is_declared(number: int):
    scenario = scenario_of(composed("kibo", "stay", "world.limits.max_distance_m=0.2").conditions[0].config)
    world = scenario.start(3)
    (question,) = world.pending()
    (step, _) = world.advance([Answer(question.options[number])])
    assert isinstance(step, CameraStep) and step.outcome is Outcome.CHOSEN
    assert not any("clamped" in note for note in step.notes)
    assert len(question.options) == len(COMMAND_KINDS) and step.decision == COMMAND_KINDS[number]
    assert scenario.actions()["move"].labels == COMMAND_KINDS
    stays = question.options[number] == question.idle
    assert stays == step.command["stay"] == (scenario.actions()["move"].idle == COMMAND_KINDS[number])


@pytest.mark.parametrize("interpreter", ["LastSentenceInterpreter", "JsonInterpreter"])
def test_every_interpreter_reads_the_options(interpreter: str):
    target = f"world.interpreter._target_=foundry.worlds.camera.language.interpreter.{interpreter}"
    scenario = scenario_of(composed("kibo", "stay", target).conditions[0].config)
    (question,) = scenario.start(0).pending()
    asked = [scenario.interpreter.read(option, scenario.limits) for option in question.options]
    assert len({str(command_record(command)) for command in asked}) == len(COMMAND_KINDS)
    assert all(command.idle == (number == 0) for number, command in enumerate(asked))


def test_random_plays_3d_worlds_by_all_kinds_of_command():
    (question,) = scenario_of(composed("kibo", "random").conditions[0].config).start(0).pending()
    played = episode("kibo", "random", seed=0, steps=20)
    replies = {step.reply for step in played.steps}
    assert len(replies) >= 6 and replies <= {*question.options}


def test_a_picture_is_sent_as_jpeg_where_that_is_asked_for():
    scenario = scenario_of(composed("kibo", "stay", "world.image_format=jpeg").conditions[0].config)
    (one,), (again,) = (scenario.start(0).pending() for _ in range(2))
    assert one.images[0].startswith(b"\xff\xd8") and one.images == again.images


def test_history_is_bounded_and_idle_decisions_are_counted():
    world = scenario_of(composed("kibo", "stay").conditions[0].config).start(0)
    for text in (*["I stay."] * 5, "Move forward 0 m.", "Nothing comes to my mind."):
        world.advance([Answer(text)])
    (question,) = world.pending()
    assert [line["step"] for line in question.observation["history"]] == [2, 3, 4, 5, 6]
    assert question.observation["idle_streak"] == 7
    assert question.images[0].startswith(b"\x89PNG")


def test_the_papers_pose_starts_the_papers_run():
    opening = episode("kibo_paper", "stay", seed=0, steps=1).opening
    assert (opening.start.x, opening.start.y, opening.start.yaw, opening.start.pitch) == (4.0, 20.1, 180.0, 0.0)
    assert opening.start.z == pytest.approx(-0.2358, abs=1e-4)


def test_what_is_in_view_is_counted_by_label():
    played = episode("kibo", "oracle", seed=0)
    last = played.steps[-1]
    assert last.target_visible_px == last.visible_px["JAXA logo"] > 30
    assert last.line_of_sight


@pytest.mark.slow
def test_overviews_are_drawn_from_the_records_of_the_episode():
    frames = Kept()
    asyncio.run(play_through(composed("kibo", "spin", "world.steps=2"), 0, frames, frame_every=1))
    assert sorted(frames.frames) == [0, 1, 2]
    assert len(set(frames.frames.values())) == 3


def test_a_scene_of_ones_own_needs_nothing_but_its_path_and_a_task():
    config = compose(["world=usd", f"scene={ROOM}", "task=Look around.", "model=scripted/wander"])
    assert config is not None
    world = scenario_of(config.conditions[0].config).start(1)
    (question,) = world.pending()
    assert (question.observation["task"], question.observation["target"]) == ("Look around.", "")


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (["scene=kibbo.usdz"], "Did you mean 'kibo.usdz'"),
        (["world.camera.fovv=3"], "camera"),
        (["world.boundary=bounce"], "stop, slide"),
        (["world.start={region: null, x: 90.0, y: 20.0}"], "x=90, y=20 lies outside the scene, which has x from"),
        (["world.start={region: null, x: 4.0, y: null}"], "world.start.x is 4, but world.start.y is null"),
        (["world.start={region: null, y: 20.0}"], "world.start.y is 20, but world.start.x is null"),
        (["world.targets=[{name: n, prims: [/World/Emblen], radius: 1}]"], "/World/Emblem"),
        (["world.limits.max_speed=3"], "max_speed"),
        pytest.param(
            ["world.targets=[{name: n, prims: [/World/Emblem], radius: 99}]"],
            "already within 99",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_wrong_settings_are_refused_in_one_line(overrides: list[str], expected: str):
    with pytest.raises(InputError, match=expected) as refusal:
        config = compose(["world=kibo", "model=scripted/stay", *(f"++{item}" for item in overrides)])
        assert config is not None
        scenario_of(config.conditions[0].config).start(0)
    assert "\n" not in str(refusal.value)


@pytest.mark.exhaustive
@pytest.mark.parametrize("world", WORLDS)
def test_no_start_of_50_seeds_is_a_success_already(world: str):
    assert not any(step.success for seed in range(50) for step in episode(world, "stay", seed=seed, steps=1).steps)


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


def test_shipped_worlds_refer_to_shipped_scenes_only():
    for file in Path(paths.conf_dir() / "world").glob("*.yaml"):
        for line in file.read_text(encoding="utf-8").splitlines():
            if line.startswith("scene:") and "???" not in line:
                assert (paths.assets_dir() / line.split()[1]).is_file()


@pytest.mark.slow
def test_a_bearing_to_the_left_moves_to_the_left_and_one_to_the_right_to_the_right():
    """The agent of the paper's pose looks along -X: its left is -Y, and its right is +Y."""
    for said, sign in (("left", -1), ("right", 1)):
        world = scenario_of(composed("kibo_paper", "stay").conditions[0].config).start(0)
        step = world.advance([Answer(f"Move {said} 0.3 m.")])[0]
        assert isinstance(step, CameraStep) and step.command["translate"]["bearing"] == -90 * sign
        assert step.pose_next.y - step.pose.y == pytest.approx(0.3 * sign, abs=1e-6)
        assert (step.pose_next.x, step.pose_next.yaw) == (pytest.approx(step.pose.x, abs=1e-6), step.pose.yaw)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("I see a wall. Turn left 30 degrees.", "turn left"),
        ("Move forward 2 m.", "forward"),
        ("Look up 10 degrees, then move right 1 m.", "right"),
        ("I stay where I am. Stay.", "stay"),
        ("Move forward 0 m.", "stay"),
        ("Nothing comes to my mind.", None),
        ("", None),
    ],
)
def test_a_reply_in_3d_decides_for_a_kind_of_command(text: str, kind: str | None):
    station = scenario_of(composed("kibo", "stay").conditions[0].config)
    world = station.start(0)
    (question,) = world.pending()
    reading = station.read(question, Answer(text))
    record = world.advance([Answer(text)])[0]
    assert isinstance(record, CameraStep) and reading.action == record.decision == kind
    assert reading.outcome == record.outcome and reading.message is None


@pytest.mark.slow
def test_a_move_is_told_apart_by_the_target_in_view_and_what_was_in_its_way():
    station = scenario_of(composed("kibo", "stay").conditions[0].config)
    world, oracle, seen = station.start(0), Oracle("oracle"), []
    while not world.finished:
        (question,) = world.pending()
        before = station.strata(question)
        way = oracle.move(question.told, seeding.stream(0, "way"))
        text = "Move forward 3 m." if world.step < 4 else way
        record = world.advance([Answer(text)])[0]
        assert isinstance(record, CameraStep) and before["target"] == (record.target_visible_px > 0)
        if not world.finished:
            assert station.strata(world.pending()[0])["wall"] == (record.boundary is not None)
        seen.append(before)
    assert {one["target"] for one in seen} == {one["wall"] for one in seen} == {True, False}
