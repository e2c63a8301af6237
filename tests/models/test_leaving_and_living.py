"""Policies that leave by exits or live on food, on observations made by hand."""

from __future__ import annotations

import json
from typing import Any

import pytest

from foundry import seeding
from foundry.worlds.grid.grid_policies import Fighter, FollowLeader, Forager, Sharer, ShortestPath

HERE = {"agent": 3, "x": 0, "y": 0, "half_size": 9, "persona": {}, "fires": [], "memory": [], "received": []}
HERE |= {"open": ["up", "down", "left", "right"], "neighbours": [], "exits": [], "seen": [], "energy": 20, "food": []}
LEADER = {"id": 0, "x": 3, "y": 0, "persona": {"role": "leader"}}


def decided(policy: Any, **observed: Any) -> dict[str, Any]:
    """Return what a policy decides, without its reasons."""
    found = json.loads(policy.action({**HERE, **observed}, seeding.stream(0, "test")))
    return {name: value for name, value in found.items() if name not in ("memory", "reasoning")}


def go(way: str) -> dict[str, str]:
    return {"action": "move", "direction": way}


def test_the_oracle_takes_its_way_out_and_stays_where_there_is_none():
    assert decided(ShortestPath("oracle"), ways_out=["down"]) == go("down")
    assert decided(ShortestPath("oracle"), ways_out=[]) == {"action": "stay"}
    assert decided(ShortestPath("oracle")) == {"action": "stay"}


@pytest.mark.parametrize(
    ("observed", "way"),
    [
        ({"seen": [LEADER], "ways_known": ["up"]}, "right"),
        ({"seen": [LEADER], "ways_known": ["up"], "persona": {"role": "leader"}}, "up"),
        ({"seen": [LEADER], "ways_known": ["up"], "exits": [{"seen": True}]}, "up"),
        ({"ways_known": ["down"], "exits": [{"seen": False}]}, "down"),
        ({"open": ["left"]}, "left"),
        ({"seen": [LEADER], "open": ["left"]}, "left"),
    ],
)
def test_a_follower_goes_to_a_leader_it_sees_and_to_an_exit_it_sees_or_knows(observed: dict[str, Any], way: str):
    assert decided(FollowLeader("follower"), **observed) == go(way)


def test_a_follower_warns_of_fires_and_says_nothing_without_any():
    fire = {"name": "fire", "x": 1, "y": 1, "radius": 3}
    near = {**HERE, "neighbours": [LEADER]}
    assert json.loads(FollowLeader("f").message(near, seeding.stream(0, "test")))["message"] is None
    assert (
        "fire" in json.loads(FollowLeader("f").message({**near, "fires": [fire]}, seeding.stream(0, "test")))["message"]
    )


@pytest.mark.parametrize(
    ("food", "decision"),
    [
        ([{"x": 0, "y": 0, "amount": 1}, {"x": 1, "y": 0, "amount": 9}], {"action": "gather"}),
        ([{"x": 0, "y": 2, "amount": 9}, {"x": -1, "y": 0, "amount": 1}], go("left")),
        ([{"x": 0, "y": 1, "amount": 2}, {"x": -1, "y": 0, "amount": 3}], go("left")),
        ([{"x": -1, "y": 0, "amount": 3}, {"x": 0, "y": 1, "amount": 3}], go("up")),
    ],
)
def test_a_forager_gathers_the_nearest_and_of_that_the_most(food: list[dict[str, int]], decision: dict[str, str]):
    for policy in (Forager("forager"), Sharer("sharer"), Fighter("fighter")):
        assert decided(policy, food=food) == decision


def test_a_forager_reproduces_and_a_sharer_gives_when_they_have_enough_and_a_fighter_attacks():
    birth = {"needs": 20, "gives": 5}
    assert decided(Forager("forager"), reproduction=birth) == {"action": "reproduce"}
    assert decided(Forager("forager"), reproduction=birth, energy=19)["action"] == "move"
    give = {"action": "share", "target": 7, "amount": 5}
    assert decided(Sharer("sharer"), touchable=[7], energy=26) == give
    assert decided(Sharer("sharer"), touchable=[7], energy=25)["action"] == "move"
    assert decided(Fighter("fighter"), touchable=[7], energy=1) == {"action": "attack", "target": 7}


def test_all_of_them_can_stand_in_a_world_that_has_none_of_this():
    plain = {name: HERE[name] for name in ("agent", "x", "y", "half_size", "persona", "fires", "memory", "received")}
    for policy in (FollowLeader("f"), Forager("g"), Sharer("s"), Fighter("a")):
        found = json.loads(policy.action({**plain, "neighbours": []}, seeding.stream(0, "test")))
        assert found["action"] in ("stay", "move")
