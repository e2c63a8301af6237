"""The view of a run of any form: facts, progress, decisions, and marks for the timeline."""

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

OUTCOMES = tuple(str(outcome) for outcome in Outcome)
UNDECIDED = frozenset({Outcome.UNREADABLE, Outcome.EMPTY, Outcome.TRUNCATED, Outcome.FAILED})
COMPLETE, FAILED = "complete", "failed"
RUNNING, UNFINISHED, WAITING = "running", "unfinished", "waiting"
MARKS_PER_BLOCK = 100
"""Number of steps whose marks on the timeline the page requests at once."""

JSON, BINARY, PNG = "application/json", "application/octet-stream", "image/png"
_READ_MESSAGES = msgspec.json.Decoder(Message).decode_lines
AnyRecord = TypeVar("AnyRecord", bound=Record)
IsWarning = Callable[[str, tuple[str, ...]], bool | None]
"""A function that returns whether a text warns of fires with the given names; None if this is unknown."""


@dataclass(frozen=True)
class Resource:
    """The content at an address of the page, and its media type."""

    content: bytes
    media_type: str = JSON


class RunView(ABC):
    """One run, from whose files only the requested data are read.

    Args:
        decisions_per_chunk: number of steps in one chunk of decisions.
        trusted: further packages that may contain classes of the run's world, for redrawing pictures.

    Attributes:
        parts: further requests for runs of this form, by name and number of numeric arguments. Each is a function of
            the view and the numbers; it returns a Resource, or a value that becomes JSON.
        steps_per_chunk: number of steps in one chunk of frames.
        is_warning: tells warnings from other texts; None if unknown.
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
        """Compute and store the data that take long to compute for a page; by default there are none."""

    def close(self) -> None:
        """Free cached data."""
        self.calls.close()

    @property
    @abstractmethod
    def agents(self) -> int:
        """Number of agents."""

    @abstractmethod
    def about_world(self) -> dict[str, Any]:
        """Return the facts that the page needs to draw the world."""

    @abstractmethod
    def frames(self, first: int, last: int) -> dict[str, Any]:
        """Return the data that the page draws for the steps from `first` to `last`."""

    @abstractmethod
    def marks(self, first: int, last: int) -> dict[str, list[int]]:
        """Return counts for the timeline by kind, such as unreadable replies: one per step from `first` to `last`."""

    @abstractmethod
    def texts(self, first: int, last: int) -> list[tuple[int, int, str]]:
        """Return the texts of these steps as (step, agent, text), for the search on the run's page."""

    @abstractmethod
    def track(self, agent: int) -> dict[str, Any]:
        """Return an agent's data over the whole run for the page, such as its path and its decisions' outcomes."""

    @abstractmethod
    def all_tracks(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield each agent with what `track` returns for it, but read the records only once for all agents."""

    def counted(self, first: int, last: int) -> Iterator[tuple[int, Mapping[str, float]]]:
        """Yield, for each decision from step `first` to `last`, the agent and the numbers to add to its totals."""
        return iter(())

    def totals(self) -> dict[str, Any]:
        """Return a list of the agents, each with `persona` and with `counts`: its totals over the run so far."""
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
        """Return numbers over time by name: one number, or None, for each step from `first` to `last`."""
        return {}

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield the further data of an export, each with its address below the address of the run."""
        return iter(())

    def files(self) -> Sequence[str]:
        """Return the paths of files that the page shows, relative to the sweep's folder."""
        return ()

    def received(self, first: int, last: int, agent: int | None = None) -> Mapping[int, list[tuple[int, int, str]]]:
        """Return, by recipient, the messages of these steps as (step, sender, text).

        If `agent` is given, return only the messages to this agent.
        """
        self.messages.grow()
        lines = self.messages.read(first, last)
        if agent is not None:
            of_agent = rb'\n(\{"step":\d+,"sender":\d+,"recipient":%d,[^\n]*)' % agent
            lines = b"\n".join(re.findall(of_agent, b"\n" + lines))
        messages: dict[int, list[tuple[int, int, str]]] = {}
        for heard in _READ_MESSAGES(lines):
            messages.setdefault(heard.recipient, []).append((heard.step, heard.sender, heard.text))
        return messages

    def personas(self) -> dict[int, dict[str, str]]:
        """Return the recorded personas of the agents."""
        content = self.folder.agents_bytes()
        lines = lines_of(content[: content.rfind(b"\n") + 1], Agent, self.folder.stream_path("agents"))
        return {line.agent: line.persona for line in lines}

    @property
    def done(self) -> int:
        """Number of fully recorded steps."""
        step, count = self.steps.last
        return step if count >= self.agents else max(0, step - 1)

    def progress(self, *, running: bool) -> dict[str, Any]:
        """Return the progress of the run; `running` says whether a worker is playing it now."""
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
        """Return the facts about the run that do not change while it is played."""
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
        """Return the first and the last recorded step of a chunk; in an empty chunk, the last is below the first."""
        self.steps.grow()
        return number * size + 1, min((number + 1) * size, self.done)

    def decisions(self, agent: int, first: int, last: int) -> dict[str, Any]:
        """Return an agent's decisions in full: records, calls with prompts and replies, and received messages."""
        steps = lines_of_agent(self.steps.read(first, last), agent)
        calls = self.calls.of_agent(agent, first, last)
        everything = {
            "steps": raw(steps),
            "calls": raw(calls),
            "received": self.received(first, last, agent).get(agent, []),
        }
        return {"first": first, "last": last, **everything, "damaged": self.calls.damaged}

    def all_decisions(self, first: int, last: int) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield each agent with what `decisions` returns for it, but read the records only once for all agents."""
        steps, calls = by_agent(self.steps.read(first, last)), self.calls.of_all(first, last)
        received = self.received(first, last)
        for agent in range(self.agents):
            lines = {"steps": raw(steps.get(agent, [])), "calls": raw(calls.get(agent, []))}
            everything = {"first": first, "last": last, **lines, "received": received.get(agent, [])}
            yield agent, {**everything, "damaged": self.calls.damaged}

    def read_steps(self, first: int, last: int, kind: type[AnyRecord]) -> Sequence[AnyRecord]:
        """Return the records of the steps from `first` to `last`, or raise RecordError if a line has another type."""
        return lines_of(self.steps.read(first, last), kind, self.steps.path)


def raw(lines: Iterable[bytes]) -> list[msgspec.Raw]:
    """Wrap lines of JSON so that the encoder sends them to the page unchanged, with all their keys."""
    return [msgspec.Raw(line) for line in lines]


def parts_of(total: int, size: int) -> int:
    """Return how many parts of size `size` a total has; the last part may be smaller."""
    return -(-total // size)


def standing(folder: RunFolder, summary: RunSummary | None, *, running: bool) -> str:
    """Return the state of a run: complete, failed, running, unfinished (begun, but not played now) or waiting."""
    if summary is not None:
        return summary.status
    if not folder.beginning:
        return WAITING
    return RUNNING if running else UNFINISHED
