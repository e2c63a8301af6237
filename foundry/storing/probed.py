"""Counts how often a model made each choice in each moment of a probe.

If the probe asked a moment once and got log-probabilities, foundry computes the counts of this moment from them.
"""

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
"""If a moment is asked once and the reply has probabilities, these count as the shares of this number of answers."""
Place: TypeAlias = tuple[str, int, int, str, int]
"""A moment: its run, step, agent and kind of question, and how often this question was asked before in the step."""


class _Line(msgspec.Struct):
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
        called: number of replies with each choice.
        expected: share of each choice, from the probabilities of one reply; empty if the moment was asked repeatedly.
        error: largest possible total variation distance between these shares and the true shares, 0..1.
    """

    called: Counter[str] = field(default_factory=Counter)
    expected: Shares = field(default_factory=dict)
    error: float = 0.0

    @property
    def counts(self) -> Counter[str]:
        """Number of answers with each choice; shares from probabilities are turned into 1000 answers."""
        return _dealt(self.expected) if self.expected else self.called


def choices_in(run: RunFolder) -> Mapping[Place, Choices]:
    """Return the choices in each moment that a run of a probe asked about.

    Raises:
        RecordError: a file is damaged.
    """
    lines = lines_of(run.steps_bytes(), _Line, run.stream_path("steps"))
    choices: dict[Place, Choices] = {}
    for line in lines:
        choices.setdefault(line.place, Choices()).called[choice_of(line, run.declared.actions)] += 1
    sampling = run.config()["world"].get("sampling")
    for place, certainty in _certain_moments(run, lines, Sampling.of(sampling) if sampling else None):
        choices[place].expected, choices[place].error = certainty.expected, certainty.error
    return choices


def _certain_moments(
    run: RunFolder, lines: Sequence[_Line], sampling: Sampling | None
) -> Iterator[tuple[Place, Certainty]]:
    """Yield the moments that were asked once and whose reply has usable probabilities; with each, its probabilities."""
    if sampling is None:
        return
    for line, call in with_calls((((line.step, line.agent, line.kind), line) for line in lines), run.calls()):
        certainty = None if call is None or line.repeat else _foreseen(run, line, call, sampling)
        if certainty is not None:
            yield line.place, certainty


def _foreseen(run: RunFolder, line: _Line, call: Call, sampling: Sampling) -> Certainty | None:
    actions = run.declared.actions.get(line.kind)
    if actions is None or line.action not in actions.labels or call.thinking or not call.logprobs:
        return None
    return foreseen(call.text, call.logprobs, str(line.action), actions.labels, sampling)


def _dealt(shares: Shares) -> Counter[str]:
    """Turn the shares of the choices into whole numbers of answers with the sum 1000 (ANSWERS).

    All numbers are rounded down first; then those with the largest remainders get one more.
    """
    counts = Counter({choice: int(share * ANSWERS) for choice, share in shares.items()})
    by_remainder = sorted(shares, key=lambda choice: (counts[choice] - shares[choice] * ANSWERS, choice))
    counts.update(by_remainder[: ANSWERS - counts.total()])
    return +counts
