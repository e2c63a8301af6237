"""Environments of Gymnasium and PettingZoo are worlds: their rules, their rewards, their seeds, their pictures."""

import json
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pettingzoo
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.errors import InputError
from foundry.records import Outcome
from foundry.worlds.adapt.playing import choices_of, plain
from foundry.worlds.adapt.worlds import Adapted, GymnasiumWorld, ParallelWorld, Return, Turn, TurnsWorld
from foundry.worlds.base import Answer, Question

LAKE = {"desc": ["SFFF", "FHFH", "FFFH", "HFFG"], "is_slippery": True}
STEPS = ["left", "down", "right", "up"]
CELLS = [f"cell {place}" for place in range(9)]


def lake(**changes: Any) -> GymnasiumWorld:
    settings = {"name": "lake", "env": "FrozenLake-v1", "steps": 100, "settings": LAKE, "actions": STEPS} | changes
    return GymnasiumWorld(**settings)


def tictactoe(**changes: Any) -> TurnsWorld:
    return TurnsWorld(**{"name": "ttt", "env": "classic/tictactoe-v3", "steps": 5, "actions": CELLS} | changes)


Policy = Callable[[Question], str]


def first(question: Question) -> str:
    return question.options[0]


def drawing(seed: int) -> Policy:
    rng = np.random.default_rng(seed)
    return lambda question: question.options[int(rng.integers(len(question.options)))]


def played(scenario: Adapted, policy: Policy, seed: int = 0) -> tuple[list[Turn], list[Return], list[Question]]:
    world, records, asked = scenario.start(seed), [], []
    while not world.finished:
        questions = world.pending()
        asked += questions
        records += world.advance([Answer(policy(question)) for question in questions])
    turns = [record for record in records if isinstance(record, Turn)]
    return turns, [record for record in records if isinstance(record, Return)], asked


@given(st.integers(0, 2**31 - 1))
def test_an_episode_is_the_one_that_the_library_plays_with_this_seed_and_these_actions(seed: int):
    turns, (end,), asked = played(lake(), drawing(seed), seed)
    env = gymnasium.make("FrozenLake-v1", **LAKE)
    state, _ = env.reset(seed=seed)
    for question, turn in zip(asked, turns, strict=True):
        assert question.observation["state"] == state
        state, reward, ended, cut, _ = env.step(STEPS.index(str(turn.played)))
        assert turn.utility == reward
    assert (ended or cut) and end.total == sum(turn.utility or 0 for turn in turns) and end.turns == len(turns)


def test_agents_act_in_turn_each_once_a_round_and_only_legal_cells_can_be_chosen():
    turns, ends, asked = played(tictactoe(), first)
    env = pettingzoo.make("aec", "classic/tictactoe-v3")
    env.reset(seed=0)
    for question, turn in zip(asked, turns, strict=True):
        assert env.agents.index(env.agent_selection) == turn.agent
        legal = np.flatnonzero(env.last()[0]["action_mask"])
        assert question.observation["choices"] == [CELLS[place] for place in legal]
        env.step(CELLS.index(str(turn.played)))
    assert [(turn.step, turn.agent) for turn in turns] == [(1, 0), (1, 1), (2, 0), (2, 1), (3, 0), (3, 1), (4, 0)]
    assert [end.total for end in ends] == [1, -1], "cells 0, 2, 4, 6 of the one who begins are a diagonal"
    assert turns[-1].utility == 1 and all(turn.utility == 0 for turn in turns[:-1])


def test_all_act_at_once_where_the_environment_lets_them():
    world = ParallelWorld(name="rps", env="classic/rps-v2", steps=15, settings={"max_cycles": 4})
    turns, ends, asked = played(world, lambda question: question.options[question.agent])
    assert [(turn.step, turn.agent) for turn in turns] == [(step, agent) for step in range(1, 5) for agent in (0, 1)]
    assert [end.total for end in ends] == [-4, 4], "paper beats rock"
    assert len(asked) == 8


def test_what_cannot_be_read_is_drawn_from_what_is_legal_by_the_runs_seed_and_recorded_as_no_decision():
    turns, _, _ = played(tictactoe(), lambda question: "I would rather not say.", seed=3)
    again, _, _ = played(tictactoe(), lambda question: "no", seed=3)
    other, _, _ = played(tictactoe(), lambda question: "no", seed=4)
    assert all(turn.action is None and turn.outcome is Outcome.UNREADABLE for turn in turns)
    cells = [turn.played for turn in turns]
    assert len(set(cells)) == len(cells) and cells == [turn.played for turn in again] != [turn.played for turn in other]


def test_where_there_is_an_idle_action_it_is_what_is_played_instead():
    actions = ["left", "right", "forward", "pickup", "drop", "toggle", "done"]
    settings: dict[str, Any] = {"env": "MiniGrid-Empty-5x5-v0", "package": "minigrid", "idle": "done", "image": True}
    world = GymnasiumWorld(name="grid", steps=3, actions=actions, **settings)
    turns, _, asked = played(world, lambda question: "hm")
    assert [turn.played for turn in turns] == ["done"] * 3 and world.shows_images
    assert all(question.images[0].startswith(b"\x89PNG") for question in asked)
    assert asked[0].observation["state"]["mission"] == "get to the green goal square"


def test_the_last_turns_are_told_and_no_more_than_asked_for():
    _, _, asked = played(lake(history=3, steps=101, settings=LAKE | {"is_slippery": False}), first)
    told = [question.observation["turns"] for question in asked[:5]]
    turn = {"state": 0, "action": "left", "reward": 0.0}
    assert told == [[], [turn], [turn, turn], [turn] * 3, [turn] * 3]
    assert len(asked) == 100, "the library cuts the episode"


def test_the_best_action_is_known_where_the_rules_are_a_table_and_how_many_turns_are_left():
    cliff = GymnasiumWorld(name="cliff", env="CliffWalking-v1", steps=100, actions=["up", "right", "down", "left"])
    turns, (end,), asked = played(cliff, lambda question: json.dumps({"action": question.told["best"]}))
    assert end.total == -13 and [turn.played for turn in turns] == ["up", *["right"] * 11, "down"]
    assert "best" not in asked[0].observation
    assert tictactoe().plan is None
    shortest = lake(steps=6, settings=LAKE | {"is_slippery": False})
    _, (end,), _ = played(shortest, lambda question: json.dumps({"action": question.told["best"]}))
    assert end.total == 1, "no turn can be spared"


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: lake(env="FrozenLak-v1"), "FrozenLak"),
        (lambda: lake(env="os:FrozenLake-v1"), "names a module"),
        (lambda: lake(package="os"), "is not installed"),
        (lambda: lake(settings={"size": 3}), "cannot be made with world.settings"),
        (lambda: lake(settings={"desc": ["SFFF", "FFFF"]}), "'FrozenLake-v1', as it is set, never gives a reward"),
        (lambda: lake(settings={"desc": ["FFFF", "FFFG"]}), "has no start. Give its map a start"),
        (lambda: lake(actions=["left", "right"]), "must name the 4 actions"),
        (lambda: lake(idle="wait"), "left, down, right, up"),
        (lambda: lake(history=-1), "world.history must"),
        (lambda: lake(env="BipedalWalker-v3", settings={}), "BipedalWalker"),
        (lambda: ParallelWorld(name="t", env="classic/tictactoe-v3", steps=5), "(parallel)"),
    ],
)
def test_an_environment_that_cannot_be_a_world_is_refused_in_one_line(make: Callable[[], Any], told: str):
    with pytest.raises(InputError) as caught:
        make()
    assert told in str(caught.value) and "\n" not in str(caught.value)


def test_actions_are_a_finite_set_by_their_names_or_one_number():
    spaces = gymnasium.spaces
    named = choices_of(spaces.Discrete(3, start=-1), None, None, "it")
    assert named.labels == ("-1", "0", "1") and named.taken("1") == 1
    assert named.legal([1, 0, 1]).labels == ("-1", "1")
    number = choices_of(spaces.Box(-2.0, 2.0, (1,)), None, None, "it")
    assert (number.actions.low, number.actions.high, number.taken(1.5).tolist()) == (-2.0, 2.0, [1.5])
    for refused in (spaces.Box(0, 1, (2,)), spaces.MultiDiscrete([2, 2])):
        with pytest.raises(InputError, match="which foundry cannot read from a reply"):
            choices_of(refused, None, None, "it")


def test_observations_become_plain_values():
    found = plain({"a": np.arange(3), "b": (np.float32(0.5), np.bool_(True)), 3: object})
    assert found == {"a": [0, 1, 2], "b": [0.5, True], "3": "<class 'object'>"}
    assert json.dumps(found)
