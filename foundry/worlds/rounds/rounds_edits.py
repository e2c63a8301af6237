"""Edits of observations in games."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import msgspec

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import Edit, observing
from foundry.worlds.rounds.public_goods import agent_of
from foundry.worlds.rounds.reading import options_of
from foundry.worlds.rounds.table import RoundQuestion

FACTOR = 10
"""Factor by which `scale_payoffs` multiplies all points."""
_POINTS = ("fun", "crowded", "home", "equal", "different", "points", "utility")
_PAST = ("evenings", "rounds", "months", "memory", "turns", "talk", "received")
_SUMS = ("met", "points", "total")
"""Keys of an observation that hold a count or a sum over past rounds."""
_AGENT = "agent "
"""Beginning of an action that names another agent, such as "agent 3"."""


def no_history(question: Question) -> Question:
    """Remove the past: earlier rounds, their payoffs, and messages."""
    return observing(question, **{key: [] for key in _PAST}, **dict.fromkeys(_SUMS, 0))


def no_messages(question: Question) -> Question:
    """Remove the messages of others, even from conversations; the agent's own messages stay."""
    own = [message for message in question.observation.get("talk", ()) if message["agent"] == question.agent]
    return observing(question, received=[], talk=own)


def others_went(question: Question) -> Question | None:
    """Invert the past decisions of others, and change the agent's past payoffs accordingly.

    For example, the largest contribution becomes the smallest. Return None in a game without such decisions or payoffs.
    """
    seen = question.observation
    if "evenings" in seen:
        return observing(question, evenings=[_evening(evening, seen) for evening in seen["evenings"]])
    if "given" in seen:
        return observing(question, given=_given(seen["given"], seen["agent"]))
    if "rounds" in seen and seen["reset"]:
        return observing(question, rounds=_rounds(seen["rounds"], seen))
    if "memory" in seen and seen.get("protocol") == "both":
        memory = [_meeting(meeting, seen) for meeting in seen["memory"]]
        gained = sum(new["points"] - old["points"] for new, old in zip(memory, seen["memory"], strict=True))
        return observing(question, memory=memory, points=seen["points"] + gained)
    return None


def _evening(evening: Mapping[str, Any], bar: Mapping[str, Any]) -> dict[str, Any]:
    if evening["went"] is None:
        return dict(evening)
    if evening["action"] is None:
        return {**evening, "went": bar["agents"] - evening["went"]}
    own = int(evening["action"] == "go")
    went = bar["agents"] - 1 - evening["went"] + 2 * own
    utility = bar["home"] if not own else bar["fun"] if went <= bar["places"] else bar["crowded"]
    return {**evening, "went": went, "utility": utility}


def _given(given: Sequence[int], own: int) -> list[int]:
    """Invert the contributions of the others: the largest becomes 0, and 0 becomes the largest."""
    most = max((gave for agent, gave in enumerate(given) if agent != own), default=0)
    return [gave if agent == own else most - gave for agent, gave in enumerate(given)]


def _rounds(rounds: Sequence[Mapping[str, Any]], game: Mapping[str, Any]) -> list[dict[str, Any]]:
    others = [round_record["pot"] - round_record["given"] for round_record in rounds]
    most = max(others, default=0)
    changes = [most - 2 * gave for gave in others]
    share = game["multiplier"] / game["agents"]
    return [
        {**round_seen, "pot": round_seen["pot"] + change, "payoff": round_seen["payoff"] + share * change}
        for round_seen, change in zip(rounds, changes, strict=True)
    ]


def _meeting(meeting: Mapping[str, Any], game: Mapping[str, Any]) -> dict[str, Any]:
    """Replace the name that the other agent said by the next name in the alphabet; the points are changed to fit."""
    names = sorted(game["names"])
    if meeting["other"] not in names:
        return dict(meeting)
    other = names[(names.index(meeting["other"]) + 1) % len(names)]
    points = game["equal"] if other == meeting["own"] else game["different"]
    return {**meeting, "other": other, "points": points}


def rename_agents(question: Question) -> Question:
    """Number all agents in reverse order; numbers in the texts of messages do not change."""
    seen, agents = question.observation, question.observation["agents"]

    def renamed(thing: Mapping[str, Any], key: str) -> dict[str, Any]:
        return {**thing, key: None if thing.get(key) is None else agents - 1 - thing[key]}

    lists = {"received": "sender", "talk": "agent"}
    named = {key: [renamed(entry, name) for entry in seen.get(key, ())] for key, name in lists.items()}
    months = [{**month, "caught": month["caught"][::-1]} for month in seen.get("months", ())]
    rounds = [
        renamed(round_seen, "punished") if "punished" in round_seen else round_seen
        for round_seen in seen.get("rounds", ())
    ]
    changed = observing(
        question, **named, months=months, rounds=rounds, given=list(seen.get("given", ()))[::-1],
        agent=agents - 1 - seen["agent"],
    )  # fmt: skip
    if isinstance(changed, RoundQuestion) and changed.legal and changed.legal.labels:
        labels = tuple(_renamed(label, agents) for label in changed.legal.labels)
        legal = msgspec.structs.replace(changed.legal, labels=labels)
        return replace(changed, legal=legal, options=options_of(legal))
    return changed


def _renamed(action: str, agents: int) -> str:
    return f"{_AGENT}{agents - 1 - agent_of(action)}" if action.startswith(_AGENT) else action


def scale_payoffs(question: Question) -> Question:
    """Multiply all payoffs by ten, also those of past rounds, so that their ratios do not change.

    Amounts that agents decide about, such as tokens and tons, do not change.
    """
    seen = question.observation
    past = {key: [{**entry, **_scaled(entry)} for entry in seen[key]] for key in ("evenings", "memory") if key in seen}
    return observing(question, **_scaled(seen), **past)


def _scaled(details: Mapping[str, Any]) -> dict[str, Any]:
    return {key: details[key] * FACTOR for key in _POINTS if isinstance(details.get(key), int | float)}


EDITS = (
    Edit("no_history", "cause", no_history),
    Edit("no_messages", "cause", no_messages),
    Edit("others_went", "cause", others_went),
    Edit("rename_agents", "equivariance", rename_agents, lambda action, scenario: _renamed(action, scenario.agents)),
    Edit("scale_payoffs", "invariance", scale_payoffs),
)
