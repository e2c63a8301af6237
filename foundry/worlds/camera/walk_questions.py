"""Questions about a walk, with answers that are computed from its pictures and from the places of things.

Every question has one certain answer. A thing counts only if it is clearly visible or not visible at all, and compared
values must differ by a minimum. As far as the walk permits, all possible answers to a question are about equally
likely.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import msgspec
import numpy as np
from numpy.random import Generator

from foundry.declared import Actions
from foundry.records import Pose
from foundry.worlds.camera.loading.scene import FloatArray
from foundry.worlds.camera.surroundings import make_pose
from foundry.worlds.camera.things import Things

LETTERS = ("A", "B", "C", "D", "E", "F")
COUNTED = 3
"""Number of things that a `count` question names."""

FARTHER, FARTHER_M = 1.3, 0.5
"""Smallest ratio and smallest difference, in metres, of two distances that are compared."""

SIDE_DEG = (20.0, 160.0)
"""A thing on the left or right is between these angles from straight ahead, degrees."""

NEAREST_M, MOST_M = 0.5, 30.0
"""Smallest and largest distance of a thing that a `distance` question asks for, metres; larger answers are illegal."""

LEAST_SCALE_M = 0.5
"""A `distance` question is asked only if every constant answer has at least this mean error over all things, metres."""

ACTIONS: Mapping[str, Actions] = {
    "nearer": Actions(labels=LETTERS[:2]),
    "side": Actions(labels=("left", "right")),
    "count": Actions(low=0, high=COUNTED),
    "order": Actions(labels=LETTERS),
    "distance": Actions(low=0, high=MOST_M, whole=False),
}
"""The possible answers to each kind of question about a walk."""
_FILE = Path(__file__).with_suffix(".toml")
_TEXTS = msgspec.toml.decode(_FILE.read_bytes(), type=dict[str, dict[str, str]])


@dataclass(frozen=True)
class Probe:
    """A question and its right answer.

    Attributes:
        kind: one of ACTIONS.
        question: the question in words, by language.
        choices: text of each letter; empty if the answers are not letters.
        chance: probability that a random possible answer is right; None for a distance.
        scale: for a distance, the mean error of the best constant answer over all things, metres.
    """

    kind: str
    question: Mapping[str, str]
    choices: Mapping[str, str]
    truth: str | float
    chance: float | None
    scale: float | None = None


class Walk:
    """The things in a walk's pictures, and their directions from the end of the walk (the last pose of `frames`)."""

    def __init__(self, things: Things, frames: Sequence[Pose]) -> None:
        self._things, self.end = things, frames[-1]
        self._pixels = [things.pixels(pose) for pose in frames]

    def seen(self) -> list[str]:
        """Return the things that any picture shows with enough pixels, in alphabetical order."""
        return [name for name in self._things.names if self._first(name) is not None]

    def unseen(self) -> list[str]:
        """Return the things of which no picture shows a single pixel."""
        return [name for name in self._things.names if not any(pixels[name] for pixels in self._pixels)]

    def arrivals(self) -> dict[str, int]:
        """Return the number of the first picture of each thing, without things that are too small when first seen."""
        first_steps = {name: self._first(name) for name in self.seen()}
        return {
            name: first
            for name, first in first_steps.items()
            if first is not None and not any(pixels[name] for pixels in self._pixels[:first])
        }

    def distance(self, name: str) -> float:
        """Return the distance of a thing from the end, seen from above, metres."""
        return self._things.gap(name, self.end)

    def aside(self, name: str) -> float:
        """Return the angle from the heading at the end to a thing, degrees, left positive."""
        return self._things.aside(name, self.end)

    def _first(self, name: str) -> int | None:
        shown = (number for number, pixels in enumerate(self._pixels) if pixels[name] >= self._things.least_pixels)
        return next(shown, None)


def ask(kind: str, walk: Walk, rng: Generator) -> Probe | None:
    """Return a question of this kind about a walk, or None if the walk allows none."""
    return _ASKING[kind](walk, rng)


def _probe(
    kind: str,
    truth: str | float,
    chance: float | None,
    *,
    choices: Mapping[str, str] | None = None,
    scale: float | None = None,
    **named: str,
) -> Probe:
    question = {language: text.format(**named) for language, text in _TEXTS[kind].items()}
    return Probe(kind, question, choices or {}, truth, chance, scale)


def _nearer(walk: Walk, rng: Generator) -> Probe | None:
    far = {name: walk.distance(name) for name in walk.seen()}
    pairs = [
        (name, other)
        for name in far
        for other in far
        if far[other] >= FARTHER * far[name] and far[other] >= far[name] + FARTHER_M
    ]
    if not pairs:
        return None
    near, other = pairs[int(rng.integers(len(pairs)))]
    shown = [near, other] if rng.random() < 0.5 else [other, near]
    return _probe("nearer", LETTERS[shown.index(near)], 1 / 2, choices=dict(zip(LETTERS, shown, strict=False)))


def _side(walk: Walk, rng: Generator) -> Probe | None:
    low, high = SIDE_DEG
    turned = {name: walk.aside(name) for name in walk.seen()}
    sides = {
        side: [name for name, aside in turned.items() if low <= sign * aside <= high]
        for side, sign in (("left", 1), ("right", -1))
    }
    open_sides = [side for side, names in sides.items() if names]
    if not open_sides:
        return None
    side = open_sides[int(rng.integers(len(open_sides)))]
    name = sides[side][int(rng.integers(len(sides[side])))]
    return _probe("side", side, 1 / 2, name=name)


def _count(walk: Walk, rng: Generator) -> Probe | None:
    seen, unseen = walk.seen(), walk.unseen()
    possible = [shown for shown in range(COUNTED + 1) if shown <= len(seen) and COUNTED - shown <= len(unseen)]
    if not possible:
        return None
    shown = possible[int(rng.integers(len(possible)))]
    names = [*rng.permutation(seen)[:shown].tolist(), *rng.permutation(unseen)[: COUNTED - shown].tolist()]
    listed = ", ".join(str(name) for name in rng.permutation(names))
    return _probe("count", shown, 1 / (COUNTED + 1), listed=listed)


def _order(walk: Walk, rng: Generator) -> Probe | None:
    first: dict[int, list[str]] = {}
    for name, number in walk.arrivals().items():
        first.setdefault(number, []).append(name)
    if len(first) < 3:
        return None
    moments = sorted(int(moment) for moment in rng.permutation(sorted(first))[:3])
    names = tuple(first[moment][int(rng.integers(len(first[moment])))] for moment in moments)
    orders = list(permutations(names))
    shown = [orders[int(place)] for place in rng.permutation(len(orders))]
    choices = {letter: " → ".join(order) for letter, order in zip(LETTERS, shown, strict=True)}
    return _probe("order", LETTERS[shown.index(names)], 1 / len(orders), choices=choices)


def _distance(walk: Walk, rng: Generator) -> Probe | None:
    every = {name: walk.distance(name) for name in walk.seen()}
    far = {name: metres for name, metres in every.items() if NEAREST_M <= metres <= MOST_M}
    if not far:
        return None
    values = np.array(list(far.values()))
    scale = float(np.abs(values - np.median(values)).mean())
    if scale < LEAST_SCALE_M:
        return None
    name = list(far)[int(rng.integers(len(far)))]
    return _probe("distance", round(far[name], 3), None, scale=round(scale, 6), name=name)


_ASKING: Mapping[str, Callable[[Walk, Generator], Probe | None]] = {
    "nearer": _nearer,
    "side": _side,
    "count": _count,
    "order": _order,
    "distance": _distance,
}


def along(start: Pose, points: FloatArray, facing: float, number: int) -> list[Pose]:
    """Return the poses of `number` pictures of a path through (k, 3) points, metres.

    The first pose is the start with its own heading. The later poses are evenly spaced and look along the path; only
    the last one, at the end, has the heading `facing`.
    """
    lengths = np.hypot(*np.diff(points[:, :2], axis=0).T)
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.linspace(0.0, ends[-1], number - 1)
    poses = [start]
    for place in places[:-1]:
        piece = min(int(np.searchsorted(ends, place, side="right")) - 1, len(lengths) - 1)
        way = points[piece + 1] - points[piece]
        foot = points[piece] + way * ((place - ends[piece]) / max(lengths[piece], 1e-9))
        poses.append(make_pose(foot, math.degrees(math.atan2(way[1], way[0])), 0.0))
    return [*poses, make_pose(points[-1], facing, 0.0)]


def spread(poses: Sequence[Pose], number: int) -> list[int]:
    """Return the indices of this number of evenly spaced poses of a walk, with its first and last pose."""
    return sorted({round(place) for place in np.linspace(0, len(poses) - 1, min(number, len(poses))).tolist()})
