"""What is said of runs of 3D worlds."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.form import Words
from analysis.labelling import Labelling


def _methods(_: Sequence[Labelling]) -> list[str]:
    return ["Distances in 3D are lengths of shortest ways on the walkable floor, seen from above."]


WORDS = Words(
    unread="count as staying, which shows in idle rate, stability, clustering and exploration",
    unread_decision="and left the agent where it was",
    methods=_methods,
)
