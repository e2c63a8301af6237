"""Draws the moments of a probe from recorded runs, or reads the moments of an earlier probe."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import msgspec
from numpy.random import Generator

from foundry import seeding
from foundry.errors import InputError, not_found
from foundry.records import Call
from foundry.storing.matching import numbered, place_of
from foundry.storing.store import RunFolder
from foundry.worlds.base import Scenario
from foundry.worlds.probe.moments import (
    LoggedAnswer,
    Moment,
    Moments,
    Source,
    Strata,
    asked_in,
    by_run,
    digest_of,
    moments_in,
)

_Stratum: TypeAlias = tuple[Any, ...]
"""The kind of a question, and its strata as pairs of name and value."""
_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Past:
    """The recorded calls of a run, with its seed.

    Attributes:
        calls: the calls in order, without prompts and details about servers.
    """

    seed: int
    calls: Sequence[Call]

    @classmethod
    def of(cls, run: RunFolder) -> "Past":
        """Read a run."""
        return cls(run.run.seed, [_bare(call) for call in run.calls()])

    def up_to(self, step: int) -> "Past":
        """Return a copy with only the calls up to and including a step."""
        return Past(self.seed, [call for call in self.calls if call.step <= step])

    def said(self) -> list[LoggedAnswer]:
        """Return the answers."""
        return [msgspec.convert(call, LoggedAnswer, from_attributes=True) for call in self.calls]

    def digest(self) -> str:
        """Return the SHA-256 of the answers."""
        return digest_of(self.said())

    def moments(self, run: str) -> Iterator[Moment]:
        """Yield a moment for each question."""
        for (place, again), _ in numbered(self.calls, place_of):
            yield Moment(run, *place, again)


def _bare(call: Call) -> Call:
    return msgspec.structs.replace(
        call, messages=[], host=None, attempts=(), served_model=None, server_version=None, remote=None
    )


def strata_of(scenario: Scenario, recorded: Mapping[str, Past]) -> dict[Moment, Strata]:
    """Replay runs to find the strata of every moment; return nothing if the world defines no strata.

    Raises:
        RecordError: the world no longer asks the recorded questions.
    """
    if type(scenario).strata is Scenario.strata:
        return {}
    return {
        Moment(run, *question.asked, again): dict(scenario.strata(question))
        for run, past in recorded.items()
        for question, again in asked_in(scenario, past.seed, past.said())
    }


def drawn(
    recorded: Mapping[str, Past], count: int, seed: int, window: int, strata: Mapping[Moment, Strata]
) -> list[Moment]:
    """Draw `count` moments, or return all if there are fewer.

    Moments are spread evenly over the runs, within a run over the strata, and within a stratum over the windows. A
    stratum is a kind of question with certain values of the world's own strata.

    Args:
        recorded: the runs by id.
        count: number of moments.
        seed: seed of the draw.
        window: number of steps from which an agent gives at most one moment, since its next questions are similar; 0
            for no limit.
        strata: the world's own strata of each moment.
    """
    rng = seeding.stream(seed, "moments")
    queues = [_evenly(_of_run(rng, past.moments(run), window, strata), rng) for run, past in sorted(recorded.items())]
    order = [queues[place] for place in rng.permutation(len(queues))]
    return sorted(moment for moment, _ in zip(_round_robin(order), range(count), strict=False))


def _of_run(
    rng: Generator, moments: Iterable[Moment], window: int, strata: Mapping[Moment, Strata]
) -> dict[_Stratum, dict[int, list[Moment]]]:
    """Draw one moment of each agent in each window of steps; return these moments by stratum and window.

    The kind of the question is drawn first, then the stratum, then the moment.
    """
    near: dict[Any, dict[str, dict[_Stratum, list[Moment]]]] = {}
    for moment in moments:
        kinds = near.setdefault((moment.agent, (moment.step - 1) // window) if window else moment, {})
        stratum = (moment.kind, *sorted(strata.get(moment, {}).items()))
        kinds.setdefault(moment.kind, {}).setdefault(stratum, []).append(moment)
    by_stratum: dict[_Stratum, dict[int, list[Moment]]] = {}
    for _, kinds in sorted(near.items()):
        of_kind = kinds[_one(rng, sorted(kinds))]
        stratum = _one(rng, sorted(of_kind))
        moment = _one(rng, of_kind[stratum])
        by_stratum.setdefault(stratum, {}).setdefault((moment.step - 1) // (window or 1), []).append(moment)
    return by_stratum


def _one(rng: Generator, among: Sequence[_Item]) -> _Item:
    return among[int(rng.integers(len(among)))]


def _evenly(strata: Mapping[_Stratum, Mapping[int, list[Moment]]], rng: Generator) -> Iterator[Moment]:
    """Yield moments of all strata in turn; the moments of a stratum come from all its windows of steps in turn."""
    queues = [_in_turns(list(strata[stratum].values()), rng) for stratum in sorted(strata)]
    return _round_robin([queues[place] for place in rng.permutation(len(queues))])


def _in_turns(groups: Sequence[list[Moment]], rng: Generator) -> Iterator[Moment]:
    """Yield all moments: in turn one of each group, in random order within a group."""
    shuffled = [[mine[place] for place in rng.permutation(len(mine))] for mine in groups]
    return _round_robin([iter(shuffled[place]) for place in rng.permutation(len(shuffled))])


def _round_robin(queues: Iterable[Iterator[Moment]]) -> Iterator[Moment]:
    left = list(queues)
    while left:
        still = []
        for queue in left:
            if (moment := next(queue, None)) is not None:
                yield moment
                still.append(queue)
        left = still


def listed(file: Path, recorded: Mapping[str, Past]) -> Moments:
    """Read the moments of an earlier probe from its `moments.json`.

    Raises:
        InputError: the file does not exist, or belongs to other runs.
        RecordError: the file cannot be read.
    """
    if not file.is_file():
        raise InputError(f"moments={file} is not a file. Give a number, or the moments.json of a probe.")
    moments = moments_in(file)
    if not moments.moments:
        raise InputError(f"moments={file} lists no moment. Give a number, or the moments.json of a probe.")
    for run in by_run(moments.moments):
        if run not in recorded:
            raise not_found("Run", run, recorded, f"{file} lists moments of this run.")
    if moments_and_past(moments.moments, recorded)[0].runs != moments.runs or list(moments.moments) != sorted(
        set(moments.moments)
    ):
        raise InputError(f"moments={file} was drawn from runs with other answers. Name the sweep with those runs.")
    return moments


def moments_and_past(
    moments: Sequence[Moment], recorded: Mapping[str, Past], strata: Sequence[Strata] = ()
) -> tuple[Moments, dict[str, Past]]:
    """Return the content of `moments.json`, and the calls of each run up to its last moment."""
    last = {run: max(moment.step for moment in mine) for run, mine in by_run(moments).items()}
    past = {run: recorded[run].up_to(step) for run, step in sorted(last.items())}
    runs = {run: Source(seed=source.seed, sha256=source.digest()) for run, source in past.items()}
    return Moments(runs=runs, moments=tuple(moments), strata=tuple(dict(values) for values in strata)), past
