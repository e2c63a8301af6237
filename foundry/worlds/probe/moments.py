"""Reads recorded moments, and rebuilds their questions by replaying the world with the recorded answers."""

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
        step: 1-based step.
        again: number of earlier questions of this kind to the agent in the step.
    """

    run: str
    step: int
    agent: int
    kind: str
    again: int = 0


class Source(msgspec.Struct, frozen=True, kw_only=True):
    """A run in which some of the probe's moments were recorded.

    Attributes:
        sha256: hash of the run's answers, up to the step of the last moment.
    """

    seed: int
    sha256: str


Strata: TypeAlias = Mapping[str, str | bool]
"""Properties of a moment, such as whether it shows a fire; a probe takes about equally many moments for each value."""


class Moments(msgspec.Struct, frozen=True, kw_only=True):
    """The content of `moments.json`: the moments of a probe.

    Attributes:
        moments: the moments, sorted.
        strata: strata of each moment, in the same order; empty if the world defines none.
    """

    runs: dict[str, Source]
    moments: tuple[Moment, ...]
    strata: tuple[dict[str, str | bool], ...] = ()

    def of(self, seed: int) -> Mapping[str, list[Moment]]:
        """Return the moments in runs with this seed, by run."""
        return by_run(moment for moment in self.moments if self.runs[moment.run].seed == seed)

    def most(self) -> int:
        """Return the largest number of moments that any seed has."""
        counts = Counter(self.runs[moment.run].seed for moment in self.moments)
        return max(counts.values(), default=0)


class LoggedAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """An answer from a run's log of calls, with only the keys that a world needs to be replayed."""

    step: int
    agent: int
    kind: str
    text: str
    ending: str
    timings: dict[str, float] = {}

    @property
    def answer(self) -> Answer:
        """The recorded answer in the form in which the world got it: its text, its ending and its time."""
        return Answer(self.text, self.ending, self.timings.get("latency", 0.0))


def digest_of(past: Iterable[LoggedAnswer]) -> str:
    """Return the SHA-256 of recorded answers."""
    lines = [[said.step, said.agent, said.kind, said.text, said.ending, said.answer.inference_s] for said in past]
    return hashlib.sha256(msgspec.json.encode(lines)).hexdigest()


def moments_in(file: Path, sha256: str | None = None) -> Moments:
    """Read a file of moments.

    Raises:
        RecordError: the file cannot be read, or its hash is not `sha256`.
    """
    try:
        content = file.read_bytes()
        moments = msgspec.json.decode(content, type=Moments)
    except (OSError, *NOT_JSON) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    if sha256 not in (None, hashlib.sha256(content).hexdigest()):
        raise RecordError(f"{file} has changed since the probe was made: its moments differ.")
    return moments


@lru_cache(maxsize=8)
def read_moments(path: str, sha256: str) -> Moments:
    """Return the moments in a file, and check the file's hash; repeated calls do not read the file again."""
    return moments_in(Path(path), sha256)


def read_past(path: str, sha256: str) -> list[LoggedAnswer]:
    """Read a file of recorded answers, and check their hash."""
    try:
        with Path(path).open("rb") as file, zstandard.ZstdDecompressor().stream_reader(file) as reader:
            past = msgspec.json.Decoder(LoggedAnswer).decode_lines(reader.read())
    except (OSError, zstandard.ZstdError, *NOT_JSON) as error:
        raise RecordError(f"{path} cannot be read: {error}") from error
    if digest_of(past) != sha256:
        raise RecordError(f"{path} has changed since the probe was made: its answers differ.")
    return past


@dataclass(frozen=True)
class MomentFiles:
    """The files with the moments of a probe, and one seed; objects with equal files and seed are equal.

    Attributes:
        moments: path of the file of moments.
        sha256: hash of this file.
        past: path of the file with a run's answers; its name contains `{run}`.
    """

    moments: str
    sha256: str
    past: str
    seed: int
    source: Scenario = field(compare=False)


@lru_cache(maxsize=1024)
def questions_of(inputs: MomentFiles) -> Mapping[Moment, Question]:
    """Return the question of each moment with one seed; the conditions of a probe share the cached questions."""
    moments = read_moments(inputs.moments, inputs.sha256)
    questions: dict[Moment, Question] = {}
    for run, mine in moments.of(inputs.seed).items():
        past = read_past(inputs.past.replace("{run}", run), moments.runs[run].sha256)
        questions.update(zip(mine, questions_at(inputs.source, inputs.seed, past, mine), strict=True))
    return questions


def questions_at(
    scenario: Scenario, seed: int, past: Sequence[LoggedAnswer], moments: Iterable[Moment]
) -> list[Question]:
    """Return the questions in the given moments of one run, in their order.

    The questions come from a replay of the world with the recorded answers.
    """
    wanted = {(moment.step, moment.agent, moment.kind, moment.again): place for place, moment in enumerate(moments)}
    questions: dict[int, Question] = {}
    for question, again in asked_in(scenario, seed, past):
        place = wanted.get((*question.asked, again))
        if place is not None:
            questions[place] = question
            if len(questions) == len(wanted):
                break
    if len(questions) < len(wanted):
        raise RecordError(f"World '{scenario.name}' no longer asks its recorded questions: the run now ends earlier.")
    return [questions[place] for place in range(len(wanted))]


def asked_in(scenario: Scenario, seed: int, past: Sequence[LoggedAnswer]) -> Iterator[tuple[Question, int]]:
    """Yield each question, and the number of earlier questions with the same step, agent and kind."""
    counts = Counter[tuple[int, int, str]]()
    for _, pending in played(scenario, seed, past):
        for question in pending:
            yield question, counts[question.asked]
            counts[question.asked] += 1


def played(scenario: Scenario, seed: int, past: Sequence[LoggedAnswer]) -> Iterator[tuple[World, Sequence[Question]]]:
    """Replay a run with its recorded answers; before each round, yield the world and the questions of this round."""
    world, left = scenario.start(seed), list(reversed(past))
    while not world.finished:
        pending = world.pending()
        yield world, pending
        world.advance([_answer(question, left) for question in pending])


def _answer(question: Question, left: list[LoggedAnswer]) -> Answer:
    said = left.pop() if left else None
    if said is None or (said.step, said.agent, said.kind) != question.asked:
        step, agent, kind = question.asked
        raise RecordError(
            f"The world no longer asks its recorded questions. Asked now: the {kind} of agent {agent} at step {step}; "
            f"recorded: {'nothing' if said is None else f'the {said.kind} of agent {said.agent} at step {said.step}'}."
        )
    return said.answer


def by_run(moments: Iterable[Moment]) -> Mapping[str, list[Moment]]:
    """Return the moments of each run."""
    moments_by_run: dict[str, list[Moment]] = defaultdict(list)
    for moment in moments:
        moments_by_run[moment.run].append(moment)
    return moments_by_run
