"""What a page can ask of a run, whatever its form: facts, progress, decisions, marks for the timeline."""

from __future__ import annotations

import re
import threading
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import msgspec

from foundry.records import Agent, Message, Outcome, Record, RunSummary
from foundry.storing.store import RunFolder, lines_of
from foundry.viewer.calls import CallLog
from foundry.viewer.lines import StepLines, by_agent, lines_of_agent

OUTCOMES = tuple(str(one) for one in Outcome)
UNDECIDED = frozenset({Outcome.UNREADABLE, Outcome.EMPTY, Outcome.TRUNCATED, Outcome.FAILED})
COMPLETE, FAILED = "complete", "failed"
RUNNING, UNFINISHED, WAITING = "running", "unfinished", "waiting"
MARKS_PER_BLOCK = 100
"""Steps in one block of marks for the timeline."""

JSON, BINARY, PNG = "application/json", "application/octet-stream", "image/png"
_READ_MESSAGES = msgspec.json.Decoder(Message).decode_lines
AnyRecord = TypeVar("AnyRecord", bound=Record)
IsWarning = Callable[[str, tuple[str, ...]], bool | None]
"""Whether a text is a warning of fires of these names; None where that cannot be said."""


@dataclass(frozen=True)
class Resource:
    """What an address stands for.

    Attributes:
        content: the bytes.
        media_type: what they are.
    """

    content: bytes
    media_type: str = JSON


class RunView(ABC):
    """One run, read as far as it is written and only where it is asked for.

    Args:
        folder: the run.
        decisions_per_chunk: steps in one chunk of decisions.
        trusted: further packages whose classes its world may be built of, where its pictures are drawn again.

    Attributes:
        parts: what can be asked of a run of this form beyond what every form answers, by name and count of numbers:
            functions of the view and the numbers that return a Resource, or what becomes JSON.
        steps_per_chunk: steps in one chunk of frames.
        is_warning: whether a text warns of fires of these names, by who opened the view; None where it cannot tell.
    """

    is_warning: IsWarning | None = None

    parts: ClassVar[Mapping[tuple[str, int], Callable[..., Any]]] = {}

    def __init__(self, folder: RunFolder, *, decisions_per_chunk: int = 10, trusted: Sequence[str] = ()) -> None:
        self.folder = folder
        self.decisions_per_chunk = decisions_per_chunk
        self.trusted = trusted
        self.steps_per_chunk = 50
        self.config: Mapping[str, Any] = folder.config()
        self.world: Mapping[str, Any] = self.config["world"]
        self.steps = StepLines(folder.stream_path("steps"))
        self.messages = StepLines(folder.stream_path("messages"))
        self.calls = CallLog(folder.stream_path("calls"))
        self._counts: dict[int, Counter[str]] = {}
        self._counted = 0
        self._counting = threading.Lock()

    def prepare(self) -> None:
        """Make and keep what takes long when a page of the sweep is first opened; nothing by default."""

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

    def counted(self, first: int, last: int) -> Iterator[tuple[int, Mapping[str, float]]]:
        """Yield an agent and what counts of one of its decisions, for each decision of these steps; none by default."""
        return iter(())

    def totals(self) -> dict[str, Any]:
        """Return `agents`: of each its `persona`, and `counts` over the whole run so far."""
        with self._counting:
            self.steps.grow()
            while self._counted < (done := self.done):
                last = min(self._counted + self.steps_per_chunk, done)
                for agent, counts in self.counted(self._counted + 1, last):
                    self._counts.setdefault(agent, Counter()).update(counts)
                self._counted = last
            names = dict.fromkeys(name for counts in self._counts.values() for name in counts)
            personas = self.personas()
            return {"agents": [self._total(agent, names, personas) for agent in range(self.agents)]}

    def _total(self, agent: int, names: Iterable[str], personas: Mapping[int, Mapping[str, str]]) -> dict[str, Any]:
        counts: Mapping[str, float] = self._counts.get(agent, {})
        return {"persona": personas.get(agent, {}), "counts": {name: counts.get(name, 0) for name in names}}

    def by_step(self, first: int, last: int) -> dict[str, list[float | None]]:
        """Return numbers by name, one for each step from `first` to `last`, None where there is none."""
        return {}

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield what an exported page holds of `parts`, by address below the run; nothing by default."""
        return iter(())

    def files(self) -> Sequence[str]:
        """Return the files that the page shows, by their path in the sweep's folder; none by default."""
        return ()

    def received(self, first: int, last: int, agent: int | None = None) -> Mapping[int, list[tuple[int, int, str]]]:
        """Return what agents were told in these steps as (step, sender, text), by recipient; of one agent if asked."""
        self.messages.grow()
        lines = self.messages.read(first, last)
        if agent is not None:
            of_agent = rb'\n(\{"step":\d+,"sender":\d+,"recipient":%d,[^\n]*)' % agent
            lines = b"\n".join(re.findall(of_agent, b"\n" + lines))
        found: dict[int, list[tuple[int, int, str]]] = {}
        for heard in _READ_MESSAGES(lines):
            found.setdefault(heard.recipient, []).append((heard.step, heard.sender, heard.text))
        return found

    def personas(self) -> dict[int, dict[str, str]]:
        """Return the agents' personas, as far as the run recorded them."""
        content = self.folder.agents_bytes()
        lines = lines_of(content[: content.rfind(b"\n") + 1], Agent, self.folder.stream_path("agents"))
        return {line.agent: line.persona for line in lines}

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
            "form": self.folder.declared.form,
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
            "steps": _raw(lines_of_agent(self.steps.read(first, last), agent)),
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


def parts_of(total: int, size: int) -> int:
    """Return how many parts of a size there are, the last one perhaps smaller."""
    return -(-total // size)


def standing(folder: RunFolder, summary: RunSummary | None, *, running: bool) -> str:
    """Return `complete`, `failed`, `running`, `unfinished` (begun, and nobody plays it) or `waiting` (not begun)."""
    if summary is not None:
        return summary.status
    if not folder.beginning:
        return WAITING
    return RUNNING if running else UNFINISHED
