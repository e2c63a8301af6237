"""Counts the agents of a run by the lines of its steps."""

from __future__ import annotations

import re

from foundry.errors import RecordError
from foundry.viewer.lines import StepLines

_AGENT = re.compile(rb'\n\{"step":\d+,"agent":(\d+)[,}]')


class DecisionLines(StepLines):
    """Lines that begin with their step and their agent.

    Attributes:
        agents: number of agents that have a line so far, those with lower ids included.
    """

    def _begin(self) -> None:
        super()._begin()
        self.agents = 0

    def _index(self, block: bytes, whole: int) -> None:
        found = _AGENT.findall(b"\n" + block[:whole])
        if len(found) != block.count(b"\n", 0, whole):
            raise RecordError(f"{self.path}: a line does not begin with its step and its agent.")
        super()._index(block, whole)
        self.agents = max(self.agents, *(int(agent) + 1 for agent in set(found)), 0)
