"""The records of a probe as counts: how often each model chose what in each moment."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import msgspec

from analysis.lines import COMPLETE
from analysis.load import status
from foundry.declared import Declared
from foundry.records import Outcome
from foundry.storing.store import RunFolder, lines_of

SPEAKS, SILENT, UNREAD = "speaks", "is silent", "unreadable"
"""What is chosen in a question that asks for words alone, and where no decision could be read."""
_READ = (Outcome.CHOSEN, Outcome.REPAIRED)


class MomentKey(NamedTuple):
    """Which recorded question it is; `seed` is that of its run."""

    seed: int
    run: str
    step: int
    agent: int
    kind: str
    again: int


Chosen: TypeAlias = dict[MomentKey, Counter[str]]
"""How often each choice was made, by moment."""


class Subject(NamedTuple):
    """Who is asked: a model with a prompt and a seed of its sampling, where several were asked for."""

    model: str
    prompt: str
    sampling_seed: str


class _Line(msgspec.Struct):
    """What is read of a line of `steps.jsonl`."""

    step: int
    agent: int
    kind: str
    action: str | float | None
    outcome: Outcome
    message: str | None
    run: str
    again: int


@dataclass(frozen=True)
class Change:
    """What is known of an edit.

    Attributes:
        name: the edit.
        leaves: `invariance`, `equivariance` or `cause`.
        expected: what each action should become.
    """

    name: str
    leaves: str
    expected: Mapping[str, str] = field(default_factory=dict)

    def carried(self, counts: Counter[str]) -> Counter[str]:
        """Return choices as they should be where the edit is made."""
        moved: Counter[str] = Counter()
        for choice, count in counts.items():
            moved[self.expected.get(choice, choice)] += count
        return moved


@dataclass(frozen=True)
class Answers:
    """What was chosen in a probe.

    Attributes:
        chosen: the counts, by who was asked and the name of the edit.
        changes: the edits by their names, in the order they were asked for.
        names: what each subject is called: its model, with more only where that tells subjects apart.
        missing: runs that are not complete.
    """

    chosen: Mapping[tuple[Subject, str], Chosen]
    changes: Mapping[str, Change]
    names: Mapping[Subject, str]
    missing: int

    def of(self, subject: Subject, edit: str) -> Chosen:
        """Return what a subject chose; nothing where it was not asked."""
        return self.chosen.get((subject, edit), {})


def read_answers(runs: Iterable[RunFolder]) -> Answers:
    """Read the complete runs of a probe.

    Raises:
        RecordError: a file is damaged.
    """
    chosen: dict[tuple[Subject, str], Chosen] = defaultdict(dict)
    changes: dict[str, Change] = {}
    missing = 0
    for run in runs:
        config = run.config()
        edit = config["world"]["edit"]
        changes.setdefault(edit["name"], Change(edit["name"], edit["leaves"], edit["expected"]))
        if status(run, run.summary()) != COMPLETE:
            missing += 1
            continue
        mine = chosen[_subject(config), edit["name"]]
        for line in lines_of(run.steps_bytes(), _Line, run.stream_path("steps")):
            key = MomentKey(config["seed"], line.run, line.step, line.agent, line.kind, line.again)
            mine.setdefault(key, Counter())[_choice(line, run.declared)] += 1
    return Answers(dict(chosen), changes, _names({subject for subject, _ in chosen}), missing)


def _choice(line: _Line, declared: Declared) -> str:
    if line.outcome not in _READ:
        return UNREAD
    if line.kind not in declared.actions:
        return SILENT if line.message is None else SPEAKS
    return line.action if isinstance(line.action, str) else f"{line.action:g}"


def _subject(config: Mapping[str, Any]) -> Subject:
    sampling = config["sampling_seed"]
    return Subject(config["model"]["name"], config["prompt"]["name"], "" if sampling is None else str(sampling))


def _names(subjects: set[Subject]) -> dict[Subject, str]:
    """Return what to call each: all that not all share, the model always."""
    told = [place for place in range(len(Subject._fields)) if place == 0 or len({one[place] for one in subjects}) > 1]
    return {one: " / ".join(filter(None, (one[place] for place in told))) for one in sorted(subjects)}
