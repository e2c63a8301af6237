"""Runs of any form whose policies are known exactly: what the measures of every form must say of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from analysis.any.run import AnyRun
from analysis.arrays import OUTCOMES
from foundry.declared import Actions, Declared
from foundry.records import Outcome

LABELS = ("go", "stay", "wait")
CHOICE = Declared(
    form="ring",
    actions={"choice": Actions(labels=LABELS, idle="stay")},
    streams={"steps": {"step": "integer", "utility": "number?", "message": "text?"}},
)
BID = Declared(form="ring", actions={"bid": Actions(whole=False)}, streams={"steps": {"step": "integer"}})


def any_run(
    rows: Sequence[tuple[int, int, Any]],
    *,
    kind: str | Sequence[str] = "choice",
    declared: Declared = CHOICE,
    personas: Sequence[Mapping[str, str]] = (),
    **changes: Any,
) -> AnyRun:
    """Return a run of decisions (step, agent, action), in this order."""
    size = len(rows)
    agents = max([len(personas), *(agent + 1 for _, agent, _ in rows)])
    kinds = [kind] * size if isinstance(kind, str) else list(kind)
    fields: dict[str, Any] = {
        "id": "run",
        "declared": declared,
        "step": np.array([step for step, _, _ in rows], dtype=np.int64),
        "agent": np.array([agent for _, agent, _ in rows], dtype=np.int64),
        "kind": np.array(kinds, dtype=np.object_),
        "action": np.array([one if isinstance(one, str) else None for _, _, one in rows], dtype=np.object_),
        "number": np.array([np.nan if isinstance(one, str | None) else one for _, _, one in rows], dtype=np.float64),
        "outcome": np.full(size, OUTCOMES.index(Outcome.CHOSEN)),
        "utility": np.full(size, np.nan),
        "said": np.full(size, None, dtype=np.object_),
        "deliveries": np.zeros((0, 3), dtype=np.int64),
        "agents": agents,
        "personas": (*personas, *({} for _ in range(agents - len(personas)))),
    }
    return AnyRun(**{**fields, **changes})
