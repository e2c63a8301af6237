"""Spaces of an environment: what can be decided in them, and observations as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from foundry.declared import Actions
from foundry.errors import InputError

MASK = "action_mask"
"""Where environments say which actions are legal now, in an observation or beside it."""


@dataclass(frozen=True)
class Choices:
    """What can be decided in an environment, by the names that a world gives to it.

    Attributes:
        labels: name of each action, in the order of the space; empty where a number is decided.
        first: the space's own number of the first action.
        low: least number, where one is decided.
        high: greatest one.
        shape: of the array that the environment takes for a number; () for a number alone.
        idle: name of the action that does nothing, or None.
    """

    labels: tuple[str, ...] = ()
    first: int = 0
    low: float | None = None
    high: float | None = None
    shape: tuple[int, ...] = ()
    idle: str | None = None

    @cached_property
    def actions(self) -> Actions:
        """All that can be decided."""
        return Actions(labels=self.labels, low=self.low, high=self.high, whole=False, idle=self.idle)

    def legal(self, mask: Sequence[int] | None) -> Actions:
        """Return what can be decided where a mask says which actions are legal; None allows all."""
        if mask is None or all(mask):
            return self.actions
        labels = tuple(label for label, allowed in zip(self.labels, mask, strict=True) if allowed)
        return Actions(labels=labels, idle=self.idle if self.idle in labels else None)

    def taken(self, decided: Any) -> Any:
        """Return the environment's own action of a decision."""
        if self.labels:
            return self.first + self.labels.index(decided)
        return np.full(self.shape, decided, dtype=np.float32) if self.shape else float(decided)


def choices_of(space: Any, labels: Sequence[str] | None, idle: str | None, where: str) -> Choices:
    """Return what can be decided in a space of actions."""
    kind = type(space).__name__
    if kind == "Box" and int(np.prod(space.shape)) == 1 and labels is None and idle is None:
        low, high = (float(np.reshape(end, -1)[0]) for end in (space.low, space.high))
        return Choices(low=low, high=high, shape=space.shape)
    if kind != "Discrete":
        raise InputError(
            f"{where} takes actions of the kind {space}, which no reply is read as: a finite set (Discrete) or one "
            "number (Box of one value, without world.actions) can be decided. Wrap it so that it takes one of these."
        )
    count, first = int(space.n), int(space.start)
    named = tuple(labels or map(str, range(first, first + count)))
    if len(named) != count or len(set(named)) != count or not all(isinstance(one, str) and one for one in named):
        raise InputError(
            f"world.actions={list(named)} does not name the {count} actions of {where}, each once, in order."
        )
    if idle is not None and idle not in named:
        raise InputError(f"world.idle={idle} is none of the actions of {where}: {', '.join(named)}.")
    return Choices(labels=named, first=first, idle=idle)


def plain(value: Any) -> Any:
    """Return an observation as plain containers, numbers and texts; what is none of these as its text."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return value if isinstance(value, str | int | float | bool | None) else str(value)


def mask_of(*told: Any) -> list[int] | None:
    """Return which actions are legal, from the first of these that says so; None where none does."""
    for one in told:
        if isinstance(one, Mapping) and MASK in one:
            return [int(allowed) for allowed in one[MASK]]
    return None
