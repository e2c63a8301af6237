"""Computes the earliest departures of agents through exits with limited capacity, for oracles and bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

FAR = 1 << 40
"""The distance to an unreachable exit."""


@dataclass(frozen=True, slots=True)
class Departure:
    """The departure of an agent: index of the exit, and step."""

    exit: int
    step: int


class _Doorway:
    """Matches agents to places in doorways; a place is an exit, a step, and a number below the exit's capacity."""

    def __init__(self, distances: Sequence[Sequence[int]]) -> None:
        self._distances = distances
        self.departures: dict[int, Departure] = {}

    def fill(self, place: Departure) -> bool:
        """Give a place to an agent; if the agent already has a place, that place goes to another agent, and so on.

        The search is breadth-first. An agent who can use a step of an exit can also use every later step.
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
        """Move each agent of a chain; `moves` has an agent's new place and the agent who gives it up."""
        mover: int | None = agent
        while mover is not None:
            self.departures[mover], mover = moves[mover]


def soonest_departures(distances: Sequence[Sequence[int]], capacities: Sequence[int | None]) -> list[Departure | None]:
    """Return the departures that maximise the number of agents outside at every step, if agents never obstruct others.

    An agent at distance d from an exit can leave by it in step d or later. The sets of places that can be filled
    together are a matroid (Edmonds and Fulkerson 1965). So filling places in the order of steps is optimal for every
    step at once. An alternating path shows whether one more place can be filled (Kuhn 1955).

    Args:
        distances: moves to each exit by agent, FAR if unreachable, (N, E).
        capacities: agents that each exit lets out per step, None for any number, (E,).

    Returns:
        By agent; None for an agent without a way out.
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
