"""Edits of what games show: numbers that are told follow from each other as they did before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from foundry.errors import InputError
from foundry.worlds.base import Answer, Question, Scenario
from foundry.worlds.probe.editing import find_edit, find_edits
from foundry.worlds.rounds.bar import Bar
from foundry.worlds.rounds.fishery import Fishery
from foundry.worlds.rounds.naming import NamingGame
from foundry.worlds.rounds.public_goods import PublicGoods, PunishedGoods
from foundry.worlds.rounds.replies import deciding
from foundry.worlds.rounds.table import RoundQuestion

AGES = {"age": {"young": 1, "old": 1}, "trade": {"baker": 1, "smith": 1}}


def bar(**changes: Any) -> Bar:
    settings = {"name": "bar", "agents": 5, "steps": 3, "capacity": 0.6, "fun": 10, "crowded": 0, "home": 5}
    return Bar(**(settings | {"reports": "explicit"} | changes))


def naming(**changes: Any) -> NamingGame:
    settings: dict[str, Any] = dict.fromkeys(("established", "committed_name", "until"))
    settings |= {"name": "naming", "agents": 2, "steps": 3, "names": ["a", "b", "c"], "protocol": "both", "memory": 5}
    return NamingGame(**(settings | {"equal": 100, "different": -50, "committed": 0} | changes))


def pot(punished: bool = False, **changes: Any) -> PublicGoods:
    settings = {"name": "pot", "agents": 4, "steps": 3, "tokens": 20, "multiplier": 2, "reset": True}
    return PunishedGoods(**settings, cost=1, loss=3) if punished else PublicGoods(**(settings | changes))


def asked_after(scenario: Scenario, *rounds: Sequence[Any], seed: int = 0) -> list[Question]:
    """Return what is asked after rounds of these decisions, by agent."""
    world = scenario.start(seed)
    for decisions in rounds:
        world.advance([Answer(deciding(decisions[one.agent])) for one in world.pending()])
    return sorted(world.pending(), key=lambda one: one.agent)


def edited(scenario: Scenario, name: str, question: Question, others: Sequence[Question] = ()) -> dict[str, Any]:
    changed = find_edit(name, scenario).applied(question, others)
    assert changed is not None and changed.asked == question.asked
    return dict(changed.observation)


def test_who_stayed_went_and_what_the_bar_paid_follows():
    first, *_, last = asked_after(bar(), ["go", "stay", "stay", "stay", "stay"])
    assert edited(bar(), "others_went", first)["evenings"] == [{"went": 5, "action": "go", "utility": 0}]
    assert edited(bar(), "others_went", last)["evenings"] == [{"went": 3, "action": "stay", "utility": 5}]
    implicit = asked_after(bar(reports="implicit"), ["go", "go", "stay", "stay", "stay"])
    assert find_edit("others_went", bar()).applied(implicit[-1]) is None
    (told, *_) = asked_after(bar(reports="attendance"), ["go", "go", "stay", "stay", "stay"])
    assert edited(bar(), "others_went", told)["evenings"] == [{"went": 3, "action": None, "utility": None}]


def test_the_others_put_least_into_the_pot_where_they_put_most_and_the_share_follows():
    question = asked_after(pot(), [5, 10, 10, 10], [5, 2, 2, 2])[0]
    assert [one["payoff"] for one in question.observation["rounds"]] == [15 + 17.5, 15 + 5.5]
    rounds = edited(pot(), "others_went", question)["rounds"]
    assert [(one["given"], one["pot"], one["payoff"]) for one in rounds] == [(5, 5, 15 + 2.5), (5, 29, 15 + 14.5)]
    carried = asked_after(pot(reset=False), [5, 10, 10, 10])[0]
    assert find_edit("others_went", pot()).applied(carried) is None
    whom = asked_after(pot(punished=True), [5, 10, 0, 4])[0]
    assert edited(pot(punished=True), "others_went", whom)["given"] == [5, 0, 10, 6]


def test_the_other_said_the_next_name_and_the_points_follow():
    question = asked_after(naming(), ["b", "a"])[0]
    found = edited(naming(), "others_went", question)
    assert found["memory"] == [{"own": "b", "other": "b", "points": 100}] and found["points"] == 100
    assert question.observation["points"] == -50


def test_all_points_are_ten_times_as_many():
    found = edited(bar(), "scale_payoffs", asked_after(bar(), ["go"] * 5)[0])
    assert (found["fun"], found["crowded"], found["home"], found["places"]) == (100, 0, 50, 3)
    assert found["evenings"] == [{"went": 5, "action": "go", "utility": 0}]
    found = edited(naming(), "scale_payoffs", asked_after(naming(), ["b", "a"])[0])
    assert (found["equal"], found["different"], found["points"]) == (1000, -500, -500)
    assert found["memory"] == [{"own": "b", "other": "a", "points": -500}]
    assert find_edit("scale_payoffs", pot()).applied(asked_after(pot(), [1] * 4)[0]) is None


@pytest.mark.parametrize(
    ("scenario", "decisions", "past"),
    [(bar(), ["go"] * 5, ["evenings"]), (naming(), ["b", "a"], ["memory"]), (pot(), [1, 2, 3, 4], ["rounds"])],
)
def test_nothing_is_left_of_the_past(scenario: Scenario, decisions: list[Any], past: list[str]):
    question = asked_after(scenario, decisions)[0]
    found = edited(scenario, "no_history", question)
    assert all(found[key] == [] for key in past) and found.get("points", 0) == found.get("met", 0) == 0
    assert find_edit("no_history", scenario).applied(asked_after(scenario)[0]) is None


def test_agents_are_numbered_from_the_end_and_so_are_those_to_choose_from():
    question = asked_after(pot(punished=True), [5, 10, 0, 4])[1]
    renaming = find_edit("rename_agents", pot(punished=True))
    changed = renaming.applied(question)
    assert isinstance(changed, RoundQuestion) and changed.legal and changed.agent == question.agent == 1
    assert (changed.observation["agent"], changed.observation["given"]) == (2, [4, 0, 10, 5])
    assert set(changed.legal.labels) == {"nobody", "agent 3", "agent 1", "agent 0"}
    assert renaming.described(pot(punished=True))["expected"]["agent 3"] == "agent 0"
    reading = pot(punished=True).read(changed, Answer(deciding("agent 1")))
    assert reading.action == "agent 1"
    assert pot(punished=True).read(changed, Answer(deciding("agent 2"))).action is None


def test_months_and_talk_of_a_fishery_name_the_same_agents_under_other_numbers():
    lake = Fishery(
        name="lake", agents=3, steps=2, stock=90, collapse=5, sharing="proportional", talk=3, universalisation=False,
        outsider=None,
    )  # fmt: skip
    question = asked_after(lake, [1, 2, 3])[0]
    found = edited(lake, "rename_agents", question)
    assert found["months"][0]["caught"] == [3, 2, 1] and found["agent"] == 2 - question.agent
    assert [lake.payoffs(one) for one in asked_after(lake, [1, 2, 3])] == [[[1, 2, 3][question.agent]]]


def test_options_are_turned_round_and_each_can_come_first():
    (question, _) = asked_after(naming())
    names = question.observation["names"]
    turned = edited(naming(), "permute_options", question)["names"]
    assert sorted(turned) == sorted(names) and turned != names
    places = find_edits("permute_options.each", naming())
    assert [edit.name for edit in places] == ["permute_options.2", "permute_options.3"]
    firsts = [edit.applied(question) for edit in places]
    assert [one.observation["names"][0] for one in firsts if one] == names[1:]
    assert find_edit("permute_options", bar()).applied(asked_after(bar())[0]) is None


def differing(one: Question, other: Question | None) -> set[str]:
    """Return the attributes of the persona that differ."""
    assert other is not None
    return {key for key, value in one.observation["persona"].items() if other.observation["persona"][key] != value}


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
    with pytest.raises(InputError, match="'swap_persona' has no parts in world 'bar'"):
        find_edits("swap_persona.each", bar())


@pytest.mark.parametrize(
    ("rounds", "payoff"),
    [([], "none"), ([["go"] * 5], "at"), ([["go"] * 5, ["go", *["stay"] * 4]], "above"),
     ([["go", *["stay"] * 4], ["go"] * 5], "below")],
)  # fmt: skip
def test_a_moment_of_a_game_is_told_apart_by_the_last_payoff(rounds: list[list[str]], payoff: str):
    assert bar().strata(asked_after(bar(), *rounds)[0]) == {"message": False, "payoff": payoff}
