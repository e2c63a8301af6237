"""The keys by which two decisions are compared: `COMPARED` of `foundry/worlds/<form>/`, else keys of any form."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from foundry.declared import Declared
from foundry.naming import in_room

Line = Mapping[str, Any]
"""A line of `steps.jsonl`."""


@dataclass(frozen=True)
class Compared:
    """The keys and values of a line of `steps.jsonl` by which two decisions are compared.

    Attributes:
        state: keys of the agent's position, its action and the result; None for all keys except texts.
        ends: keys of the agent's position and heading after the step; empty in worlds without positions.
        place: returns the position after the step, in cells or metres; None in worlds without positions.
        heading: returns the heading after the step, in degrees; None in worlds without headings.
    """

    state: tuple[str, ...] | None = None
    acted: tuple[str, ...] = ("action",)
    ends: tuple[str, ...] = ()
    place: Callable[[Line], tuple[float, ...]] | None = None
    heading: Callable[[Line], float] | None = None

    def acts_alike(self, one: Line, other: Line) -> bool:
        """Return whether both lines record the same action."""
        return all(one.get(key) == other.get(key) for key in self.acted)

    def state_of(self, line: Line, declared: Declared) -> dict[str, Any]:
        """Return the part of a line that describes the state of its agent."""
        if self.state is not None:
            return {name: line[name] for name in self.state}
        types = declared.streams.get("steps", {})
        said = {name for name, kind in types.items() if kind.startswith("text")} | _BESIDE
        return {name: value for name, value in line.items() if name == "action" or name not in said}


_BESIDE = {"step", "agent", "kind", "outcome", "message"}
"""Keys of any form that identify the decision or hold its words."""


def compared_of(form: str) -> Compared:
    """Return the keys by which decisions of a form are compared."""
    found: Compared | None = in_room(f"foundry.worlds.{form}", "COMPARED")
    return found or Compared()
