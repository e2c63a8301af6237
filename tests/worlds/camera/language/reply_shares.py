"""What share of the labelled replies is read as a person reads them; run as a script, it prints them.

A reply is read `exactly` when translation, turn, gaze and staying are those of its label. Any other reading is
`invented` when it moves in a way that the label does not ask for (another kind, direction or amount), else `missed`.
The score is 1 - (missed + 10 * invented) / replies.
"""

from __future__ import annotations

import json
import math
import sys
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foundry.worlds.camera.language.command import Command
from foundry.worlds.camera.language.interpreter import interpret

HALVES = ("dev", "held", "vlm")
"""`held` was never looked at while the interpreter was written; `vlm` was written before it was changed."""

_TOLERANCE_M, _TOLERANCE_DEG = 0.01, 0.5


@dataclass(frozen=True)
class Shares:
    """How many replies were read in which way."""

    replies: int
    exactly: int
    invented: int

    @property
    def share(self) -> float:
        """The share that was read exactly as labelled."""
        return self.exactly / self.replies

    @property
    def score(self) -> float:
        """One minus the mean cost, where a motion that nobody asked for costs ten times a missed one."""
        missed = self.replies - self.exactly - self.invented
        return 1 - (missed + 10 * self.invented) / self.replies


def labelled(half: str) -> list[dict[str, Any]]:
    """Return labelled replies: text, move, turn, gaze, stay; of a half also language and kind."""
    lines = Path(__file__).with_name(f"replies_{half}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def counted(replies: Iterable[dict[str, Any]]) -> Shares:
    """Read the replies and count what came out."""
    verdicts = [verdict(reply, interpret(reply["text"])) for reply in replies]
    return Shares(len(verdicts), verdicts.count("exactly"), verdicts.count("invented"))


def by(replies: Iterable[dict[str, Any]], key: str) -> dict[str, Shares]:
    """Return the counts of the replies by one of their keys."""
    groups: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for reply in replies:
        groups[reply[key]].append(reply)
    return {name: counted(group) for name, group in sorted(groups.items())}


def verdict(label: dict[str, Any], command: Command) -> str:
    """Return `exactly`, `invented` or `missed`."""
    move = None if command.translate is None else (command.translate.bearing, command.translate.distance)
    pairs = [(move, label["move"]), (command.turn, label["turn"]), (command.gaze, label["gaze"])]
    same = [_is_same(read, asked) for read, asked in pairs]
    if all(same) and command.stay == label["stay"]:
        return "exactly"
    return (
        "invented" if any(read is not None and not ok for (read, _), ok in zip(pairs, same, strict=True)) else "missed"
    )


def _is_same(read: Any, asked: Any) -> bool:
    if read is None or asked is None:
        return read is asked
    if isinstance(read, tuple):
        return _is_angle(read[0], asked[0]) and math.isclose(read[1], asked[1], abs_tol=_TOLERANCE_M)
    return _is_angle(read, asked)


def _is_angle(read: float, asked: float) -> bool:
    if abs(abs(read) - 180) < _TOLERANCE_DEG:
        read = math.copysign(read, asked)
    return math.isclose(read, asked, abs_tol=_TOLERANCE_DEG)


def _written(name: str, shares: Shares) -> None:
    read = f"{shares.exactly:4} of {shares.replies:4} {shares.share:6.3f} exactly"
    sys.stdout.write(f"{name:24} {read}, {shares.invented:3} invented, score {shares.score:6.2f}\n")


if __name__ == "__main__":
    for half in HALVES:
        replies = labelled(half)
        _written(half, counted(replies))
        for key in ("language", "kind"):
            for name, shares in by(replies, key).items():
                _written(f"  {name}", shares)
