"""Edits of what games show: numbers that are told follow from each other as they did before."""

import json
from collections.abc import Callable, Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import small_worlds
from foundry.declared import Actions
from foundry.errors import InputError
from foundry.worlds.base import Answer, Question, Scenario
from foundry.worlds.probe.editing import find_edit, find_edits, observing
from foundry.worlds.rounds.naming import NamingGame
from foundry.worlds.rounds.reading import deciding, options_of
from foundry.worlds.rounds.table import RoundQuestion
from small_worlds import bar, fishery, goods, punished

AGES = {"age": {"young": 1, "old": 1}, "trade": {"baker": 1, "smith": 1}}


def naming(**changes: Any) -> NamingGame:
    return small_worlds.naming(**({"agents": 2, "names": ["a", "b", "c"], "memory": 5} | changes))


def asked_after(scenario: Scenario, *rounds: Sequence[Any], seed: int = 0) -> list[Question]:
    world = scenario.start(seed)
    for decisions in rounds:
        world.advance([Answer(deciding(decisions[question.agent])) for question in world.pending()])
    return sorted(world.pending(), key=lambda question: question.agent)


def edited(scenario: Scenario, name: str, question: Question, others: Sequence[Question] = ()) -> dict[str, Any]:
    changed = find_edit(name, scenario).applied(question, others)
    assert changed.asked == question.asked
    return dict(changed.observation)


def hold_against_what_would_be_told(
    scenario: Scenario, rounds: Sequence[Sequence[Any]], flipped: Callable[[Sequence[Any]], Sequence[Any]]
) -> None:
    """Hold what each perceives of others that did the opposite against what it perceives where they really do."""
    for agent, question in enumerate(asked_after(scenario, *rounds)):
        done = [one if who == agent else flipped(one) for who, one in enumerate(zip(*rounds, strict=True))]
        expected = asked_after(scenario, *zip(*done, strict=True))[agent]
        changed = find_edit("others_went", scenario).applied(question) or question
        assert changed.observation == expected.observation


@given(st.lists(st.lists(st.sampled_from(["go", "stay"]), min_size=5, max_size=5), min_size=1, max_size=3))
def test_who_stayed_went_and_the_bar_paid_as_it_would_have(rounds: list[list[str]]):
    for reports in ("explicit", "implicit"):
        scenario = bar(steps=4, reports=reports)
        hold_against_what_would_be_told(scenario, rounds, lambda did: ["stay" if one == "go" else "go" for one in did])


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=1, max_size=3))
def test_the_other_put_least_into_the_pot_where_it_put_most_and_the_share_follows(rounds: list[tuple[int, int]]):
    scenario = goods(agents=2, multiplier=1.5, steps=4)
    hold_against_what_would_be_told(scenario, rounds, lambda gave: [max(gave) - one for one in gave])


NAMES = {"a": "b", "b": "c", "c": "a", None: None}


@given(st.lists(st.tuples(st.sampled_from([*NAMES]), st.sampled_from([*NAMES])), min_size=1, max_size=3))
def test_the_other_said_the_next_name_and_the_points_follow(rounds: list[tuple[str | None, str | None]]):
    hold_against_what_would_be_told(naming(steps=4), rounds, lambda said: [NAMES[one] for one in said])


def test_where_nothing_would_follow_nobody_did_the_opposite():
    (told, *_) = asked_after(bar(reports="attendance"), ["go", "go", "stay", "stay", "stay"])
    assert edited(bar(), "others_went", told)["evenings"] == [{"went": 3, "action": None, "utility": None}]
    whom = asked_after(punished(), [15, 10, 0, 4])[0]
    assert edited(punished(), "others_went", whom)["given"] == [15, 0, 10, 6]
    for scenario, decisions in ((goods(reset=False), [5, 10, 10, 10]), (naming(protocol="speaker"), ["a", "a"])):
        for question in (question for seed in range(5) for question in asked_after(scenario, decisions, seed=seed)):
            assert find_edit("others_went", scenario).applied(question) is None


def test_who_is_alone_keeps_its_number_and_points_that_are_decided_about_stay():
    assert find_edit("scale_payoffs", goods()).applied(asked_after(goods(), [1] * 4)[0]) is None
    legal = Actions(labels=("up", "down"), whole=False)
    alone = RoundQuestion(1, 0, "turn", {"agent": 0, "agents": 1}, options=options_of(legal), legal=legal)
    assert find_edit("rename_agents", bar()).applied(alone) is None


def test_agents_are_numbered_from_the_end_and_so_are_those_to_choose_from():
    question = asked_after(punished(), [5, 10, 0, 4])[1]
    renaming = find_edit("rename_agents", punished())
    changed = renaming.applied(question)
    assert isinstance(changed, RoundQuestion) and changed.legal and changed.agent == question.agent == 1
    assert (changed.observation["agent"], changed.observation["given"]) == (2, [4, 0, 10, 5])
    assert set(changed.legal.labels) == {"nobody", "agent 3", "agent 1", "agent 0"}
    assert renaming.described(punished())["expected"]["agent 3"] == "agent 0"
    assert [json.loads(option)["action"] for option in changed.options] == list(changed.legal.labels)
    reading = punished().read(changed, Answer(deciding("agent 1")))
    assert reading.action == "agent 1"
    assert punished().read(changed, Answer(deciding("agent 2"))).action is None


def test_months_and_talk_of_a_fishery_name_the_same_agents_under_other_numbers():
    lake = fishery(agents=3, steps=2, stock=90, sharing="proportional", talk=3)
    question = asked_after(lake, [1, 2, 3])[0]
    found = edited(lake, "rename_agents", question)
    assert found["months"][0]["caught"] == [3, 2, 1] and found["agent"] == 2 - question.agent
    assert [lake.payoffs(question) for question in asked_after(lake, [1, 2, 3])] == [[[1, 2, 3][question.agent]]]


def test_options_are_turned_round_and_each_can_come_first():
    places = find_edits("permute_options.each", naming())
    assert [edit.name for edit in places] == ["permute_options.2", "permute_options.3"]
    for question in (question for seed in range(9) for question in asked_after(naming(), seed=seed)):
        names = question.observation["names"]
        turns = [[*names[place:], *names[:place]] for place in (1, 2)]
        assert edited(naming(), "permute_options", question)["names"] in turns
        assert [edit.applied(question).observation["names"] for edit in places] == turns
    listed = Question(1, 0, "turn", {"choices": ["up", "down"]})
    assert edited(naming(), "permute_options", listed) == {"choices": ["down", "up"]}
    assert places[1].applied(listed) is None, "there is no third to come first"
    assert find_edit("permute_options", bar()).applied(asked_after(bar())[0]) is None


def differing(question: Question, other: Question | None) -> set[str]:
    return {key for key, value in question.observation["persona"].items() if other.observation["persona"][key] != value}


def test_somebody_else_is_asked_or_somebody_who_differs_in_one_attribute():
    world = bar(personas=AGES, agents=12)
    asked = asked_after(world)
    whole, age, trade = (find_edit(f"swap_persona{part}", world) for part in ("", ".age", ".trade"))
    assert [edit.name for edit in find_edits("swap_persona.each", world)] == [age.name, trade.name]
    for question in asked:
        assert differing(question, age.applied(question, asked)) == {"age"}
        assert differing(question, trade.applied(question, asked)) == {"trade"}
        assert differing(question, whole.applied(question, asked))
        assert whole.applied(question, asked) == whole.applied(question, asked)
        assert whole.applied(question, [question]) is None
        assert whole.applied(question, [observing(question, persona={})]) is None, "who is nobody is no one to be"
    with pytest.raises(InputError, match="'swap_persona' has no parts in world 'bar'"):
        find_edits("swap_persona.each", bar())


@pytest.mark.parametrize(
    ("rounds", "payoff"),
    [([], "none"), ([["go"] * 5], "at"), ([["go"] * 5, ["go", *["stay"] * 4]], "above"),
     ([["go", *["stay"] * 4], ["go"] * 5], "below")],
)  # fmt: skip
def test_a_moment_of_a_game_is_told_apart_by_the_last_payoff(rounds: list[list[str]], payoff: str):
    assert bar().strata(asked_after(bar(), *rounds)[0]) == {"message": False, "payoff": payoff}
    untold = bar(reports="attendance")
    assert untold.strata(asked_after(untold, *rounds)[0]) == {"message": False, "payoff": "none"}
