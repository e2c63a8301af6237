"""Energy, food, and what agents do to one another, against worlds worked out by hand."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parts.actions import read_furnished_action
from foundry.worlds.grid.parts.parts_records import Birth, Growing, LivingStep
from foundry.worlds.grid.parts.parts_settings import FURTHER_ACTIONS
from foundry.worlds.grid.parts.parts_world import FurnishedWorld
from worlds.grid.test_parts import SILENT, scenario

ENERGY = {"start": 10, "loss": 1}
FIELD = {"share": 1, "amount": 4, "bite": 3}


def do(*actions: dict[str, Any]) -> list[Answer]:
    return [Answer(json.dumps({**action, "memory": "", "reasoning": ""})) for action in actions]


def step(world: FurnishedWorld, *actions: dict[str, Any]) -> list[LivingStep]:
    """Let a step go by in silence and return its lines."""
    world.advance([SILENT] * len(world.pending()))
    return [one for one in world.advance(do(*actions)) if isinstance(one, LivingStep)]


STAY = {"action": "stay"}
GATHER = {"action": "gather"}


def test_energy_is_lost_in_every_step_and_who_has_none_dies():
    world = scenario((0, 0), energy={"start": 2, "loss": 1}).start(0)
    assert [(line.energy, line.energy_next, line.lost) for line in step(world, STAY)] == [(2, 1, None)]
    assert [(line.energy, line.energy_next, line.lost) for line in step(world, STAY)] == [(1, 0, "energy")]
    assert world.finished and world.pending() == ()


def test_what_is_gathered_is_a_bite_of_what_there_is_grows_again_and_gives_nobody_more_than_the_most():
    world = scenario((0, 0), energy=ENERGY, food={**FIELD, "regrow_every": 2}).start(0)
    found = [step(world, GATHER)[0] for _ in range(3)]
    assert [line.food for line in found] == [4, 1, 1], "3 of 4 are taken, then 1, and one grew at the end of step 2"
    assert [line.amount for line in found] == [3, 1, 1]
    world = scenario((0, 0), energy={"start": 10, "most": 11}, food=FIELD).start(0)
    assert step(world, GATHER)[0].amount == 1
    assert world.pending()[0].observation["food"][12] == {"x": 0, "y": 0, "amount": 3}


def test_energy_is_shared_within_reach_alone_and_no_more_than_who_is_given_it_can_have():
    world = scenario((0, 0), (1, 1), (0, 2), energy=ENERGY, sharing=True).start(0)
    give = {"action": "share", "amount": 4}
    lines = step(world, {**give, "target": 1}, {**give, "target": 2, "amount": 1}, {**give, "target": 0})
    assert [line.energy_next for line in lines] == [5, 12, 10]
    assert [line.amount for line in lines] == [4, 1, 0]
    world = scenario((0, 0), (1, 1), energy={"start": 10, "most": 11}, sharing=True).start(0)
    lines = step(world, {"action": "share", "target": 1, "amount": 4}, STAY)
    assert [(line.energy_next, line.amount) for line in lines] == [(8, 1), (10, 0)]


def test_an_attack_takes_what_there_is_and_costs_the_attacker_who_may_be_robbed_itself():
    world = scenario((0, 0), (0, 1), energy={"start": 6, "loss": 1}, attack={"takes": 9, "cost": 2}).start(0)
    lines = step(world, {"action": "attack", "target": 1}, STAY)
    assert [(line.energy_next, line.lost) for line in lines] == [(9, None), (0, "attack")]
    world = scenario((0, 0), (0, 1), energy={"start": 6, "loss": 1}, attack={"takes": 9, "cost": 2}).start(0)
    lines = step(world, {"action": "attack", "target": 1}, {"action": "attack", "target": 0})
    # The first is left with 6 - 2 + 6 = 10 and then robbed of 9; the second has 0 - 2 + 9 = 7; each loses one.
    assert sorted(line.energy_next for line in lines) == [0, 6]


def test_a_newborn_has_energy_of_its_parent_and_is_asked_from_the_next_step_on_unless_there_are_enough():
    births = {"needs": 8, "gives": 5, "most": 2}
    world = scenario((0, 0), energy=ENERGY, reproduction=births, personas={"kind": {"a": 1}}).start(0)
    world.advance([SILENT])
    records = world.advance(do({"action": "reproduce"}))
    line, birth = records
    assert isinstance(line, LivingStep) and line.born is not None and line.energy_next == 4
    assert birth == Birth(agent=1, persona={"kind": "a"}, parent=0, step=1)
    assert [question.agent for question in world.pending()] == [0, 1]
    assert world.pending()[1].observation["energy"] == 5
    births = {"needs": 2, "gives": 1, "most": 3}
    world = scenario((0, 0), (1, 0), energy=ENERGY, reproduction=births).start(0)
    lines = step(world, *[{"action": "reproduce"}] * 2)
    assert sum(line.born is not None for line in lines) == 1 and len(world.pending()) == 3


def test_an_order_is_told_from_its_step_on():
    order = {"text": "Go left.", "target": [[-2, -2], [-2, 2]], "start": 2}
    world = scenario((0, 0), energy=ENERGY, order=order).start(0)
    assert world.pending()[0].observation["order"] is None
    step(world, STAY)
    assert world.pending()[0].observation["order"] == "Go left."


@pytest.mark.parametrize(
    ("text", "outcome", "action", "target", "amount"),
    [
        ('{"action": "gather", "memory": "", "reasoning": ""}', Outcome.CHOSEN, "gather", None, None),
        ('{"action": "share", "target": 3, "amount": 2}', Outcome.CHOSEN, "share", 3, 2),
        ('{"action": "Attack", "target": 4}', Outcome.REPAIRED, "attack", 4, None),
        ('{"action": "attack", "target": "Agent 4"}', Outcome.REPAIRED, "attack", 4, None),
        ('{"action": "share", "target": 1, "amount": "2"}', Outcome.REPAIRED, "share", 1, 2),
        ('{"action": "gather", "memory": 5}', Outcome.REPAIRED, "gather", None, None),
        ('{"action": "give", "to": 1, "amount": "2"}', Outcome.REPAIRED, "share", 1, 2),
        ("I am hungry.\naction: eat", Outcome.REPAIRED, "gather", None, None),
        ('{"action": "採集"}', Outcome.REPAIRED, "gather", None, None),
        ('{"action": "move", "direction": "up"}', Outcome.CHOSEN, "move", None, None),
        ('{"action": "share", "target": 3}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "attack", "target": "Agent 4 or 5"}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "attack", "target": -1}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "attack", "target": true}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "gather", "Action": "reproduce"}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "gather", "action": "reproduce"}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "attack", "target": 1} {"action": "attack", "target": 2}', Outcome.UNREADABLE, "stay", None, None),
        ('{"action": "pray"}', Outcome.UNREADABLE, "stay", None, None),
    ],
)
def test_a_deed_is_read_as_it_is_meant_and_none_is_made_up(
    text: str, outcome: Outcome, action: str, target: int | None, amount: int | None
):
    found = read_furnished_action(Answer(text), FURTHER_ACTIONS)
    assert (found.outcome, found.action, found.target, found.amount) == (outcome, action, target, amount)


def test_a_deed_that_the_world_does_not_have_cannot_be_read():
    assert read_furnished_action(Answer('{"action": "attack", "target": 1}'), ("gather",)).outcome is Outcome.UNREADABLE


LIVELY = {
    "energy": {"start": 6, "loss": 1, "most": 12},
    "food": {"share": 0.5, "amount": 3, "regrow_every": 2, "bite": 2},
    "sharing": True,
    "attack": {"takes": 4, "cost": 1},
    "reproduction": {"needs": 5, "gives": 3, "most": 6},
    "cell_capacity": 2,
    "view": 1,
}


def total(world: FurnishedWorld) -> int:
    """Return all the energy there is, in agents and in food."""
    food = world._food_supply.food.values() if world._food_supply else ()
    return sum(body.energy for body in world._bodies.values()) + sum(food)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 50), data=st.data())
def test_whatever_is_answered_energy_comes_from_growth_alone_and_pictures_come_out_again(seed: int, data: Any):
    made = scenario((0, 0), (0, 1), (1, 0), (-2, -2), **LIVELY)
    world = made.start(seed)
    assert isinstance(world, FurnishedWorld)
    lines: list[LivingStep] = []
    frames = [world.frame()]
    there = set(range(4))
    while not world.finished:
        questions = world.pending()
        assert {one.agent for one in questions} == there
        odd = ['{"action": "share", "target": 99, "amount": 9}', '{"action": "attack", "target": 0}', "", "{"]
        told = [data.draw(st.sampled_from([*one.options, *odd])) for one in questions]
        before, completed = total(world), world.step
        for record in world.advance([Answer(text) for text in told]):
            if isinstance(record, LivingStep):
                lines.append(record)
                assert record.energy_next <= 12
                there -= {record.agent} if record.lost else set()
            there |= {record.agent} if isinstance(record, Birth) else set()
            assert not isinstance(record, Growing) or 0 <= record.amount <= 3
        if world.step > completed:
            grown = 25 if world.step % 2 == 0 else 0
            assert total(world) <= before + grown
            frames.append(world.frame())
    assert list(made.frames(seed, lines)) == frames
