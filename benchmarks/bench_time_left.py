"""Measures the error of the time left of a sweep on simulated servers, with a simulated clock."""

import heapq
import io
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np
from measuring import print_table, print_title, scratch
from rich.console import Console

from foundry.composing.compose import compose
from foundry.display import ProgressDisplay
from foundry.expansion import expand
from foundry.models.wrappers.climbing import Climb, Sums
from foundry.running.lane import Tally
from foundry.storing.store import SweepFolder, write_atomically

AGENTS, STEPS, KINDS = 5, 10, 2
MOST = AGENTS * STEPS * KINDS
"""Maximum number of calls of a run."""
FROM_CALL = 10
TOLD_AT = (10, 50, 200)
LAST = 0.1
"""Share of the time at the end that is left out, because it depends only on the last replies."""
LOOK_S = 1.0
SPREAD = 0.5
"""Standard deviation of the logarithm of a reply's seconds."""
SEEDS = range(5)

Seconds = Callable[[np.random.Generator, int], float]


def even(mean: float) -> Seconds:
    return lambda rng, step: mean


def uneven(mean: float) -> Seconds:
    return lambda rng, step: mean * float(rng.lognormal(-(SPREAD**2) / 2, SPREAD))


def growing(mean: float) -> Seconds:
    """The last step takes 1.8 times as long as the first one."""
    return lambda rng, step: mean * (1 + 0.8 * (step - 1) / (STEPS - 1))


@dataclass
class Simulated:
    """A sweep on a simulated server like Ollama, which answers calls in their order in a number of slots.

    foundry does not know the number of slots; its limit on calls in flight begins as in `conf/model/ollama.yaml`.

    Attributes:
        seconds: seconds that a reply takes, by its step.
        load: seconds before the first call.
        cached: whether the cache knows a step of a run.
        steps: number of steps after which a run ends.
        at_once: number of runs that are played at the same time.
    """

    runs: int
    slots: int
    seconds: Seconds
    load: float = 0.0
    cached: Callable[[int, int], bool] = lambda run, step: False
    steps: Callable[[int], int] = lambda run: STEPS
    at_once: int = 16
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def __post_init__(self) -> None:
        self.now = self.load
        self.calls = [0] * self.runs
        self.hits = [0] * self.runs
        self.open: dict[int, int] = {}
        self.ended: list[int] = []
        self._left: dict[int, int] = {}
        self._todo = deque(range(self.runs))
        self._climb = Climb(least=1, most=256, initial=8)
        self._sums = Sums()
        self._waiting: deque[int] = deque()
        self._queue: deque[tuple[float, int]] = deque()
        self._busy: list[tuple[float, float, float, int]] = []

    def play(self) -> Iterator[float]:
        """Yield the simulated time whenever a user looks, and at the end."""
        looked = 0.0
        self._go_on()
        while self._busy:
            until = self._busy[0][0]
            while looked + LOOK_S < until:
                looked += LOOK_S
                yield looked
            run = self._end_call()
            self.calls[run] += 1
            self._left[run] -= 1
            if not self._left[run]:
                self._next_round(run)
            self._go_on()
        yield self.now

    def _end_call(self) -> int:
        """Move the clock to the end of the next call, report the call to the limit, and return its run."""
        ended, sent, seconds, run = heapq.heappop(self._busy)
        passed, self.now = ended - self.now, ended
        self._sums.clock_s += passed
        self._sums.in_flight_s += passed * (1 + len(self._busy) + len(self._queue))
        self._sums.waiting_s += passed * bool(self._waiting)
        self._sums.note(seconds, ended - sent, ended - sent - seconds)
        self._climb.look(self._sums)
        return run

    def _go_on(self) -> None:
        while self._todo and len(self.open) < self.at_once:
            run = self._todo.popleft()
            self.open[run] = 0
            self._next_round(run)
        while self._waiting and len(self._busy) + len(self._queue) < self._climb.limit:
            self._queue.append((self.now, self._waiting.popleft()))
        while self._queue and len(self._busy) < self.slots:
            sent, run = self._queue.popleft()
            seconds = self.seconds(self.rng, (self.open[run] - 1) // KINDS + 1)
            heapq.heappush(self._busy, (self.now + seconds, sent, seconds, run))

    def _next_round(self, run: int) -> None:
        while self.open[run] < KINDS * self.steps(run):
            self.open[run] += 1
            if not self.cached(run, (self.open[run] - 1) // KINDS + 1):
                self._left[run] = AGENTS
                self._waiting.extend([run] * AGENTS)
                return
            self.calls[run] += AGENTS
            self.hits[run] += AGENTS
        del self.open[run]
        self.ended.append(run)

    @property
    def sent(self) -> int:
        """Number of calls that the cache did not answer."""
        return sum(self.calls) - sum(self.hits)

    def report(self, names: list[str]) -> bytes:
        """Return the progress that a worker would report, by the names of the runs."""
        tally = Tally(complete=len(self.ended), calls=sum(self.calls), cached=sum(self.hits))
        tally.spared = sum(MOST - self.calls[run] for run in self.ended)
        counts = {names[run]: {"calls": self.calls[run], "cached": self.hits[run]} for run in self.open}
        return msgspec.json.encode({"pid": 1, "open": list(counts), "counts": counts, "models": {"stay": vars(tally)}})


SIMULATED: dict[str, Callable[[np.random.Generator], Simulated]] = {
    "1 slot, even replies": lambda rng: Simulated(4, 1, even(2), rng=rng),
    "4 slots, even replies": lambda rng: Simulated(8, 4, even(2), rng=rng),
    "4 slots, uneven replies": lambda rng: Simulated(8, 4, uneven(2), rng=rng),
    "8 slots, uneven replies": lambda rng: Simulated(10, 8, uneven(4), rng=rng),
    "a model that loads for 20 s": lambda rng: Simulated(6, 4, uneven(2), load=20, rng=rng),
    "the first half of each run cached": lambda rng: Simulated(
        20, 4, uneven(2), cached=lambda run, step: step <= STEPS // 2, rng=rng
    ),
    "every second run cached": lambda rng: Simulated(20, 4, uneven(2), cached=lambda run, step: run % 2 == 0, rng=rng),
    "replies that grow with the step": lambda rng: Simulated(8, 4, growing(2), rng=rng),
    "such replies, one run after the other": lambda rng: Simulated(8, 4, growing(2), at_once=1, rng=rng),
    "runs that end early": lambda rng: Simulated(
        20, 4, uneven(2), steps=lambda run: (6, 10, 8, 9)[run % 4], at_once=4, rng=rng
    ),
}


@dataclass
class Sample:
    """A time left that foundry printed: the time, the number of calls so far, and the seconds that it stated."""

    at: float
    sent: int
    left: float


def watched(simulated: Simulated, folder: Path) -> tuple[list[Sample], float]:
    """Return the times left that a user saw while a sweep ran, and the duration of the sweep in seconds."""
    composed = compose(
        ["-m", "model=stay", f"seed=0-{simulated.runs - 1}", f"world.agents={AGENTS}", f"world.steps={STEPS}"]
    )
    assert composed is not None
    sweep = SweepFolder.create(folder, expand(composed.asked, composed.conditions), {}, [])
    sweep.start_progress()
    now = 0.0
    display = ProgressDisplay(sweep, Console(file=io.StringIO(), width=120), clock=lambda: now)
    names, looks = [run.id for run in sweep.runs()], []
    for now in simulated.play():
        write_atomically(sweep.progress_file("0-0"), simulated.report(names))
        left = display.left_s(display.look())
        assert left is not None or simulated.sent < FROM_CALL
        looks.append(Sample(now, simulated.sent, left or 0.0))
    return looks, now


def ratio_at(looks: list[Sample], took: float, call: int) -> float:
    """Return the printed time left divided by the true time left, after a given number of calls."""
    look = next(look for look in looks if look.sent >= call)
    return look.left / (took - look.at)


def worst_ratio(looks: list[Sample], took: float) -> float:
    """Return the largest factor by which the printed time was wrong, from call 10 to the last tenth of the time."""
    counted = [look for look in looks if look.sent >= FROM_CALL and look.at <= (1 - LAST) * took]
    return max(max(look.left / (took - look.at), (took - look.at) / max(look.left, 1e-9)) for look in counted)


def main() -> None:
    print_title(
        "Time left",
        f"Printed over true time left on simulated servers, as the range over {len(SEEDS)} seeds. For uneven",
        f"replies, the logarithm of the length has a standard deviation of {SPREAD}. The factor is the largest",
        f"error from call {FROM_CALL} on, without the last {LAST:.0%} of the time.",
    )
    rows = []
    for name, make in SIMULATED.items():
        with scratch(in_memory=True) as folder:
            seen = [watched(make(np.random.default_rng(seed)), folder / str(seed)) for seed in SEEDS]
        ratios = [[ratio_at(*run, call) for run in seen] for call in TOLD_AT]
        worst = max(worst_ratio(*run) for run in seen)
        rows.append([name, *(f"{min(each):.2f} to {max(each):.2f}" for each in ratios), f"{worst:.2f}"])
    print_table(["server", *(f"at call {call}" for call in TOLD_AT), "worst factor"], rows)


if __name__ == "__main__":
    main()
