"""How far news of a fire has come, step after step: who perceived it, and who was told before."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from foundry.records import GridStep


class News:
    """Who knows of a fire, and how; an order within a step as in the analysis: agents perceive, speak, and are told.

    What is told at a step can be passed on from the next one on.
    """

    def __init__(self) -> None:
        self._seen: set[int] = set()
        self._perceived: set[int] = set()
        self._told: set[int] = set()

    def take(self, rows: Iterable[GridStep], deliveries: Sequence[tuple[int, int]]) -> None:
        """Take in a step: its records, and sender and recipient of each message that carries the news."""
        for row in rows:
            self._seen.add(row.agent)
            if row.fires:
                self._perceived.add(row.agent)
        knowing = self._perceived | self._told
        self._told |= {to for sender, to in deliveries if sender in knowing and to not in self._perceived}

    @property
    def reach(self) -> float | None:
        """Agents that were told before they perceived / agents but those that perceived first; None for none."""
        others = len(self._seen) - len(self._perceived - self._told)
        return len(self._told) / others if others else None

    @property
    def saw(self) -> float | None:
        """Agents that perceived a fire / agents; None for none."""
        return len(self._perceived) / len(self._seen) if self._seen else None
