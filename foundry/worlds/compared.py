"""Chooses the keys by which foundry compares two recorded decisions; a form may name its own keys (`COMPARED`)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from foundry.declared import Declared
from foundry.naming import in_room

Line = Mapping[str, Any]
"""A line of `steps.jsonl`, as a dict."""


@dataclass(frozen=True)
class Compared:
    """Keys of `steps.jsonl` that are compared between two runs, such as a run and its fork.

    Attributes:
        state: keys that describe the agent's state and its action; None for all keys except texts.
        acted: keys that describe the action.
        ends: keys of the position and heading after the step; empty in worlds without positions.
        place: function that returns the position after the step, in cells or metres; None without positions.
        heading: function that returns the heading after the step, in degrees; None without headings.
    """

    state: tuple[str, ...] | None = None
    acted: tuple[str, ...] = ("action",)
    ends: tuple[str, ...] = ()
    place: Callable[[Line], tuple[float, ...]] | None = None
    heading: Callable[[Line], float] | None = None

    def acts_alike(self, first: Line, other: Line) -> bool:
        """Return whether two records' lines have the same action."""
        return all(first.get(key) == other.get(key) for key in self.acted)

    def state_of(self, line: Line, declared: Declared) -> dict[str, Any]:
        """Return the keys and values of a record's line that describe the state of the agent."""
        if self.state is not None:
            return {name: line[name] for name in self.state}
        types = declared.streams.get("steps", {})
        said = {name for name, kind in types.items() if kind.startswith("text")} | _BESIDE
        return {name: value for name, value in line.items() if name == "action" or name not in said}


_BESIDE = {"step", "agent", "kind", "outcome", "message"}
"""Keys that identify a decision or contain text, in records of all forms; they describe no state."""


def compared_of(form: str) -> Compared:
    """Return the keys by which foundry compares two decisions, for records of a form."""
    return in_room(f"foundry.worlds.{form}", "COMPARED") or Compared()
