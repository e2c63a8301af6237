"""Computes how soon agents can leave through exits of limited capacity, for oracles and upper bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

FAR = 1 << 40
"""A huge distance: the one between an agent and an exit that the agent cannot reach."""


@dataclass(frozen=True, slots=True)
class Departure:
    """The exit through which an agent leaves, given by its index, and the step in which the agent leaves."""

    exit: int
    step: int


class _Doorway:
    """Gives each agent a place: an exit and a step. An exit for two agents per step has two places per step."""

    def __init__(self, distances: Sequence[Sequence[int]]) -> None:
        self._distances = distances
        self.departures: dict[int, Departure] = {}

    def fill(self, place: Departure) -> bool:
        """Add a place for one agent at an exit in a step; return whether one more agent can leave because of it.

        An agent that already has a place may take the new place. Then its old place becomes free for another agent.

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
        """Give `agent` its new place, then give the agent that loses this place a new one, and so on.

        `moves` contains each agent's new place, and the agent that has this place so far; None if the place is free.
        """
        mover: int | None = agent
        while mover is not None:
            self.departures[mover], mover = moves[mover]


def soonest_departures(distances: Sequence[Sequence[int]], capacities: Sequence[int | None]) -> list[Departure | None]:
    """Return the departures with which, at every step, as many agents are outside as possible.

    The computation assumes that no agent blocks another on its way.

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
