"""Reads the records of a probe: how often each model chose what in each moment."""

import itertools
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import msgspec

from analysis.lines import COMPLETE
from analysis.load import status
from foundry.naming import Subject as Subject
from foundry.naming import format_of, names_of
from foundry.storing.probed import Choices, choices_in
from foundry.storing.store import RunFolder

NONE = "none"
"""The name that stands for no edit, and for the unchanged format of a prompt."""
PROBABILITIES, REPEATS = "probabilities", "repeats"
"""The share of a choice in a moment comes from the probabilities of one reply, or from repeated calls."""


class MomentKey(NamedTuple):
    """Identifies a recorded question; `seed` is the seed of its run."""

    seed: int
    run: str
    step: int
    agent: int
    kind: str
    again: int


Chosen: TypeAlias = dict[MomentKey, Counter[str]]
"""Count of each choice by moment. Probabilities are scaled to counts with the sum `foundry.storing.probed.ANSWERS`."""


class ProbeCondition(NamedTuple):
    """A way of asking: a subject (a model with its prompt), an edit, and a format of the prompt."""

    subject: Subject
    edit: str
    format: str


@dataclass(frozen=True)
class Change:
    """The quantity that an edit sets, and the actions that are expected after the edit.

    Attributes:
        leaves: `invariance`, `equivariance` or `cause`.
        expected: for each action, the action expected after the edit.
        moves: quantity that the edit sets; "" if it sets none.
        to: value to which it sets the quantity.
    """

    name: str
    leaves: str
    expected: Mapping[str, str] = field(default_factory=dict)
    moves: str = ""
    to: float = float("nan")

    @property
    def is_edit(self) -> bool:
        """True if the observation is edited, but the edit does not set a quantity."""
        return self.name != NONE and not self.moves

    def carried(self, counts: Counter[str]) -> Counter[str]:
        """Convert counts of choices before the edit to expected counts after it."""
        moved: Counter[str] = Counter()
        for choice, count in counts.items():
            moved[self.expected.get(choice, choice)] += count
        return moved


@dataclass(frozen=True)
class Answers:
    """The choices in a probe.

    Attributes:
        chosen: counts of choices, by subject, edit and format.
        changes: the edits by name, in the order of the command.
        formats: formats of prompts, in the order of the command.
        names: name of each subject: its model, and its prompt or sampling seed if subjects differ in them.
        missing: number of incomplete runs.
        told: moments with shares from probabilities, with the number of calls and the error of the shares.
    """

    chosen: Mapping[ProbeCondition, Chosen]
    changes: Mapping[str, Change]
    formats: tuple[str, ...]
    names: Mapping[Subject, str]
    missing: int
    told: Mapping[tuple[ProbeCondition, MomentKey], Choices] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of answers."""
        return sum(self.called(asked, key).total() for asked, moments in self.chosen.items() for key in moments)

    def called(self, asked: ProbeCondition, key: MomentKey) -> Counter[str]:
        """Return how many calls in a moment gave each choice."""
        by_probability = self.told.get((asked, key))
        return self.chosen[asked][key] if by_probability is None else by_probability.called

    def shares(self, asked: ProbeCondition, key: MomentKey) -> Mapping[str, float]:
        """Return the share of each choice in a moment."""
        counts, by_probability = self.chosen[asked][key], self.told.get((asked, key))
        return (
            {choice: count / counts.total() for choice, count in counts.items()}
            if by_probability is None
            else by_probability.expected
        )

    def by(self, asked: ProbeCondition, key: MomentKey) -> str:
        """Return whether the shares of choices in a moment come from probabilities or from repeated calls."""
        return PROBABILITIES if (asked, key) in self.told else REPEATS

    def of(self, subject: Subject, edit: str = NONE, format: str = NONE) -> Chosen:
        """Return a subject's choices under an edit and a format; empty if the subject was not asked so."""
        return self.chosen.get(ProbeCondition(subject, edit, format), {})

    def edited(self) -> Iterator[tuple[Subject, Change]]:
        """Yield each pair of a subject (a model with its prompt) and an edit."""
        return (pair for pair in itertools.product(self.names, self.changes.values()) if pair[1].is_edit)

    def expected(self, subject: Subject, change: Change) -> Chosen:
        """Return the choices that a subject should make under an edit, computed from its choices without the edit."""
        return {key: change.carried(counts) for key, counts in self.of(subject).items()}


def read_answers(runs: Iterable[RunFolder]) -> Answers:
    """Read the complete runs of a probe.

    Raises:
        RecordError: a file is damaged.
    """
    chosen: dict[ProbeCondition, Chosen] = defaultdict(dict)
    probabilities: dict[tuple[ProbeCondition, MomentKey], Choices] = {}
    formats: dict[str, None] = {}
    changes: dict[str, Change] = {}
    missing = 0
    for run in runs:
        config = run.config()
        edit = config["world"]["edit"]
        changes.setdefault(edit["name"], msgspec.convert(edit, Change))
        if status(run, run.summary()) != COMPLETE:
            missing += 1
            continue
        formats.setdefault(written := format_of(config["prompt"]))
        asked = ProbeCondition(Subject.of(config), edit["name"], written)
        for place, choices in choices_in(run).items():
            key = MomentKey(config["seed"], *place)
            chosen[asked][key] = choices.counts
            if choices.expected:
                probabilities[asked, key] = choices
    return Answers(
        dict(chosen), changes, tuple(formats), names_of(subject.subject for subject in chosen), missing, probabilities
    )
