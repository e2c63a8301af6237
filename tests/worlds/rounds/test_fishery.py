"""The fishery: who gets what of a stock that is too small, what is told, who talks when, and when it is over."""

import json
from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry import seeding
from foundry.records import Message, Record
from foundry.worlds.base import Answer, World
from foundry.worlds.rounds.fishery import Catch, Stock, one_by_one, shares, sustainable
from foundry.worlds.rounds.rounds_policies import GreedyCatch, SustainableCatch
from scripted_rounds import records
from small_worlds import fishery


def caught(world: World, *wishes: object) -> list[Record]:
    return list(world.advance([Answer(json.dumps({"action": wish})) for wish in wishes]))


def stocks(written: list[Record]) -> list[Stock]:
    return [stock for stock in written if isinstance(stock, Stock)]


def test_wishes_within_the_stock_are_met_and_what_is_left_doubles():
    world = fishery(agents=2).start(0)
    written = caught(world, 30, 45)
    catches = [(catch.action, catch.caught, catch.utility) for catch in written if isinstance(catch, Catch)]
    assert catches == [(30, 30, 30), (45, 45, 45)]
    assert stocks(written) == [Stock(step=1, before=100, caught=75, outsider=None, after=25, next=50)]
    assert [one.observation["stock"] for one in world.pending()] == [50, 50]
    month = {"step": 1, "stock": 100, "caught": [30, 45], "outsider": None, "left": 25}
    assert world.pending()[0].observation["months"] == [month]
    assert len(world.pending()[0].options) == 51


def test_the_stock_grows_to_its_first_size_at_most_and_unread_wishes_count_as_none():
    assert stocks(caught(fishery(agents=1).start(0), 10))[0].next == 100
    world = fishery(agents=2).start(0)
    first, second, _ = caught(world, 101, 7)
    assert (first.action, first.caught, second.caught) == (None, 0, 7)


@pytest.mark.parametrize(("left", "finished"), [(4, True), (5, False)])
def test_it_is_over_with_fewer_than_five_tons(left: int, finished: bool):
    world = fishery(agents=1).start(0)
    (month,) = stocks(caught(world, 100 - left))
    assert (world.finished, month.after, month.next) == (finished, left, None if finished else 10)


def by_loops(wanted: tuple[int, ...], units: int) -> dict[tuple[int, ...], float]:
    """Return how likely it is who gets what, where each unit goes to one of those that still want some."""
    if units == 0:
        return {(0,) * len(wanted): 1.0}
    found: Counter[tuple[int, ...]] = Counter()
    hungry = [agent for agent, one in enumerate(wanted) if one]
    for agent in hungry:
        rest = tuple(one - (place == agent) for place, one in enumerate(wanted))
        for got, chance in by_loops(rest, units - 1).items():
            found[tuple(one + (place == agent) for place, one in enumerate(got))] += chance / len(hungry)
    return dict(found)


@pytest.mark.parametrize(("wanted", "units"), [((3, 1, 2), 4), ((5, 5), 5), ((0, 4, 1), 3)])
def test_units_go_to_a_random_one_of_those_that_still_want_some(wanted: tuple[int, ...], units: int):
    rng, draws = seeding.stream(0, "test"), 4000
    drawn = Counter(tuple(one_by_one(np.array(wanted), units, rng).tolist()) for _ in range(draws))
    exact = by_loops(wanted, units)
    assert set(drawn) <= set(exact) and sum(exact.values()) == pytest.approx(1)
    for got, chance in exact.items():
        assert abs(drawn[got] - draws * chance) < 5 * np.sqrt(draws * chance * (1 - chance)) + 1


def test_in_proportion_everybody_gets_its_part_and_the_rest_is_drawn_among_the_rounded():
    rng = seeding.stream(0, "test")
    assert shares([100, 50, 50], 100, "proportional", rng) == [50, 25, 25]
    drawn = Counter(tuple(shares([100, 100, 1], 100, "proportional", rng)) for _ in range(400))
    assert set(drawn) == {(50, 50, 0), (51, 49, 0), (49, 51, 0), (50, 49, 1), (49, 50, 1)}
    halves = {tuple(shares([2, 1, 1], 2, "proportional", rng)) for _ in range(40)}
    assert halves == {(1, 1, 0), (1, 0, 1)}, "nothing of the rest goes to who was not rounded down"
    assert abs(drawn[50, 50, 0] - 400 * 51 * 51 * 2 / (103 * 102)) < 5 * 10, "by what is still wanted: 51, 51 and 1"


@given(
    st.lists(st.integers(0, 100), min_size=1, max_size=8),
    st.integers(0, 100),
    st.sampled_from(["stochastic", "proportional"]),
    st.integers(0, 99),
)
def test_nobody_gets_more_than_it_wants_and_all_of_a_stock_that_is_wanted_is_given(
    wishes: list[int], stock: int, sharing: str, seed: int
):
    wanted = [min(wish, stock) for wish in wishes]
    got = shares(wanted, stock, sharing, seeding.stream(seed, "test"))
    assert all(0 <= one <= most for one, most in zip(got, wanted, strict=True))
    assert sum(got) == min(sum(wanted), stock)


@settings(max_examples=25)
@given(
    st.integers(0, 99),
    st.sampled_from(["stochastic", "proportional"]),
    st.integers(0, 4),
    st.none() | st.fixed_dictionaries({"from": st.integers(1, 3), "catch": st.integers(0, 60)}),
    st.lists(st.sampled_from(["", "12", '{"action": 3}', '{"action": 999}', "no", '{"message": "hm"}']), min_size=1),
)
def test_no_ton_is_lost_or_made_whatever_is_answered(
    seed: int, sharing: str, talk: int, outsider: Any, said: list[str]
):
    world = fishery(agents=3, steps=4, sharing=sharing, talk=talk, outsider=outsider).start(seed)
    written, asked = list(world.opening()), 0
    while not world.finished:
        written += world.advance([Answer(said[(asked + place) % len(said)]) for place, _ in enumerate(world.pending())])
        asked += 1
    months = stocks(written)
    assert [month.step for month in months] == list(range(1, world.step + 1))
    for month, following in zip(months, [*months[1:], None], strict=True):
        catches = [catch for catch in written if isinstance(catch, Catch) and catch.kind == "catch"]
        assert month.caught == sum(catch.caught or 0 for catch in catches if catch.step == month.step)
        assert month.before == month.caught + (month.outsider or 0) + month.after
        assert month.next == (min(2 * month.after, 100) if month.after >= 5 else None)
        assert following is None or following.before == month.next


def test_all_talk_in_drawn_order_round_and_round_and_hear_what_was_said():
    world = fishery(agents=2, talk=3, steps=2).start(0)
    caught(world, 1, 1)
    order, texts = [], ["a", "b", "c"]
    for text in texts:
        (question,) = world.pending()
        order.append(question.agent)
        assert question.observation["stock"] == 98, "what the catch left"
        assert [one["text"] for one in question.observation["talk"]] == texts[: texts.index(text)]
        written = list(world.advance([Answer(json.dumps({"message": text}))]))
        assert [message.recipient for message in written if isinstance(message, Message)] == [1 - question.agent]
    assert order == [order[0], 1 - order[0], order[0]]
    assert world.pending()[0].kind == "catch"
    assert [one["agent"] for one in world.pending()[0].observation["talk"]] == order
    assert len({one.sampling_seed(0) for one in world.pending()}) == 2


def test_a_conversation_ends_when_all_were_silent_in_turn():
    world = fishery(agents=2, talk=9, steps=2).start(0)
    caught(world, 1, 1)
    for text in ("", '{"message": "well"}', '{"message": null}', "{}"):
        assert world.pending()[0].kind == "talk"
        world.advance([Answer(text)])
    assert world.pending()[0].kind == "catch"


def test_the_sustainable_share_is_told_where_it_is_set_and_grows_the_stock_back():
    assert fishery().start(0).pending()[0].observation["sustainable"] is None
    assert fishery(universalisation=True).start(0).pending()[0].observation["sustainable"] == 10


@given(st.integers(5, 1000), st.integers(1, 20))
def test_the_sustainable_share_is_the_most_that_leaves_half_of_the_stock(stock: int, agents: int):
    most = sustainable(stock, agents)
    assert 2 * (stock - most * agents) >= stock > 2 * (stock - (most + 1) * agents)


def test_an_outsider_fishes_from_its_month_on_no_more_than_there_is_and_is_asked_nothing():
    world = fishery(agents=2, outsider={"from": 2, "catch": 60}).start(0)
    (first,) = stocks(caught(world, 10, 10))
    (second,) = stocks(caught(world, 5, 5))
    assert (first.outsider, first.next, second.outsider, second.after) == (None, 100, 60, 30)
    assert len(world.pending()) == 2 and world.pending()[0].observation["months"][1]["outsider"] == 60
    world = fishery(agents=1, sharing="proportional", outsider={"from": 1, "catch": 10_000}).start(0)
    assert stocks(caught(world, 100)) == [Stock(step=1, before=100, caught=50, outsider=50, after=0, next=None)]


def test_who_takes_all_ends_it_at_once_and_who_takes_the_sustainable_share_never():
    greedy = stocks(list(records(fishery(talk=10), GreedyCatch("greedy"), 3)))
    assert greedy == [Stock(step=1, before=100, caught=100, outsider=None, after=0, next=None)]
    lasting = stocks(list(records(fishery(talk=10), SustainableCatch("sustainable"), 3)))
    months = range(1, 13)
    assert lasting == [Stock(step=month, before=100, caught=50, outsider=None, after=50, next=100) for month in months]
