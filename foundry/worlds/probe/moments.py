"""Recorded moments, and the questions that were asked in them, made again by playing the world with its answers."""

from __future__ import annotations

import hashlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import msgspec
import zstandard

from foundry.errors import RecordError
from foundry.records import NOT_JSON
from foundry.worlds.base import Answer, Question, Scenario, World


class Moment(msgspec.Struct, frozen=True, order=True, array_like=True):
    """One recorded question.

    Attributes:
        run: id of the run that it was asked in.
        step: 1-based step.
        agent: who was asked.
        kind: what was asked.
        again: how often the agent was asked this before in the step.
    """

    run: str
    step: int
    agent: int
    kind: str
    again: int = 0


class Source(msgspec.Struct, frozen=True, kw_only=True):
    """A run that moments come from.

    Attributes:
        seed: the run's seed.
        sha256: hash of its answers up to the last moment.
    """

    seed: int
    sha256: str


Strata: TypeAlias = Mapping[str, str | bool]
"""What a world tells a moment apart by."""


class Moments(msgspec.Struct, frozen=True, kw_only=True):
    """The moments of a probe (`moments.json`).

    Attributes:
        runs: the runs they come from, by their ids.
        moments: the moments, sorted.
        strata: what the world tells each apart by, in their order; empty where it says nothing.
    """

    runs: dict[str, Source]
    moments: tuple[Moment, ...]
    strata: tuple[dict[str, str | bool], ...] = ()

    def of(self, seed: int) -> dict[str, list[Moment]]:
        """Return the moments of the runs with a seed, by run."""
        found: dict[str, list[Moment]] = {}
        for moment in self.moments:
            if self.runs[moment.run].seed == seed:
                found.setdefault(moment.run, []).append(moment)
        return found

    def most(self) -> int:
        """Return how many moments the seed with the most of them has."""
        counts = Counter(self.runs[moment.run].seed for moment in self.moments)
        return max(counts.values(), default=0)


class Said(msgspec.Struct, frozen=True, kw_only=True):
    """One answer of the past, as it stands in a log of calls; what else a line holds is left."""

    step: int
    agent: int
    kind: str
    text: str
    ending: str
    timings: dict[str, float] = {}

    @property
    def answer(self) -> Answer:
        """The answer as the world saw it."""
        return Answer(self.text, self.ending, self.timings.get("latency", 0.0))


def digest_of(past: Iterable[Said]) -> str:
    """Return the SHA-256 of what was answered."""
    lines = [[one.step, one.agent, one.kind, one.text, one.ending, one.answer.inference_s] for one in past]
    return hashlib.sha256(msgspec.json.encode(lines)).hexdigest()


@lru_cache(maxsize=8)
def read_moments(path: str, sha256: str) -> Moments:
    """Return the moments of a file."""
    try:
        content = Path(path).read_bytes()
        moments = msgspec.json.decode(content, type=Moments)
    except (OSError, *NOT_JSON) as error:
        raise RecordError(f"{path} cannot be read: {error}") from error
    if hashlib.sha256(content).hexdigest() != sha256:
        raise RecordError(f"{path} holds other moments than the probe was made of.")
    return moments


def read_past(path: str, sha256: str) -> list[Said]:
    """Return the answers of the past."""
    try:
        with Path(path).open("rb") as file, zstandard.ZstdDecompressor().stream_reader(file) as reader:
            past = msgspec.json.Decoder(Said).decode_lines(reader.read())
    except (OSError, zstandard.ZstdError, *NOT_JSON) as error:
        raise RecordError(f"{path} cannot be read: {error}") from error
    if digest_of(past) != sha256:
        raise RecordError(f"{path} holds other answers than the probe was made of.")
    return past


@dataclass(frozen=True)
class Kept:
    """The moments of one seed of a probe; equal ones are made of the same files.

    Attributes:
        moments: the file of moments.
        sha256: its hash.
        past: the file of answers of a run, with `{run}` in its name.
        seed: the seed.
        source: the world that was recorded.
    """

    moments: str
    sha256: str
    past: str
    seed: int
    source: Scenario = field(compare=False)


@lru_cache(maxsize=1024)
def questions_of(kept: Kept) -> Mapping[Moment, Question]:
    """Return the question of each moment of a seed; the conditions of a probe share them."""
    moments = read_moments(kept.moments, kept.sha256)
    questions: dict[Moment, Question] = {}
    for run, mine in moments.of(kept.seed).items():
        past = read_past(kept.past.replace("{run}", run), moments.runs[run].sha256)
        questions.update(zip(mine, questions_at(kept.source, kept.seed, past, mine), strict=True))
    return questions


def questions_at(scenario: Scenario, seed: int, past: Sequence[Said], moments: Iterable[Moment]) -> list[Question]:
    """Return the questions of these moments of one run, in the order of the moments.

    The world is played with what was answered, so that the questions come out as they were asked.
    """
    wanted = {(one.step, one.agent, one.kind, one.again): place for place, one in enumerate(moments)}
    questions: dict[int, Question] = {}
    for question, again in asked_in(scenario, seed, past):
        place = wanted.get((*question.asked, again))
        if place is not None:
            questions[place] = question
            if len(questions) == len(wanted):
                break
    if len(questions) < len(wanted):
        raise RecordError(f"World '{scenario.name}' no longer asks what it was recorded to ask: the run ends before.")
    return [questions[place] for place in range(len(wanted))]


def asked_in(scenario: Scenario, seed: int, past: Sequence[Said]) -> Iterator[tuple[Question, int]]:
    """Yield every question of a run with how often it was asked before in its step, as far as there are answers."""
    counts = Counter[tuple[int, int, str]]()
    for _, pending in played(scenario, seed, past):
        for question in pending:
            yield question, counts[question.asked]
            counts[question.asked] += 1


def played(scenario: Scenario, seed: int, past: Sequence[Said]) -> Iterator[tuple[World, Sequence[Question]]]:
    """Yield the world of a run with what it asks at once, again and again, as far as there are answers."""
    world, left = scenario.start(seed), list(reversed(past))
    while not world.finished:
        pending = world.pending()
        yield world, pending
        world.advance([_answer(question, left) for question in pending])


def _answer(question: Question, left: list[Said]) -> Answer:
    said = left.pop() if left else None
    if said is None or (said.step, said.agent, said.kind) != question.asked:
        step, agent, kind = question.asked
        raise RecordError(
            f"The world no longer asks what it was recorded to ask: now the {kind} of agent {agent} at step {step}, "
            f"then {'nothing' if said is None else f'the {said.kind} of agent {said.agent} at step {said.step}'}."
        )
    return said.answer


def by_run(moments: Iterable[Moment]) -> Mapping[str, list[Moment]]:
    """Return moments by their run."""
    moments_by_run: dict[str, list[Moment]] = defaultdict(list)
    for moment in moments:
        moments_by_run[moment.run].append(moment)
    return moments_by_run
