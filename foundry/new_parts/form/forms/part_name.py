"""The form part_name: its events and its page. Delete the functions that you do not need."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from foundry import AnyRun, AnyView, Event, FormAnalysis, FormView


def events(run: AnyRun) -> Iterator[Event]:
    """Yield the events for the timeline; this example has one event, in the first step."""
    yield Event(1, None, "opened", "the first evening")


class PartNameView(AnyView):
    """Gives the page the data of a run of this form."""

    def neighbours(self, agent: int) -> dict[str, Any]:
        """Return the two agents beside an agent. The page gets these agents from `neighbours/<agent>`."""
        return {"neighbours": [(agent - 1) % self.agents, (agent + 1) % self.agents]}

    parts = {**AnyView.parts, ("neighbours", 1): neighbours}


ANALYSIS = FormAnalysis("part_name", events=events)
VIEWER = FormView(PartNameView)
PAGE = Path(__file__).with_suffix(".js")
