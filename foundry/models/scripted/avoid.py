"""The policy that flees fires and warns others."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.random import Generator

from foundry.models.scripted.base import ScriptedModel
from foundry.models.scripted.grid import Cell, act, any_of, legal_moves, say

_WARNING = re.compile(r'Fire "([^"\n]*)" at \((-?\d{1,9}), (-?\d{1,9})\), radius (\d{1,9}(?:\.\d{1,9})?)\.')


@dataclass(frozen=True, slots=True)
class _Fire:
    name: str
    x: int
    y: int
    radius: float

    def gap(self, cell: Cell) -> float:
        """Distance from the cell to the edge of the radius; negative inside."""
        return math.dist(cell, (self.x, self.y)) - self.radius

    def __str__(self) -> str:
        return f'Fire "{self.name}" at ({self.x}, {self.y}), radius {self.radius:g}.'


class Avoid(ScriptedModel):
    """Leaves the radius of every fire it perceives or was warned of, keeps out of it, and passes warnings on.

    What it was told is kept as memory, so that it outlives the messages.
    """

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Warn the neighbours of all fires it knows."""
        return warn(observation)

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Go away from the fire it is in, else walk at random outside all radii."""
        fires = _known_fires(observation)
        memory = known_fires(observation)
        cells = legal_moves(observation)
        gaps = {choice: min((fire.gap(cell) for fire in fires), default=1.0) for choice, cell in cells.items()}
        outside = [choice for choice, gap in gaps.items() if gap > 0]
        if outside:
            return act(any_of(outside, rng), memory=memory, reasoning="No fire reaches there.")
        furthest = max(gaps.values())
        choices = [choice for choice, gap in gaps.items() if gap >= furthest - 1e-9]
        return act(any_of(choices, rng), memory=memory, reasoning="It leads away from the fire.")


def warn(observation: Mapping[str, Any]) -> str:
    """Return the message that warns the neighbours of all fires it knows; silence when there is none of either."""
    if not _known_fires(observation) or not observation["neighbours"]:
        return say(None, reasoning="There is nothing to warn of, or nobody to warn.")
    return say("Warning: " + known_fires(observation), reasoning="Others may not perceive it.")


def known_fires(observation: Mapping[str, Any]) -> str:
    """Return all fires it knows, as it says and remembers them."""
    return " ".join(map(str, _known_fires(observation)))


def _known_fires(observation: Mapping[str, Any]) -> list[_Fire]:
    """Return the fires it perceives, remembers or was told of, each once, by name and position."""
    known = {_Fire(fire["name"], fire["x"], fire["y"], fire["radius"]) for fire in observation["fires"]}
    texts = [*observation["memory"], *(heard["text"] for heard in observation["received"])]
    for text in texts:
        for name, x, y, radius in _WARNING.findall(text):
            known.add(_Fire(name, int(x), int(y), float(radius)))
    return sorted(known, key=lambda fire: (fire.name, fire.x, fire.y, fire.radius))
