"""Replies as models of 1 to 8 billion parameters write them, labelled before anything was read of them.

`python tests/worlds/grid/reply_labels.py` prints how many are read as meant, and what was made up.

A label is what a person reads: an action and its direction, a message (null: silence), or null where nothing can be
told. The rules were written by others than the labels; `replies_held.jsonl` was not looked at while they were written.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.parsing import read_action, read_message

SETS = ("dev", "held")
_READ = (Outcome.CHOSEN, Outcome.REPAIRED)


class Labelled(msgspec.Struct, frozen=True, kw_only=True):
    """One reply: the question, its text, what is odd about it, why it ended, what a person reads."""

    question: str
    text: str
    kind: str
    ending: str
    expected: dict[str, Any] | None


@dataclass(frozen=True)
class Score:
    """How a set is read.

    Attributes:
        total: replies.
        right: read as labelled, unreadable ones included.
        decisions: replies with a decision.
        read: those of them that are read as meant.
        invented: replies from which a decision is read that is not in them.
        missed: what is not right, by what is odd about it.
    """

    total: int
    right: int
    decisions: int
    read: int
    invented: int
    missed: Counter[str]


def labelled(name: str) -> list[Labelled]:
    """Return a set of labelled replies."""
    lines = (Path(__file__).parent / f"replies_{name}.jsonl").read_bytes().splitlines()
    return [msgspec.json.decode(line, type=Labelled) for line in lines]


def read(one: Labelled) -> dict[str, Any] | None:
    """Return what the reader reads, in the form of a label."""
    answer = Answer(one.text, one.ending)
    if one.question == "message":
        said = read_message(answer)
        return {"message": said.text} if said.outcome in _READ else None
    done = read_action(answer)
    return {"action": done.action, "direction": done.direction} if done.outcome in _READ else None


def score(name: str) -> Score:
    """Return how a set is read."""
    replies = labelled(name)
    found = [(one, read(one)) for one in replies]
    right = [one for one, said in found if said == one.expected]
    return Score(
        total=len(replies),
        right=len(right),
        decisions=sum(one.expected is not None for one in replies),
        read=sum(one.expected is not None for one in right),
        invented=sum(said is not None and said != one.expected for one, said in found),
        missed=Counter(one.kind for one, said in found if said != one.expected),
    )


def main() -> None:
    """Print the scores."""
    for name in SETS:
        one = score(name)
        missed = ", ".join(f"{kind} {count}" for kind, count in one.missed.most_common()) or "nothing"
        sys.stdout.write(
            f"{name}: {one.right} of {one.total} right; {one.read} of {one.decisions} decisions read as meant; "
            f"{one.invented} invented; missed: {missed}\n"
        )


if __name__ == "__main__":
    main()
