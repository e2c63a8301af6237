"""The keys by which two decisions are compared: `COMPARED` of `foundry/worlds/<form>/`, or those of any form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from foundry.declared import Declared
from foundry.naming import in_room

Line = Mapping[str, Any]
"""A line of `steps.jsonl`."""


@dataclass(frozen=True)
class Compared:
    """What is looked at in two lines of `steps.jsonl`.

    Attributes:
        state: keys that say where an agent was, what it did and what that brought; None for all that are no text.
        acted: keys of what it did.
        ends: keys of where it is after that, and looks; none where nothing is anywhere.
        place: returns where it is after that, in cells or metres, or is None.
        heading: returns where it looks then, degrees, or is None.
    """

    state: tuple[str, ...] | None = None
    acted: tuple[str, ...] = ("action",)
    ends: tuple[str, ...] = ()
    place: Callable[[Line], tuple[float, ...]] | None = None
    heading: Callable[[Line], float] | None = None

    def acts_alike(self, one: Line, other: Line) -> bool:
        """Return whether two lines say that the same was done."""
        return all(one.get(key) == other.get(key) for key in self.acted)

    def state_of(self, line: Line, declared: Declared) -> dict[str, Any]:
        """Return what a line says of its agent's state."""
        if self.state is not None:
            return {name: line[name] for name in self.state}
        types = declared.streams.get("steps", {})
        said = {name for name, kind in types.items() if kind.startswith("text")} | _BESIDE
        return {name: value for name, value in line.items() if name == "action" or name not in said}


_BESIDE = {"step", "agent", "kind", "outcome", "message"}
"""Keys of any form that say which decision it is, or what was said about it."""


def compared_of(form: str) -> Compared:
    """Return what decisions of a form are compared by."""
    found: Compared | None = in_room(f"foundry.worlds.{form}", "COMPARED")
    return found or Compared()
