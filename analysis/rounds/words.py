"""What is said of runs of worlds of rounds."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.form import Words
from analysis.labelling import Labelling


def _methods(_: Sequence[Labelling]) -> list[str]:
    return ["Shares and means by round are over the agents of a run; intervals are over runs, one a seed."]


WORDS = Words(
    unread="count as the action that does nothing, where the world declares one",
    unread_decision="and counted as the action that does nothing, where the world declares one",
    methods=_methods,
)
