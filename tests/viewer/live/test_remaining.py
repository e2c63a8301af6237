"""When a sweep ends: sweeps are made up whose end is known, and looked at before it."""

from __future__ import annotations

import heapq

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundry.viewer.remaining import SHARE, Begun, ModelRuns, Remaining, remaining

CALLS = 48
PLACES = 16


class MadeUp:
    """A sweep whose runs take log-normal times and make their calls at an even pace, each on the first free place.

    Where a server is at its limit, the runs that are open share it: the fewer they are, the faster they go.
    """

    def __init__(self, rng: np.random.Generator, runs: int, spread: float, *, early: bool, shared: bool) -> None:
        """Draw the runs; where they may end early, they make a part of their calls and take as much less time."""
        self.shared = shared
        self.calls = rng.integers(CALLS // 4, CALLS + 1, runs) if early else np.full(runs, CALLS)
        self.work = rng.lognormal(4.0, spread, runs) * self.calls / CALLS
        self.starts, self.ends, self.done_at_start = np.zeros(runs), np.zeros(runs), np.zeros(runs)
        self.times, self.done = [0.0], [0.0]
        at_work: list[tuple[float, int]] = []
        waiting = list(range(runs))[::-1]
        while waiting or at_work:
            while waiting and len(at_work) < PLACES:
                run = waiting.pop()
                self.starts[run], self.done_at_start[run] = self.times[-1], self.done[-1]
                heapq.heappush(at_work, (self.done[-1] + self.work[run], run))
            pace = PLACES / len(at_work) if shared else 1.0
            done, run = heapq.heappop(at_work)
            self.times.append(self.times[-1] + (done - self.done[-1]) / pace)
            self.done.append(done)
            self.ends[run] = self.times[-1]
        self.end = self.times[-1]

    def at(self, now: float) -> ModelRuns:
        """Return the runs as they are seen at a time."""
        ended = self.ends <= now
        at_work = np.flatnonzero((self.starts <= now) & ~ended)
        made = (np.interp(now, self.times, self.done) - self.done_at_start) / self.work * self.calls
        seconds = self.ends - self.starts
        return ModelRuns(
            [Begun(seconds[run], int(self.calls[run])) for run in np.flatnonzero(ended)],
            [Begun(now - self.starts[run], int(made[run]), CALLS) for run in at_work],
            int((self.starts > now).sum()),
            self.shared,
        )


def looked_at(made: MadeUp, share: float) -> Remaining:
    return remaining([[made.at(share * made.end)]], PLACES)


@pytest.mark.parametrize(
    ("spread", "early", "shared"), [(0.6, False, False), (1.0, False, False), (0.6, True, False), (0.6, False, True)]
)
def test_the_interval_holds_the_end_about_as_often_as_it_says(spread: float, early: bool, shared: bool):
    rng = np.random.default_rng(7)
    held, middles, widths = [], [], []
    for share in (0.3, 0.5, 0.8):
        for runs in (60, 120, 240) * 5:
            made = MadeUp(rng, runs, spread, early=early, shared=shared)
            found, truth = looked_at(made, share), (1 - share) * made.end
            held.append(found.low_s <= truth <= found.high_s)
            middles.append(found.middle_s / truth)
            widths.append((found.high_s - found.low_s) / truth)
    assert np.mean(held) > SHARE - 0.15
    assert np.median(widths) < 1
    assert 0.8 < np.median(middles) < 1.2


def test_the_nearer_the_end_the_shorter_the_interval():
    made = MadeUp(np.random.default_rng(3), 200, 0.6, early=False, shared=False)
    widths = [found.high_s - found.low_s for found in (looked_at(made, share) for share in (0.1, 0.5, 0.9))]
    assert widths == sorted(widths, reverse=True)


@pytest.mark.parametrize("made", [12, 13, 24, 36])
def test_a_run_that_makes_more_calls_than_all_that_ended_takes_as_much_longer_as_it_may(made: int):
    short, long = [Begun(10.0, 12)] * 5, [Begun(10.0 * made / 12, made, CALLS)]
    found = remaining([[ModelRuns(short, long, 0)]], 1)
    assert found.low_s > 0 and found.middle_s == pytest.approx(10.0 * (CALLS - made) / 12, rel=0.5)


def test_a_run_that_has_made_all_its_calls_and_is_open_is_not_over():
    found = remaining([[ModelRuns([], [Begun(60.0, CALLS, CALLS)], 0)]], 1)
    assert found.low_s >= 0 and found.high_s > 0.1


@pytest.mark.parametrize("waiting", [16, 160, 1600])
def test_models_that_are_played_one_after_the_other_take_as_long_as_both(waiting: int):
    half = ModelRuns([Begun(60.0, CALLS)] * 40, [], waiting)
    one, both = remaining([[half]], PLACES), remaining([[half], [half]], PLACES)
    assert one.middle_s == pytest.approx(60.0 * waiting / PLACES, rel=0.2)
    assert both.middle_s == pytest.approx(2 * one.middle_s, rel=0.1)


def test_the_fewer_runs_have_begun_the_less_certain_is_how_long_the_others_take():
    shown = [remaining([[ModelRuns([Begun(60.0, CALLS)] * ended, [], 160)]], PLACES) for ended in (1, 4, 16, 64)]
    widths = [found.high_s - found.low_s for found in shown]
    assert widths == sorted(widths, reverse=True) and widths[0] > 60


BEGUN = st.builds(Begun, st.floats(0, 1e6), st.integers(0, 99), st.integers(0, 99))
MODELS = st.builds(
    ModelRuns, st.lists(BEGUN, max_size=4), st.lists(BEGUN, max_size=4), st.integers(0, 300), st.booleans()
)


@settings(max_examples=40)
@given(st.lists(st.lists(MODELS.filter(lambda runs: runs.known), max_size=2), max_size=2), st.integers(1, 20))
def test_whatever_has_begun_the_end_is_some_time_from_now(phases: list[list[ModelRuns]], places: int):
    found = remaining(phases, places)
    assert 0 <= found.low_s <= found.middle_s <= found.high_s < float("inf")
    assert (found.high_s > 0) <= any(models.left for phase in phases for models in phase)


def test_no_time_is_left_where_all_have_ended_and_nothing_is_known_before_the_first_call():
    ended = ModelRuns([Begun(60.0, CALLS)], [], 0)
    assert remaining([[ended]], PLACES) == Remaining(0.0, 0.0, 0.0) and not ended.left
    assert not ModelRuns([], [Begun(1.0, 0, CALLS)], 3).known and ModelRuns([], [Begun(1.0, 1, CALLS)], 3).known
