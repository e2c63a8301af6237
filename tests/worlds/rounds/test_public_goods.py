"""Public goods: what a pot returns, what punishment costs, and that no token comes from nowhere."""

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.records import RoundStep
from foundry.worlds.base import Answer, World
from foundry.worlds.rounds.public_goods import Giving, Pot
from foundry.worlds.rounds.reading import deciding
from small_worlds import goods, punished


def payoffs(world: World, *texts: str) -> list[float | None]:
    records = world.advance([Answer(text) for text in texts])
    return [record.utility for record in records if isinstance(record, Giving) and record.kind == "contribution"]


def give(*tokens: int) -> list[str]:
    return [deciding(token) for token in tokens]


def test_the_pot_is_doubled_and_shared_by_all_whatever_each_gave():
    world = goods().start(0)
    assert payoffs(world, *give(20, 10, 0, 0)) == [15, 25, 35, 35]
    assert payoffs(world, *give(20, 20, 20, 20)) == [40] * 4
    assert payoffs(world, *give(0, 0, 0, 0)) == [20] * 4


def test_each_is_told_its_own_part_and_the_pot_and_has_as_many_tokens_anew():
    world = goods().start(0)
    payoffs(world, *give(20, 10, 0, 0))
    told = world.pending()[1].observation
    assert told["tokens"] == 20 and told["rounds"] == [{"given": 10, "pot": 30, "payoff": 25}]


def test_what_is_carried_over_can_be_given_and_the_payoff_is_the_gain():
    world = goods(reset=False).start(0)
    assert payoffs(world, *give(20, 20, 20, 1)) == [10.5, 10.5, 10.5, 29.5]
    assert [one.observation["tokens"] for one in world.pending()] == [30.5, 30.5, 30.5, 49.5]
    assert payoffs(world, *give(31, 30, 0, 49)) == [39.5, 9.5, 39.5, -9.5], "nobody gives more than it has"


@pytest.mark.parametrize("reply", ["-1", "21", "2.5", "all of it", ""])
def test_what_is_no_number_of_tokens_gives_nothing(reply: str):
    world = goods().start(0)
    assert payoffs(world, reply, *give(0, 0, 0)) == [20] * 4


def test_punishment_costs_who_punishes_and_takes_from_who_is_punished():
    world = punished().start(0)
    payoffs(world, *give(20, 20, 20, 0))
    asked = world.pending()
    assert {one.kind for one in asked} == {"punishment"}
    assert asked[2].observation["given"] == [20, 20, 20, 0] and asked[2].observation["tokens"] == 30
    assert [json.loads(option)["action"] for option in asked[3].options] == ["nobody", "agent 0", "agent 1", "agent 2"]
    found = payoffs(world, deciding("agent 3"), "Agent 3!", deciding("nobody"), deciding("agent 0"))
    assert found == [26, 29, 30, 43]
    (last,) = world.pending()[3].observation["rounds"]
    assert (last["punished"], last["punished_by"], last["payoff"]) == (0, 2, 43)


def test_nobody_punishes_itself_or_with_what_it_has_not_or_loses_more_than_it_has():
    world = punished(cost=30, loss=1000).start(0)
    payoffs(world, *give(20, 0, 0, 0))
    assert [len(one.options) for one in world.pending()] == [1, 4, 4, 4]
    assert payoffs(world, *map(deciding, ("agent 1", "agent 1", "agent 1", "nobody"))) == [10, 0, 0, 30]


@settings(max_examples=20)
@given(data=st.data(), agents=st.integers(2, 5), reset=st.booleans(), multiplier=st.sampled_from([1, 1.6, 2]))
def test_tokens_come_from_the_multiplied_pot_and_go_to_punishment_alone(
    data: st.DataObject, agents: int, reset: bool, multiplier: float
):
    world = punished(agents=agents, reset=reset, multiplier=multiplier).start(0)
    had = 20.0 * agents
    while not world.finished:
        asked = world.pending()
        replies = [data.draw(st.sampled_from([*one.options[:3], one.options[-1], "none", ""])) for one in asked]
        before = [one.observation["tokens"] for one in asked]
        records = world.advance([Answer(reply) for reply in replies])
        pots = [record for record in records if isinstance(record, Pot)]
        if asked[0].kind == "contribution":
            had, (pot,) = sum(before), pots
            left = had + pot.returned - pot.given
            continue
        assert sum(before) == pytest.approx(left)
        whom = [world_line.action for world_line in world_lines(records, "punishment")]
        got = sum(world_line.utility or 0 for world_line in world_lines(records, "contribution")) + (
            0 if reset else had
        )
        paid = sum(one not in (None, "nobody") for one in whom)
        assert left - paid * (1 + 3) - 1e-6 <= got <= left - paid + 1e-6


def world_lines(records: Any, kind: str) -> list[RoundStep]:
    return [record for record in records if isinstance(record, RoundStep) and record.kind == kind]
