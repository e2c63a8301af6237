"""How long a sweep takes yet, judged by its runs that have begun, and how uncertain that is.

Runs that wait are drawn from those of their model that have begun, each of which counts once: who looked at ended runs
alone would see the short ones. An open run's whole time is its time so far over its share of the calls, the less
certain the less of it is done, and drawn towards that of the others accordingly. What is drawn is put onto the places
where runs are played, each onto the first that is free; the interval is that of the ends of many such draws. Whether a
server is at its limit is not known: then the last runs go the faster the fewer they are, and all places work to the
end. So half of the draws take that, the other half that each run keeps its pace.

Source: weights of a Bayesian bootstrap (Rubin 1981) with half of its counts, since few runs may have begun.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from foundry.seeding import stream

SHARE = 0.8
"""How often the interval is to hold the end."""
LATEST = 200
"""Ended runs of a model, the latest ones, that others are judged by."""
_DRAWS = 200
_SCHEDULED = 200
"""Runs that are put onto places one by one: the last ones. What comes before them keeps all places busy."""
_COURSE = 0.1
"""Relative error of an open run's whole time when half of its calls are made."""
_SPREAD, _FAR = 0.5, 1.5
"""Spread of the logarithm of times that is taken for one more run, and spreads from the mean that two more lie."""
_COUNT = 0.5
"""What a run counts in the bootstrap."""
_SHORTEST_S = 1e-3
FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Begun:
    """A run that has begun.

    Attributes:
        seconds: since its start, or up to its end.
        calls: so far, or in all.
        most: calls that it can make; 0 where that is not known.
    """

    seconds: float
    calls: int
    most: int = 0


@dataclass(frozen=True)
class ModelRuns:
    """The runs of one model: those that ended, those that are open, how many wait, and whether a server answers."""

    ended: Sequence[Begun]
    open: Sequence[Begun]
    waiting: int
    served: bool = False

    @property
    def left(self) -> bool:
        """Whether any of them has not ended."""
        return bool(self.open or self.waiting)

    @property
    def known(self) -> bool:
        """Whether any says how long they take."""
        return bool(self.ended or any(one.calls for one in self.open))

    def as_ended(self) -> list[Begun]:
        """Return the runs that have begun as they are when they end: open ones go on as fast as so far."""
        going = [run for run in self.open if run.calls and run.most]
        return [*self.ended, *(Begun(run.seconds * run.most / run.calls, run.most) for run in going)]


@dataclass(frozen=True)
class Remaining:
    """Seconds until the end: the median, and the ends of the interval that is to hold it in `SHARE` of all cases."""

    low_s: float
    middle_s: float
    high_s: float


@dataclass(frozen=True)
class _Drawn:
    """What was drawn for one model.

    Attributes:
        left: seconds that open runs take yet (draws, open runs).
        times: seconds that runs which have begun take as a whole, and two more (draws, runs).
        weights: how likely one that waits is like each of them (draws, runs).
        waiting: how many wait.
    """

    left: FloatArray
    times: FloatArray
    weights: FloatArray
    waiting: int


def remaining(phases: Sequence[Sequence[ModelRuns]], places: int) -> Remaining:
    """Return how long a sweep takes yet, if it goes on as it went.

    Args:
        phases: models whose runs are played one after the other, and in each those that are played together; of each
            some run has begun or is given as ended.
        places: runs that are played at once.
    """
    rng = stream(0, "end of a sweep")
    seconds = np.zeros(_DRAWS)
    for models in phases:
        if left := [_drawn(one, rng) for one in models if one.left]:
            seconds += _last_end(left, places, any(one.served for one in models), rng)
    low, middle, high = np.quantile(seconds, ((1 - SHARE) / 2, 0.5, (1 + SHARE) / 2))
    return Remaining(float(low), float(middle), float(high))


def _drawn(runs: ModelRuns, rng: Generator) -> _Drawn:
    elapsed = np.array([max(one.seconds, _SHORTEST_S) for one in runs.open], dtype=np.float64)
    ended = np.log([max(one.seconds, _SHORTEST_S) for one in runs.ended])
    share = _shares(runs, rng)
    known = share[0] > 0
    own, error = np.log(elapsed[known] / share[:, known]), _COURSE**2 * (1 / share[:, known] - 1)
    begun = np.concatenate([np.broadcast_to(ended, (_DRAWS, len(ended))), own], axis=1)
    center = begun.mean(axis=1, keepdims=True)
    squares = ((begun - center) ** 2).sum(axis=1, keepdims=True) - error.sum(axis=1, keepdims=True)
    spread = np.sqrt((np.maximum(squares, 0) + _SPREAD**2) / begun.shape[1])
    pull = np.zeros_like(share)
    pull[:, known] = spread**2 / (spread**2 + error)
    guess = np.broadcast_to(center, share.shape).copy()
    guess[:, known] += pull[:, known] * (own - center)
    whole = np.maximum(np.exp(guess + np.sqrt(1 - pull) * spread * rng.normal(size=share.shape)), elapsed)
    more = np.exp(center + spread * np.array([-_FAR, _FAR]))
    times = np.concatenate([np.exp(begun[:, : len(ended)]), whole, more], axis=1)
    weights = rng.dirichlet(np.full(times.shape[1], _COUNT), _DRAWS)
    return _Drawn(whole - elapsed, times, weights, runs.waiting)


def _shares(runs: ModelRuns, rng: Generator) -> FloatArray:
    """Return the share of its calls that each open run has made (draws, open runs), of as many as an ended one made."""
    totals = np.sort([one.calls for one in runs.ended])
    made = np.array([one.calls for one in runs.open], dtype=np.float64)
    most = np.array([max(one.most, one.calls + 1) for one in runs.open], dtype=np.float64)
    first = np.searchsorted(totals, made, side="right")
    if not len(totals):
        return np.broadcast_to(made / most, (_DRAWS, len(made)))
    drawn = first + (rng.random((_DRAWS, len(made))) * (len(totals) - first)).astype(np.int64)
    return made / np.where(first < len(totals), totals[np.minimum(drawn, len(totals) - 1)], most)


def _last_end(models: Sequence[_Drawn], places: int, served: bool, rng: Generator) -> FloatArray:
    """Return when the last of the runs ends that are played together, seconds (draws,)."""
    free = np.concatenate([one.left for one in models], axis=1)
    free = np.pad(free, ((0, 0), (0, max(0, places - free.shape[1]))))
    part = min(1.0, _SCHEDULED / max(1, sum(one.waiting for one in models)))
    last = []
    for one in models:
        scheduled = round(part * one.waiting)
        mean = (one.weights * one.times).sum(axis=1)
        variance = (one.weights * (one.times - mean[:, None]) ** 2).sum(axis=1)
        before = one.waiting - scheduled
        together = before * mean + np.sqrt(before * variance) * rng.normal(size=_DRAWS)
        free = free + together[:, None] / free.shape[1]
        last.append(_picked(one, scheduled, rng))
    draws = np.arange(_DRAWS)
    for seconds in np.concatenate(last, axis=1).T:
        free[draws, free.argmin(axis=1)] += seconds
    shared = served & (draws % 2 == 1)
    return np.asarray(np.where(shared, free.mean(axis=1), free.max(axis=1)), dtype=np.float64)


def _picked(drawn: _Drawn, count: int, rng: Generator) -> FloatArray:
    """Return the times of so many runs that wait (draws, count)."""
    steps, chances = np.cumsum(drawn.weights, axis=1), rng.random((_DRAWS, count))
    places = np.stack([np.searchsorted(row, chance) for row, chance in zip(steps, chances, strict=True)])
    return np.take_along_axis(drawn.times, np.minimum(places, drawn.times.shape[1] - 1), axis=1)
