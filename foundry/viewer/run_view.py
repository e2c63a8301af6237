"""What a page can ask of a run, whatever its world: facts, progress, decisions, marks for the timeline."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import msgspec

from foundry.records import Outcome, Record
from foundry.storing.store import RunFolder, lines_of
from foundry.viewer.calls import CallLog
from foundry.viewer.lines import StepLines, by_agent, lines_of_agent
from foundry.viewer.standing import standing

OUTCOMES = tuple(str(one) for one in Outcome)
UNDECIDED = frozenset({Outcome.UNREADABLE, Outcome.EMPTY, Outcome.TRUNCATED, Outcome.FAILED})
MARKS_PER_BLOCK = 100
"""Steps in one block of marks for the timeline."""

AnyRecord = TypeVar("AnyRecord", bound=Record)


class RunView(ABC):
    """One run, read as far as it is written and only where it is asked for.

    Attributes:
        kind: which page shows it: `grid` or `camera`.
        folder: the run.
        steps_per_chunk: steps in one chunk of frames.
        decisions_per_chunk: steps in one chunk of decisions.
    """

    kind: str
    steps_per_chunk: int = 50

    def __init__(self, folder: RunFolder, *, decisions_per_chunk: int = 10) -> None:
        self.folder = folder
        self.decisions_per_chunk = decisions_per_chunk
        self.config: Mapping[str, Any] = folder.config()
        self.world: Mapping[str, Any] = self.config["world"]
        self.steps = StepLines(folder.stream_path("steps"))
        self.calls = CallLog(folder.stream_path("calls"))

    def close(self) -> None:
        """Free what was kept for going back."""
        self.calls.close()

    @property
    @abstractmethod
    def agents(self) -> int:
        """Number of agents."""

    @abstractmethod
    def about_world(self) -> dict[str, Any]:
        """Return what the page must know of the world before it can draw."""

    @abstractmethod
    def frames(self, first: int, last: int) -> dict[str, Any]:
        """Return what is drawn of the steps from `first` to `last`."""

    @abstractmethod
    def marks(self, first: int, last: int) -> dict[str, list[int]]:
        """Return one list per kind of mark, with a number for each step from `first` to `last`."""

    @abstractmethod
    def texts(self, first: int, last: int) -> list[tuple[int, int, str]]:
        """Return what was said in these steps as (step, agent, text), for searching."""

    @abstractmethod
    def track(self, agent: int) -> dict[str, Any]:
        """Return an agent's whole way and the outcomes of its decisions."""

    @abstractmethod
    def all_tracks(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield what `track` returns for every agent, reading everything once."""

    @abstractmethod
    def received(self, first: int, last: int, agent: int | None = None) -> Mapping[int, list[tuple[int, int, str]]]:
        """Return what agents were told in these steps as (step, sender, text), by recipient; of one agent if asked."""

    @property
    def done(self) -> int:
        """Number of steps that are recorded in full."""
        step, count = self.steps.last
        return step if count >= self.agents else max(0, step - 1)

    def progress(self, *, running: bool) -> dict[str, Any]:
        """Return how far the run is; what a page asks again and again while a run is being written.

        Args:
            running: whether a worker plays it now.
        """
        self.steps.grow()
        summary = self.folder.summary()
        return {
            "beginning": self.folder.beginning,
            "done": self.done,
            "status": standing(self.folder, summary, running=running),
            "error": summary.error if summary else None,
            "error_type": summary.error_type if summary else None,
        }

    def about(self) -> dict[str, Any]:
        """Return the facts of the run that never change."""
        return {
            "id": self.folder.id,
            "kind": self.kind,
            "model": self.config["model"]["name"],
            "prompt": self.config["prompt"]["name"],
            "world": self.world["name"],
            "seed": self.config["seed"],
            "factors": self.folder.factors,
            "agents": self.agents,
            "planned": self.world.get("steps", 0),
            "outcomes": OUTCOMES,
            "steps_per_chunk": self.steps_per_chunk,
            "decisions_per_chunk": self.decisions_per_chunk,
            "marks_per_block": MARKS_PER_BLOCK,
            "config": self.config,
            **self.about_world(),
        }

    def chunk(self, number: int, size: int) -> tuple[int, int]:
        """Return the first and the last recorded step of a chunk of `size` steps; a chunk may have none yet."""
        self.steps.grow()
        return number * size + 1, min((number + 1) * size, self.done)

    def decisions(self, agent: int, first: int, last: int) -> dict[str, Any]:
        """Return everything about an agent's decisions: records, calls with prompts and replies, what it was told."""
        return {
            "first": first,
            "last": last,
            "steps": _raw(lines_of_agent(self.steps.read(first, last), agent, first, last)),
            "calls": _raw(self.calls.of_agent(agent, first, last)),
            "received": self.received(first, last, agent).get(agent, []),
            "damaged": self.calls.damaged,
        }

    def all_decisions(self, first: int, last: int) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield what `decisions` returns for every agent, reading everything once."""
        steps, calls = by_agent(self.steps.read(first, last)), self.calls.of_all(first, last)
        received = self.received(first, last)
        for agent in range(self.agents):
            yield (
                agent,
                {
                    "first": first,
                    "last": last,
                    "steps": _raw(steps.get(agent, [])),
                    "calls": _raw(calls.get(agent, [])),
                    "received": received.get(agent, []),
                    "damaged": self.calls.damaged,
                },
            )

    def read_steps(self, first: int, last: int, kind: type[AnyRecord]) -> Sequence[AnyRecord]:
        """Return the records of the steps from `first` to `last`.

        Raises:
            RecordError: a line cannot be read as such a record.
        """
        return lines_of(self.steps.read(first, last), kind, self.steps.path)


def _raw(lines: Iterable[bytes]) -> list[msgspec.Raw]:
    """Return lines of JSON that go out as they are, with whatever keys they have."""
    return [msgspec.Raw(line) for line in lines]
