"""Frequencies of the choices in the moments of a probe's run, from counts or from probabilities."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import msgspec

from foundry.certainty import Certainty, Sampling, Shares, foreseen
from foundry.records import Call, Outcome, choice_of
from foundry.storing.matching import with_calls
from foundry.storing.store import RunFolder, lines_of

ANSWERS = 1000
"""Number of answers for which a moment counts if the probabilities of one reply replace the repeats."""
Place: TypeAlias = tuple[str, int, int, str, int]
"""Run, step, agent, kind and again of a moment."""


class _Line(msgspec.Struct):
    """The needed part of a line of `steps.jsonl`."""

    step: int
    agent: int
    kind: str
    action: str | float | None
    outcome: Outcome
    message: str | None
    run: str
    again: int
    repeat: int

    @property
    def place(self) -> Place:
        return self.run, self.step, self.agent, self.kind, self.again


@dataclass
class Choices:
    """The frequencies of the choices in a moment.

    Attributes:
        expected: share of each choice by the probabilities of one reply; empty if the moment was asked repeatedly.
        error: largest possible total variation between these shares and the true shares, 0..1.
    """

    called: Counter[str] = field(default_factory=Counter)
    expected: Shares = field(default_factory=dict)
    error: float = 0.0

    @property
    def counts(self) -> Counter[str]:
        """Number of answers by choice: the calls, or ANSWERS divided by the expected shares and rounded."""
        return _dealt(self.expected) if self.expected else self.called


def choices_in(run: RunFolder) -> Mapping[Place, Choices]:
    """Return the choices in the moments of a probe's run.

    Raises:
        RecordError: a file is damaged.
    """
    lines = lines_of(run.steps_bytes(), _Line, run.stream_path("steps"))
    found: dict[Place, Choices] = {}
    for line in lines:
        found.setdefault(line.place, Choices()).called[choice_of(line, run.declared.actions)] += 1
    sampling = run.config()["world"].get("sampling")
    for place, told in _told(run, lines, Sampling.of(sampling) if sampling else None):
        found[place].expected, found[place].error = told.expected, told.error
    return found


def _told(run: RunFolder, lines: Sequence[_Line], sampling: Sampling | None) -> Iterator[tuple[Place, Certainty]]:
    """Yield the moments in which the first reply's probabilities replace the repeats, as the probe's world decides."""
    if sampling is None:
        return
    for line, call in with_calls((((line.step, line.agent, line.kind), line) for line in lines), run.calls()):
        told = None if call is None or line.repeat else _foreseen(run, line, call, sampling)
        if told is not None:
            yield line.place, told


def _foreseen(run: RunFolder, line: _Line, call: Call, sampling: Sampling) -> Certainty | None:
    actions = run.declared.actions.get(line.kind)
    if actions is None or line.action not in actions.labels or call.thinking or not call.logprobs:
        return None
    return foreseen(call.text, call.logprobs, str(line.action), actions.labels, sampling)


def _dealt(shares: Shares) -> Counter[str]:
    """Divide ANSWERS by shares that add up to 1; the largest remainders are rounded up."""
    counts = Counter({choice: int(share * ANSWERS) for choice, share in shares.items()})
    by_remainder = sorted(shares, key=lambda choice: (counts[choice] - shares[choice] * ANSWERS, choice))
    counts.update(by_remainder[: ANSWERS - counts.total()])
    return +counts
