"""The soonest that agents can leave by exits that let out so many at a time; oracles plan by it, bounds rest on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

FAR = 1 << 40
"""The distance to an exit to which there is no way."""


@dataclass(frozen=True, slots=True)
class Departure:
    """How an agent leaves: the index of the exit and the step."""

    exit: int
    step: int


class _Doorway:
    """Agents matched to places in the doorways; a place is an exit, a step, and a number below what it lets out."""

    def __init__(self, distances: Sequence[Sequence[int]]) -> None:
        self._distances = distances
        self.departures: dict[int, Departure] = {}

    def fill(self, place: Departure, tried: set[int]) -> bool:
        """Give a place to an agent; one that has another place may give that up to who can take it instead."""
        able = [agent for agent, own in enumerate(self._distances) if own[place.exit] <= place.step]
        for agent in able:
            if agent not in self.departures:
                self.departures[agent] = place
                return True
        for agent in able:
            if agent not in tried:
                tried.add(agent)
                given_up = self.departures[agent]
                if given_up.exit != place.exit and self.fill(given_up, tried):
                    self.departures[agent] = place
                    return True
        return False


def soonest_departures(distances: Sequence[Sequence[int]], capacities: Sequence[int | None]) -> list[Departure | None]:
    """Return how each agent leaves so that at every step as many are out as can be, were none in another's way.

    Who is d moves from an exit can leave by it in step d or later. The sets of places that can be filled together are a
    matroid (Edmonds and Fulkerson 1965), so filling places in the order of their steps is best for every step at once;
    whether one more can be filled is told by an alternating path (Kuhn 1955).

    Args:
        distances: moves to each exit by agent, FAR where there is no way, (N, E).
        capacities: agents that each exit lets out in a step, None for any number, (E,).

    Returns:
        By agent; None for who has no way out.
    """
    able = sum(min(own, default=FAR) < FAR for own in distances)
    doorway, step = _Doorway(distances), 0
    while len(doorway.departures) < able:
        step += 1
        for index, capacity in enumerate(capacities):
            for _ in range(able if capacity is None else capacity):
                if not doorway.fill(Departure(index, step), set()):
                    break
    return [doorway.departures.get(agent) for agent in range(len(distances))]
