"""The soonest that agents can leave by exits that let out so many at a time; oracles plan by it, bounds rest on it."""

from collections.abc import Mapping, Sequence
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

    def fill(self, place: Departure) -> bool:
        """Give a place to an agent; an agent that has another place may give that up to another agent.

        The search is breadth-first. A later step of an exit is open to every agent to whom an earlier one is open.
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
        """Move each agent of a chain; `moves` has the place that an agent takes and the agent that gives it up."""
        mover: int | None = agent
        while mover is not None:
            self.departures[mover], mover = moves[mover]


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
                if not doorway.fill(Departure(index, step)):
                    break
    return [doorway.departures.get(agent) for agent in range(len(distances))]
