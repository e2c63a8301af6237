"""Computes numbers for each step of a 2D run, such as how many agents know of a fire, form groups, or moved."""

import math
import threading
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

from foundry.records import GridStep
from foundry.viewer.run_view import UNDECIDED, IsWarning


class News:
    """Records, step by step, which agents know of a fire.

    As in the analysis, agents first perceive, then speak and then hear within a step. An agent can pass news on from
    the step after it was told.
    """

    def __init__(self) -> None:
        self._seen: set[int] = set()
        self._perceived: set[int] = set()
        self._told: set[int] = set()

    def take(self, rows: Iterable[GridStep], deliveries: Sequence[tuple[int, int]]) -> None:
        """Add a step.

        Args:
            rows: the records of the step.
            deliveries: sender and recipient of each message that counts as news of a fire.
        """
        for row in rows:
            self._seen.add(row.agent)
            if row.fires:
                self._perceived.add(row.agent)
        knowing = self._perceived | self._told
        self._told |= {to for sender, to in deliveries if sender in knowing and to not in self._perceived}

    @property
    def reach(self) -> float | None:
        """Share of agents that learned of a fire from a message, among agents that did not perceive a fire before.

        None if no such agent exists.
        """
        others = len(self._seen) - len(self._perceived - self._told)
        return len(self._told) / others if others else None

    @property
    def saw(self) -> float | None:
        """Share of agents that perceived a fire; None without agents."""
        return len(self._perceived) / len(self._seen) if self._seen else None


WARNED = "reach of the warning (share)"
REACH = "reach if every message warned (share)"
SAW = "perceived a fire so far (share)"
DISTANCE = "distance to the nearest fire (cells)"
GROUP = "largest group (share)"
ALONE = "with nobody in reach (share)"
SAID, HEARD, MOVED = "said something (agents)", "received a message (agents)", "moved (agents)"
UNREAD = "undecided (decisions)"
THERE = "present (agents)"


class GridByStep:
    """Computes numbers with one value per step of a run. Steps must be added in order: values depend on earlier steps.

    - WARNED: agents that a warning told of a fire before they perceived one / agents so far that did not perceive one
      first. The warning must go back to an agent that had perceived the fire. After the last step it equals
      `warning.traced_reach` of the analysis.
    - REACH: WARNED if every message were a warning.
    - SAW: agents that perceived a fire / agents so far.
    - DISTANCE: mean over the agents, before the step, of the Euclidean distance to the nearest burning fire.
    - GROUP: largest connected group of agents that can talk before the step / agents.
    - ALONE: agents that can talk to nobody / agents.
    - SAID, HEARD, MOVED, THERE: number of agents that said something, received a message, changed their cell, were
      present. For each place: number of agents in the place before the step.
    - UNREAD: number of unreadable actions and messages.

    Args:
        world: the world's settings: `fires` and `places`.
        is_warning: returns whether a text warns of fires with the given names; None leaves out WARNED.
        steady: whether all agents are present at all steps; if so, THERE is left out.
    """

    def __init__(
        self,
        world: Mapping[str, Any],
        is_warning: IsWarning | None = None,
        *,
        steady: bool = True,
    ) -> None:
        self._fires: Sequence[Mapping[str, Any]] = world.get("fires") or ()
        self._names = tuple(fire["name"] for fire in self._fires)
        self._places = [place["name"] for place in world.get("places") or ()]
        self._steady = steady
        self._is_warning = is_warning if self._fires else None
        self._warned, self._reached = News(), News()
        self._lock = threading.Lock()
        self.values: dict[str, list[float | None]] = {}

    @property
    def done(self) -> int:
        """Number of steps so far."""
        return len(self.values.get(SAID, ()))

    def take(self, first: int, rows: Sequence[GridStep], deliveries: Sequence[Sequence[int]]) -> None:
        """Add the values of the steps from `first` on; do nothing if these steps were added before.

        Args:
            first: the first step.
            rows: the records of these steps, in order.
            deliveries: for each step, sender and recipient of the first message, then of the second, and so on.
        """
        with self._lock:
            if first != self.done + 1:
                return
            of_step = {step: list(rows_of_step) for step, rows_of_step in groupby(rows, lambda row: row.step)}
            for step, delivered in enumerate(deliveries, first):
                for name, value in self._measured(step, of_step.get(step, []), delivered).items():
                    self.values.setdefault(name, []).append(value)

    def _measured(self, step: int, rows: Sequence[GridStep], delivered: Sequence[int]) -> dict[str, float | None]:
        inside, there = Counter(row.place for row in rows), len(rows)
        values: dict[str, float | None] = self._of_fires(step, rows, delivered) if self._fires else {}
        values[GROUP] = _largest_group(rows) / there if rows else None
        values |= {f"in {name} (agents)": inside[name] for name in self._places}
        values[ALONE] = sum(not row.neighbours for row in rows) / there if rows else None
        values |= {SAID: sum(row.message is not None for row in rows), HEARD: len(set(delivered[1::2]))}
        values |= {MOVED: sum(row.moved for row in rows)}
        values[UNREAD] = sum(outcome in UNDECIDED for row in rows for outcome in (row.outcome, row.message_outcome))
        return values if self._steady else values | {THERE: there}

    def _of_fires(self, step: int, rows: Sequence[GridStep], delivered: Sequence[int]) -> dict[str, float | None]:
        deliveries = list(zip(delivered[::2], delivered[1::2], strict=True))
        self._reached.take(rows, deliveries)
        values: dict[str, float | None] = {}
        if self._is_warning is not None:
            spoken = [(row.agent, row.message) for row in rows if row.message is not None]
            warning = {agent for agent, text in spoken if self._is_warning(text, self._names)}
            self._warned.take(rows, [delivery for delivery in deliveries if delivery[0] in warning])
            values[WARNED] = self._warned.reach
        distance = self._distance(step, rows)
        return values | {REACH: self._reached.reach, DISTANCE: distance, SAW: self._reached.saw}

    def _distance(self, step: int, rows: Sequence[GridStep]) -> float | None:
        burning = [fire["position"] for fire in self._fires if fire["start"] <= step]
        if not burning or not rows:
            return None
        return sum(min(math.dist((row.x, row.y), cell) for cell in burning) for row in rows) / len(rows)


def _largest_group(rows: Sequence[GridStep]) -> int:
    left = {row.agent: row.neighbours for row in rows}
    largest = 0
    while left:
        size, open_ends = 0, [next(iter(left))]
        while open_ends:
            near = left.pop(open_ends.pop(), None)
            if near is not None:
                size += 1
                open_ends += near
        largest = max(largest, size)
    return largest
