"""Walls, exits, crowds, sight, fires that spread, energy, food and attacks, against worlds worked out by hand."""

import json
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.errors import InputError
from foundry.records import Outcome
from foundry.worlds.base import Answer, Recorded
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Explicit
from foundry.worlds.grid.parts.actions import read_furnished_action
from foundry.worlds.grid.parts.parts_records import Birth, Burning, FurnishedStep, Growing, LivingStep
from foundry.worlds.grid.parts.parts_settings import FURTHER_ACTIONS
from foundry.worlds.grid.parts.parts_world import FurnishedWorld
from foundry.worlds.grid.parts.terrain import Ground

SILENT = Answer(json.dumps({"message": None, "reasoning": ""}))
NORTH = {"name": "north", "cells": [[0, 2]]}


def scenario(*cells: tuple[int, int], **changes: Any) -> GridScenario:
    plain = {"name": "small", "half_size": 2, "agents": len(cells), "steps": 9, "places": []}
    plain |= {"communication_distance": 9, "history": {"memory": 1, "messages": 1}}
    return GridScenario(layout=Explicit(positions=[list(cell) for cell in cells]), **{**plain, **changes})


def do(*actions: dict[str, Any]) -> list[Answer]:
    return [Answer(json.dumps({**action, "memory": "", "reasoning": ""})) for action in actions]


def go(*ways: str) -> list[dict[str, Any]]:
    return [{"action": "stay"} if way == "stay" else {"action": "move", "direction": way} for way in ways]


def lived(world: Any, *actions: dict[str, Any]) -> list[Any]:
    """Let a step go by in silence and return its lines."""
    world.advance([SILENT] * len(world.pending()))
    return [line for line in world.advance(do(*actions)) if isinstance(line, FurnishedStep)]


def step(world: Any, *ways: str) -> list[Any]:
    return lived(world, *go(*ways))


def test_a_wall_stops_a_move_as_the_edge_does_and_each_says_which_it_was():
    world = scenario((0, 0), (2, 0), walls=[[[1, -2], [1, 2]]]).start(0)
    lines = step(world, "right", "right")
    assert [(line.moved, line.blocked) for line in lines] == [(False, "wall"), (False, "edge")]


def test_who_moves_onto_an_exit_is_gone_and_is_asked_no_more():
    world = scenario((0, 1), (0, -2), exits=[NORTH]).start(0)
    first = step(world, "up", "stay")
    assert first[0].left == "north" and first[1].left is None
    assert [question.agent for question in world.pending()] == [1]
    assert world.pending()[0].observation["neighbours"] == []


def test_an_exit_lets_out_so_many_a_step_and_the_others_wait():
    world = scenario((0, 1), (0, 1), (0, 1), exits=[{**NORTH, "capacity": 2}]).start(0)
    lines = step(world, "up", "up", "up")
    assert sorted(str(line.left) for line in lines) == ["None", "north", "north"]
    assert [line.blocked for line in lines if line.left is None] == ["exit"]
    assert [line.left for line in step(world, "up")] == ["north"]
    assert world.finished


def test_who_is_first_at_a_narrow_exit_is_drawn_by_the_seed():
    firsts = set()
    for seed in range(8):
        world = scenario((0, 1), (0, 1), exits=[{**NORTH, "capacity": 1}]).start(seed)
        firsts.add(next(line.agent for line in step(world, "up", "up") if line.left))
    assert firsts == {0, 1}


def test_a_full_cell_is_not_entered_unless_who_stands_there_goes_on_and_two_do_not_change_places():
    world = scenario((0, 0), (1, 0), (2, 0), cell_capacity=1).start(0)
    assert [line.blocked for line in step(world, "right", "stay", "stay")] == ["agents", None, None]
    assert [line.moved for line in step(world, "right", "right", "up")] == [True, True, True]
    world = scenario((0, 0), (1, 0), cell_capacity=1).start(0)
    assert [line.blocked for line in step(world, "right", "left")] == ["agents", "agents"]


def test_agents_see_as_far_as_their_view_and_not_behind_walls():
    world = scenario((0, 0), (2, 0), walls=[[[1, -1], [1, 1]]], view=2, exits=[NORTH]).start(0)
    world.advance([SILENT, SILENT])
    seen = world.pending()[0].observation
    assert seen["window"] == ["..E??", "...#?", "..@#?", "...#?", "...??"]
    assert seen["seen"] == [] and seen["open"] == ["up", "down", "left"]
    assert world.pending()[1].observation["neighbours"] == [], "walls stop talk too"


@pytest.mark.parametrize("block", [[], ["sight"], ["talk"]])
def test_what_walls_block_is_a_setting(block: list[str]):
    world = scenario((0, 0), (2, 0), walls=[[[1, -1], [1, 1]]], walls_block=block).start(0)
    seen = world.pending()[0].observation
    assert bool(seen["seen"]) == ("sight" not in block)
    assert bool(seen["neighbours"]) == ("talk" not in block)


def test_an_exit_is_known_to_its_share_to_who_sees_it_and_to_leaders_and_its_crowd_is_of_others():
    far = {"name": "far", "cells": [[-2, -2]], "known": 0}
    changes = {"view": 1, "exits": [{**NORTH, "known": False}, far], "leaders": {"number": 1}}
    world = scenario((2, 0), (0, 1), (2, -2), **changes).start(0)
    known = [[one["name"] for one in question.observation["exits"]] for question in world.pending()]
    assert known == [["north", "far"], ["north"], []]
    assert [question.observation["persona"]["role"] for question in world.pending()] == ["leader", "visitor", "visitor"]
    world = scenario((0, 1), (1, 1), (-2, -2), exits=[NORTH]).start(0)
    assert [question.observation["exits"][0]["agents"] for question in world.pending()] == [1, 1, 2]


def test_a_way_leads_round_an_exit_that_is_not_known():
    exits = [{"name": "near", "cells": [[0, 0]], "known": 0}, {"name": "far", "cells": [[0, -2]]}]
    world = scenario((0, 2), exits=exits, view=1, walls=[[[-1, 1], [-1, 1]], [[1, 1], [1, 1]]]).start(0)
    world.advance([SILENT])
    assert world.pending()[0].told["ways_known"] == ["left", "right"]


def test_sight_is_the_same_both_ways():
    ground = Ground(4, [((-1, 0), (1, 0)), ((2, 2), (2, 3))], [])
    cells = [(x, y) for x in range(-4, 5) for y in range(-4, 5)]
    assert all(ground.is_clear(cell, other) == ground.is_clear(other, cell) for cell in cells for other in cells)


def test_a_fire_that_always_spreads_burns_one_ring_more_a_step_and_kills_who_stands_there():
    fire = {"name": "fire", "start": 1, "position": [0, 0], "intensity": 1, "radius": 9, "spread": 1, "risk": 1}
    world = scenario((2, 0), (2, 2), fires=[fire]).start(0)
    assert [burning for burning in world.opening() if isinstance(burning, Burning)] == [
        Burning(step=1, x=0, y=0, fire="fire")
    ]
    assert [line.lost for line in step(world, "stay", "stay")] == [None, None]
    assert len(world.pending()[0].observation["burning"]) == 5
    assert world.pending()[0].observation["fires"][0]["distance"] == 1.0, "from the nearest flame"
    assert [line.lost for line in step(world, "stay", "stay")] == [None, None]
    assert [line.lost for line in step(world, "stay", "stay")] == ["fire", None]
    assert world.frame().furniture.gone == (("fire", 1),)


def test_a_cell_burns_with_the_fire_that_reached_it_first():
    plain = {"start": 1, "intensity": 1, "radius": 9, "spread": 1}
    fires = [{"name": "first", "position": [-1, 0], **plain}, {"name": "second", "position": [1, 0], **plain}]
    world = scenario((2, 2), fires=fires).start(0)
    world.advance([SILENT])
    caught = [burning for burning in world.advance(do(*go("stay"))) if isinstance(burning, Burning)]
    assert [burning.fire for burning in caught if (burning.x, burning.y) == (0, 0)] == ["first"]
    plain = {"intensity": 1, "radius": 9}
    first = {"name": "first", "start": 1, "position": [0, 0], "spread": 1, **plain}
    second = {"name": "second", "start": 3, "position": [0, 1], **plain}
    world = scenario((2, 2), fires=[first, second]).start(0)
    for _ in range(3):
        step(world, "stay")
    assert [one["name"] for one in world.pending()[0].observation["fires"]] == ["first"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"walls": [[[-2, 0], [2, 0]]], "exits": [NORTH]}, "where nobody can start"),
        ({"walls": [[[-2, 1], [2, 2]]], "exits": [NORTH]}, "Exit 'north' and a wall share the cell [0, 2]"),
        ({"walls": [[[-2, 1], [2, 1]], [[-1, 2], [-1, 2]], [[1, 2], [1, 2]]], "exits": [NORTH]}, "make a gap"),
        ({"walls": [[[-9, -9], [9, 9]]]}, "world.walls[0] is at [-9, -9], beyond the grid"),
        ({"exits": [{**NORTH, "width": 1}]}, "width"),
        ({"sharing": True}, "Set world.energy"),
        ({"leaders": {"number": 2}}, "world.leaders.number=2"),
        ({"energy": {"start": 5, "most": 4}}, "world.energy.start=5"),
        ({"walls_block": ["smell"]}, "world.walls_block"),
    ],
)
def test_parts_that_do_not_fit_are_refused_in_one_line(changes: dict[str, Any], words: str):
    with pytest.raises(InputError) as refused:
        scenario((0, -1), **changes)
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_agents_start_where_there_is_room_and_a_way_out():
    crowded = scenario((0, 0), (0, 0), (0, 0), cell_capacity=1).start(0)
    cells = {(question.observation["x"], question.observation["y"]) for question in crowded.pending()}
    assert len(cells) == 3 and (0, 0) in cells


def test_a_world_without_further_parts_writes_what_it_always_wrote_and_may_ask_ahead():
    plain = scenario((0, 0))
    assert not plain.settings.furnished and "lost" not in plain.declared().streams["steps"]
    assert set(plain.start(0).pending()[0].observation) & {"window", "exits", "energy"} == set()
    assert scenario((0, 0)).start(0).ahead() is not None
    for part in ({"walls": [[[1, 1], [1, 1]]]}, {"exits": [NORTH]}, {"view": 2}, {"energy": {"start": 3}}):
        assert scenario((0, 0), **part).start(0).ahead() is None


def room() -> GridScenario:
    fire = {"name": "fire", "start": 2, "position": [-1, -1], "intensity": 1, "radius": 3, "spread": 0.3, "risk": 0.5}
    exits = [{**NORTH, "capacity": 1}]
    cells = [(0, 0), (0, 0), (1, 1), (-2, -2)]
    return scenario(*cells, exits=exits, fires=[fire], walls=[[[1, 0], [2, 0]]], cell_capacity=2, view=2)


def test_a_picture_is_drawn_again_byte_for_byte():
    made = room()
    world = made.start(1)
    lines = [*step(world, "up", "up", "left", "stay"), *step(world, *["up"] * len(world.pending()))]
    content = b"".join(msgspec.json.encode(line) + b"\n" for line in lines)
    assert made.redraw(Recorded(1, content, b"", lambda _: None)).draw(2) == world.draw()


ENERGY = {"start": 10, "loss": 1}
FIELD = {"share": 1, "amount": 4, "bite": 3}


STAY = {"action": "stay"}
GATHER = {"action": "gather"}


def test_energy_is_lost_in_every_step_and_who_has_none_dies():
    world = scenario((0, 0), energy={"start": 2, "loss": 1}).start(0)
    assert [(line.energy, line.energy_next, line.lost) for line in lived(world, STAY)] == [(2, 1, None)]
    assert [(line.energy, line.energy_next, line.lost) for line in lived(world, STAY)] == [(1, 0, "energy")]
    assert world.finished and world.pending() == ()


def test_what_is_gathered_is_a_bite_of_what_there_is_grows_again_and_gives_nobody_more_than_the_most():
    world = scenario((0, 0), energy=ENERGY, food={**FIELD, "regrow_every": 2}).start(0)
    living_steps = [lived(world, GATHER)[0] for _ in range(3)]
    assert [line.food for line in living_steps] == [4, 1, 1], (
        "3 of 4 are taken, then 1, and one grew at the end of step 2"
    )
    assert [line.amount for line in living_steps] == [3, 1, 1]
    world = scenario((0, 0), energy={"start": 10, "most": 11}, food=FIELD).start(0)
    assert lived(world, GATHER)[0].amount == 1
    assert world.pending()[0].observation["food"][12] == {"x": 0, "y": 0, "amount": 3}


def test_energy_is_shared_within_reach_alone_and_no_more_than_who_is_given_it_can_have():
    world = scenario((0, 0), (1, 1), (0, 2), energy=ENERGY, sharing=True).start(0)
    give = {"action": "share", "amount": 4}
    lines = lived(world, {**give, "target": 1}, {**give, "target": 2, "amount": 1}, {**give, "target": 0})
    assert [line.energy_next for line in lines] == [5, 12, 10]
    assert [line.amount for line in lines] == [4, 1, 0]
    world = scenario((0, 0), (1, 1), energy={"start": 10, "most": 11}, sharing=True).start(0)
    lines = lived(world, {"action": "share", "target": 1, "amount": 4}, STAY)
    assert [(line.energy_next, line.amount) for line in lines] == [(8, 1), (10, 0)]


def test_an_attack_takes_what_there_is_and_costs_the_attacker_who_may_be_robbed_itself():
    world = scenario((0, 0), (0, 1), energy={"start": 6, "loss": 1}, attack={"takes": 9, "cost": 2}).start(0)
    lines = lived(world, {"action": "attack", "target": 1}, STAY)
    assert [(line.energy_next, line.lost) for line in lines] == [(9, None), (0, "attack")]
    world = scenario((0, 0), (0, 1), energy={"start": 6, "loss": 1}, attack={"takes": 9, "cost": 2}).start(0)
    lines = lived(world, {"action": "attack", "target": 1}, {"action": "attack", "target": 0})
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
    lines = lived(world, *[{"action": "reproduce"}] * 2)
    assert sum(line.born is not None for line in lines) == 1 and len(world.pending()) == 3


def test_an_order_is_told_from_its_step_on():
    order = {"text": "Go left.", "target": [[-2, -2], [-2, 2]], "start": 2}
    world = scenario((0, 0), energy=ENERGY, order=order).start(0)
    assert world.pending()[0].observation["order"] is None
    lived(world, STAY)
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
    furnished_action = read_furnished_action(Answer(text), FURTHER_ACTIONS)
    assert (furnished_action.outcome, furnished_action.action, furnished_action.target, furnished_action.amount) == (
        outcome,
        action,
        target,
        amount,
    )


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
    food = world._food_supply.food.values() if world._food_supply else ()
    return sum(body.energy for body in world._bodies.values()) + sum(food)


@pytest.mark.parametrize("made", [room(), scenario((0, 0), (0, 1), (1, 0), (-2, -2), **LIVELY)], ids=["room", "field"])
@settings(max_examples=6)
@given(seed=st.integers(0, 50), data=st.data())
def test_whatever_is_answered_all_are_asked_until_they_are_gone_and_energy_comes_from_growth_alone(
    made: GridScenario, seed: int, data: Any
):
    world, lines, there = made.start(seed), list[FurnishedStep](), set(range(4))
    assert isinstance(world, FurnishedWorld)
    frames = [world.frame()]
    odd = ['{"action": "share", "target": 99, "amount": 9}', '{"action": "attack", "target": 0}', "", "{"]
    while not world.finished:
        questions = world.pending()
        assert [question.agent for question in questions] == sorted(there)
        told = [data.draw(st.sampled_from([*question.options, *odd])) for question in questions]
        before, completed = total(world), world.step
        for record in world.advance([Answer(text) for text in told]):
            if isinstance(record, FurnishedStep):
                lines.append(record)
                there -= {record.agent} if record.left or record.lost else set()
            there |= {record.agent} if isinstance(record, Birth) else set()
            assert not isinstance(record, LivingStep) or record.energy_next <= 12
            assert not isinstance(record, Growing) or 0 <= record.amount <= 3
        if world.step > completed:
            assert total(world) <= before + (25 if world.step % 2 == 0 else 0)
            frames.append(world.frame())
    assert list(made.frames(seed, lines)) == frames, "pictures come out again"
