"""Computes how soon agents can leave through exits of limited capacity, for oracles and upper bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

FAR = 1 << 40
"""The distance to an unreachable exit."""


@dataclass(frozen=True, slots=True)
class Departure:
    """When and where an agent leaves: the index of the exit, and the step."""

    exit: int
    step: int


class _Doorway:
    """Assigns agents to places in exits; a place is an exit and a step, as often as the capacity of the exit."""

    def __init__(self, distances: Sequence[Sequence[int]]) -> None:
        self._distances = distances
        self.departures: dict[int, Departure] = {}

    def fill(self, place: Departure) -> bool:
        """Give a place to an agent. If this agent has a place already, another agent gets that one, and so on.

        The search is breadth-first. An agent that can leave by an exit in some step can do so in every later step.
        """
        offers: list[tuple[Departure, int | None]] = [(place, None)]
        moves: dict[int, tuple[Departure, int | None]] = {}
        searched = [-1] * len(self._distances[0])
        for offer in offers:
            way, step = offer[0].exit, offer[0].step
            if step <= searched[way]:
                continue
            searched[way] = step
            for agent, own in enumerate(self._distances):
                if agent in moves or own[way] > step:
                    continue
                moves[agent] = offer
                if agent not in self.departures:
                    self._shift(agent, moves)
                    return True
                offers.append((self.departures[agent], agent))
        return False

    def _shift(self, agent: int, moves: Mapping[int, tuple[Departure, int | None]]) -> None:
        """Move each agent of a chain to its new place; `moves` contains this place and the agent that gives it up."""
        mover: int | None = agent
        while mover is not None:
            self.departures[mover], mover = moves[mover]


def soonest_departures(distances: Sequence[Sequence[int]], capacities: Sequence[int | None]) -> list[Departure | None]:
    """Return departures with as many agents outside as possible at every step, if agents do not obstruct each other.

    An agent at distance d from an exit can leave by it in step d or later. The sets of places that can be filled
    together are a matroid (Edmonds and Fulkerson 1965). So filling places in the order of steps is optimal for every
    step at once. An alternating path shows whether one more place can be filled (Kuhn 1955).

    Args:
        distances: moves to each exit by agent, FAR if unreachable, (N, E).
        capacities: agents that each exit lets out per step, None for any number, (E,).

    Returns:
        The departure of each agent; None for an agent without a way out.
    """
    able = sum(min(own, default=FAR) < FAR for own in distances)
    doorway, step = _Doorway(distances), 0
    while len(doorway.departures) < able:
        step += 1
        for index, capacity in enumerate(capacities):
            for _ in range(able if capacity is None else capacity):
                if not doorway.fill(Departure(index, step)):
                    break
    return [doorway.departures.get(agent) for agent in range(len(distances))]
