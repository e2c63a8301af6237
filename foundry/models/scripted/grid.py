"""What policies for 2D worlds share: legal moves, and replies in the JSON that the prompts ask for."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, TypeAlias

from numpy.random import Generator

Observation: TypeAlias = Mapping[str, Any]
Cell: TypeAlias = tuple[int, int]

STAY = "stay"
_OFFSETS = {STAY: (0, 0), "up": (0, 1), "down": (0, -1), "left": (-1, 0), "right": (1, 0)}


def legal_moves(observation: Observation) -> dict[str, Cell]:
    """Return the cell that each legal choice leads to: `stay`, then the directions that stay on the grid."""
    x, y, half_size = observation["x"], observation["y"], observation["half_size"]
    cells = {choice: (x + dx, y + dy) for choice, (dx, dy) in _OFFSETS.items()}
    return {choice: cell for choice, cell in cells.items() if max(abs(cell[0]), abs(cell[1])) <= half_size}


def is_on_grid(kind: str, observation: Observation) -> bool:
    """Tell whether a question is one of a 2D world: where the agent stands and how far the grid goes is in it."""
    return kind in ("message", "action") and {"x", "y", "half_size"} <= observation.keys()


def any_of(choices: list[str], rng: Generator) -> str:
    """Return one of the choices, all equally likely."""
    return choices[int(rng.integers(len(choices)))]


def towards(observation: Observation, x: float, y: float, rng: Generator) -> str:
    """Return a legal choice that comes closest to a point; ties are drawn."""
    gaps = {choice: math.dist(cell, (x, y)) for choice, cell in legal_moves(observation).items()}
    nearest = min(gaps.values())
    return any_of([choice for choice, gap in gaps.items() if gap <= nearest + 1e-9], rng)


def act(choice: str, *, memory: str = "", reasoning: str) -> str:
    """Return the reply to an action question: `stay` or a direction."""
    action = {"action": STAY} if choice == STAY else {"action": "move", "direction": choice}
    return json.dumps({**action, "memory": memory, "reasoning": reasoning}, ensure_ascii=False)


def say(text: str | None, *, reasoning: str) -> str:
    """Return the reply to a message question; None is silence."""
    return json.dumps({"message": text, "reasoning": reasoning}, ensure_ascii=False)
