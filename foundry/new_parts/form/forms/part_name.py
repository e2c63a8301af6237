"""The form part_name: what the analysis and the viewer add to records of any form. Leave out what you do not need."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from foundry import AnyRun, AnyView, Event, FormAnalysis, FormView


def events(run: AnyRun) -> Iterator[Event]:
    """Yield what you want to see on the timeline: here the first step."""
    yield Event(1, None, "opened", "the first evening")


class PartNameView(AnyView):
    """Reads a run for the page."""

    def neighbours(self, agent: int) -> dict[str, Any]:
        """Return who sits beside an agent; the page asks for `neighbours/<agent>`, and an export holds it."""
        return {"neighbours": [(agent - 1) % self.agents, (agent + 1) % self.agents]}

    parts = {**AnyView.parts, ("neighbours", 1): neighbours}


ANALYSIS = FormAnalysis("part_name", events=events)
VIEWER = FormView(PartNameView)
PAGE = Path(__file__).with_suffix(".js")
