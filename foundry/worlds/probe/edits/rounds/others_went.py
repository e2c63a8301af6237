"""What is told of others is the opposite: who stayed went, who gave most gave least; own payoffs follow from that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "others_went"
LEAVES = "cause"


def edit(question: Question) -> Question | None:
    """Return the question with other others; None in a game that does not tell of them, or lets nothing follow."""
    seen = question.observation
    if "evenings" in seen:
        return observing(question, evenings=[_evening(one, seen) for one in seen["evenings"]])
    if "given" in seen:
        return observing(question, given=_given(seen["given"], seen["agent"]))
    if "rounds" in seen and seen["reset"]:
        return observing(question, rounds=_rounds(seen["rounds"], seen))
    if "memory" in seen and seen.get("protocol") == "both":
        memory = [_meeting(one, seen) for one in seen["memory"]]
        gained = sum(new["points"] - old["points"] for new, old in zip(memory, seen["memory"], strict=True))
        return observing(question, memory=memory, points=seen["points"] + gained)
    return None


def _evening(evening: Mapping[str, Any], bar: Mapping[str, Any]) -> dict[str, Any]:
    """Return an evening at the bar to which those others went that stayed."""
    if evening["went"] is None:
        return dict(evening)
    if evening["action"] is None:
        return {**evening, "went": bar["agents"] - evening["went"]}
    own = int(evening["action"] == "go")
    went = bar["agents"] - 1 - evening["went"] + 2 * own
    utility = bar["home"] if not own else bar["fun"] if went <= bar["places"] else bar["crowded"]
    return {**evening, "went": went, "utility": utility}


def _given(given: Sequence[int], own: int) -> list[int]:
    """Return what each gave, by agent: of the others, who gave most gives nothing, and so on."""
    most = max((gave for agent, gave in enumerate(given) if agent != own), default=0)
    return [gave if agent == own else most - gave for agent, gave in enumerate(given)]


def _rounds(rounds: Sequence[Mapping[str, Any]], game: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return rounds with a pot in which the others put the least where they put the most."""
    others = [one["pot"] - one["given"] for one in rounds]
    most = max(others, default=0)
    changes = [most - 2 * gave for gave in others]
    share = game["multiplier"] / game["agents"]
    return [
        {**one, "pot": one["pot"] + change, "payoff": one["payoff"] + share * change}
        for one, change in zip(rounds, changes, strict=True)
    ]


def _meeting(meeting: Mapping[str, Any], game: Mapping[str, Any]) -> dict[str, Any]:
    """Return a meeting in which the other said the next name in the alphabet."""
    names = sorted(game["names"])
    if meeting["other"] not in names:
        return dict(meeting)
    other = names[(names.index(meeting["other"]) + 1) % len(names)]
    points = game["equal"] if other == meeting["own"] else game["different"]
    return {**meeting, "other": other, "points": points}
