"""Draws moments from recorded runs, or takes those of an earlier probe."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
from numpy.random import Generator

from foundry import seeding
from foundry.errors import InputError, RecordError, not_found
from foundry.records import NOT_JSON, Call
from foundry.storing.store import RunFolder
from foundry.worlds.probe.moments import Moment, Moments, Said, Source, by_run, digest_of

WINDOW = 5
"""Steps of which an agent gives one moment at most, since what it is asked in the next is much the same."""


@dataclass(frozen=True)
class Past:
    """What was asked in a run and answered.

    Attributes:
        seed: the run's seed.
        calls: its calls in their order, without prompts and without what says how they were sent.
    """

    seed: int
    calls: Sequence[Call]

    @classmethod
    def of(cls, run: RunFolder) -> Past:
        """Read a run."""
        return cls(run.run.seed, [_bare(call) for call in run.calls()])

    def up_to(self, step: int) -> Past:
        """Return what was asked up to a step."""
        return Past(self.seed, [call for call in self.calls if call.step <= step])

    def digest(self) -> str:
        """Return the SHA-256 of what was answered."""
        return digest_of(msgspec.convert(call, Said, from_attributes=True) for call in self.calls)

    def moments(self, run: str) -> Iterator[Moment]:
        """Yield every question as a moment."""
        asked = Counter[tuple[int, int, str]]()
        for call in self.calls:
            place = call.step, call.agent, call.kind
            yield Moment(run, *place, asked[place])
            asked[place] += 1


def _bare(call: Call) -> Call:
    return msgspec.structs.replace(call, messages=[], host=None, attempts=(), served_model=None, server_version=None)


def drawn(recorded: Mapping[str, Past], count: int, seed: int) -> list[Moment]:
    """Return this many moments, or all that there are; at most one of each agent in a window of steps.

    The runs have equally many as far as they can, and so, in each of them, the windows and kinds of question.

    Args:
        recorded: the runs by their ids.
        count: how many.
        seed: what they are drawn by.
    """
    rng = seeding.stream(seed, "moments")
    queues = [_in_turns(_of_run(rng, past.moments(run)), rng) for run, past in sorted(recorded.items())]
    order = [queues[place] for place in rng.permutation(len(queues))]
    return sorted(moment for moment, _ in zip(_round_robin(order), range(count), strict=False))


def _of_run(rng: Generator, moments: Iterable[Moment]) -> dict[tuple[int, str], list[Moment]]:
    """Return one moment of each agent and window, of a kind that is drawn first, by window and kind."""
    known: dict[tuple[int, int], dict[str, list[Moment]]] = defaultdict(lambda: defaultdict(list))
    for moment in moments:
        known[moment.agent, (moment.step - 1) // WINDOW][moment.kind].append(moment)
    strata: dict[tuple[int, str], list[Moment]] = defaultdict(list)
    for (_, window), kinds in sorted(known.items()):
        kind = sorted(kinds)[rng.integers(len(kinds))]
        strata[window, kind].append(kinds[kind][rng.integers(len(kinds[kind]))])
    return strata


def _in_turns(strata: Mapping[tuple[int, str], list[Moment]], rng: Generator) -> Iterator[Moment]:
    """Yield the moments of one stratum after the other in turn, each in a drawn order."""
    shuffled = [[mine[place] for place in rng.permutation(len(mine))] for mine in strata.values()]
    return _round_robin([iter(shuffled[place]) for place in rng.permutation(len(shuffled))])


def _round_robin(queues: Iterable[Iterator[Moment]]) -> Iterator[Moment]:
    """Yield the first of each, then the next of each, until all are empty."""
    left = list(queues)
    while left:
        still = []
        for queue in left:
            if (moment := next(queue, None)) is not None:
                yield moment
                still.append(queue)
        left = still


def listed(file: Path, recorded: Mapping[str, Past]) -> list[Moment]:
    """Return the moments that an earlier probe wrote down.

    Raises:
        InputError: the file cannot be read, or is of other runs.
    """
    try:
        found = msgspec.json.decode(file.read_bytes(), type=Moments)
    except OSError as error:
        raise InputError(f"moments={file} cannot be read: give a number, or the moments.json of a probe.") from error
    except NOT_JSON as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    if not found.moments:
        raise InputError(f"moments={file} lists no moment.")
    for run in by_run(found.moments):
        if run not in recorded:
            raise not_found("Run", run, recorded, f"{file} lists moments of it.")
    if moments_of(found.moments, recorded)[0] != found:
        raise InputError(f"moments={file} is of runs that answered otherwise: give the sweep that it was drawn from.")
    return list(found.moments)


def moments_of(moments: Sequence[Moment], recorded: Mapping[str, Past]) -> tuple[Moments, dict[str, Past]]:
    """Return the moments as they are kept, and the past of each run as far as it is needed."""
    last = {run: max(moment.step for moment in mine) for run, mine in by_run(moments).items()}
    past = {run: recorded[run].up_to(step) for run, step in sorted(last.items())}
    runs = {run: Source(seed=one.seed, sha256=one.digest()) for run, one in past.items()}
    return Moments(runs=runs, moments=tuple(moments)), past
