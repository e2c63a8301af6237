"""Policies that leave a 2D world by its exits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.avoid import known_fires, warn
from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import STAY, act, any_of, say


class ShortestPath(ScriptedModel):
    """Knows the exit by which all are out soonest, and goes there on a shortest way: the oracle of an evacuation.

    It reads what no model is shown: `ways_out`. It stays where there is no way, and says nothing.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return say(None, reasoning="I am busy leaving.")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Step along a shortest way out; where several are as short, one of them."""
        ways = observation.get("ways_out") or [STAY]
        return act(any_of(ways, rng), reasoning="It is on a shortest way out.")


class FollowLeader(ScriptedModel):
    """Goes to the nearest leader that it sees, else on a shortest way to the nearest exit it knows; warns of fires.

    A leader, and who sees an exit, goes to the exit; who knows of nothing walks at random. It reads what no model is
    shown: `ways_known`.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Warn the neighbours of all fires it knows."""
        return warn(observation)

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Step towards what it follows."""
        ways, why = _followed(observation)
        choices = ways or list(observation.get("open") or [STAY])
        return act(any_of(choices, rng), memory=known_fires(observation), reasoning=why)


def _followed(observation: Mapping[str, Any]) -> tuple[list[str], str]:
    """Return the open ways that lead to whom or what it follows, and which that is; none to look for a way."""
    leads = observation["persona"].get("role") == LEADER
    leaders = [one for one in observation.get("seen") or () if one["persona"].get("role") == LEADER]
    if leads or not leaders or any(one["seen"] for one in observation.get("exits") or ()):
        return list(observation.get("ways_known") or ()), "It is on the way to the nearest exit that I know of."
    x, y = observation["x"], observation["y"]
    leader = min(leaders, key=lambda one: (abs(one["x"] - x) + abs(one["y"] - y), one["id"]))
    return _nearer(observation, leader["x"] - x, leader["y"] - y), f"I follow Agent {leader['id']}."


def _nearer(observation: Mapping[str, Any], dx: int, dy: int) -> list[str]:
    """Return the open ways that come nearer to what is so many columns and rows away."""
    wanted = {"right": dx > 0, "left": dx < 0, "up": dy > 0, "down": dy < 0}
    return [way for way in observation["open"] if wanted[way]]


LEADER = "leader"
"""The role of those who are announced as knowing the way."""
