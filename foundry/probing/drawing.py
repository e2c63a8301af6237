"""Draws moments from recorded runs, or reuses an earlier probe's moments."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import msgspec
from numpy.random import Generator

from foundry import seeding
from foundry.errors import InputError, RecordError, not_found
from foundry.records import NOT_JSON, Call
from foundry.storing.matching import numbered, place_of
from foundry.storing.store import RunFolder
from foundry.worlds.base import Scenario
from foundry.worlds.probe.moments import Moment, Moments, Said, Source, Strata, asked_in, by_run, digest_of

_Stratum: TypeAlias = tuple[Any, ...]
"""The kind of a question, followed by its strata as pairs."""
_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Past:
    """The questions and answers of a run.

    Attributes:
        calls: its calls in order, without prompts and details of the transport.
    """

    seed: int
    calls: Sequence[Call]

    @classmethod
    def of(cls, run: RunFolder) -> "Past":
        """Read a run."""
        return cls(run.run.seed, [_bare(call) for call in run.calls()])

    def up_to(self, step: int) -> "Past":
        """Return the calls up to a step."""
        return Past(self.seed, [call for call in self.calls if call.step <= step])

    def said(self) -> list[Said]:
        """Return the answers."""
        return [msgspec.convert(call, Said, from_attributes=True) for call in self.calls]

    def digest(self) -> str:
        """Return the SHA-256 of the answers."""
        return digest_of(self.said())

    def moments(self, run: str) -> Iterator[Moment]:
        """Yield every question as a moment."""
        for (place, again), _ in numbered(self.calls, place_of):
            yield Moment(run, *place, again)


def _bare(call: Call) -> Call:
    return msgspec.structs.replace(
        call, messages=[], host=None, attempts=(), served_model=None, server_version=None, remote=None
    )


def strata_of(scenario: Scenario, recorded: Mapping[str, Past]) -> dict[Moment, Strata]:
    """Return the strata of every moment; empty, without playing a run, if the world defines none.

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
    """Return `count` moments, or all if there are fewer.

    Moments are spread evenly over the runs; within a run over the strata (kind of question, and the world's strata);
    and within a stratum over the windows.

    Args:
        recorded: the runs by id.
        count: number of moments.
        seed: seed of the draw.
        window: number of steps in which an agent gives at most one moment, since its next questions are similar; 0 for
            no limit.
        strata: the world's strata of the moments.
    """
    rng = seeding.stream(seed, "moments")
    queues = [_evenly(_of_run(rng, past.moments(run), window, strata), rng) for run, past in sorted(recorded.items())]
    order = [queues[place] for place in rng.permutation(len(queues))]
    return sorted(moment for moment, _ in zip(_round_robin(order), range(count), strict=False))


def _of_run(
    rng: Generator, moments: Iterable[Moment], window: int, strata: Mapping[Moment, Strata]
) -> dict[_Stratum, dict[int, list[Moment]]]:
    """Return one moment per agent and window, by stratum and window. First its kind is drawn, then its stratum."""
    near: dict[Any, dict[str, dict[_Stratum, list[Moment]]]] = {}
    for moment in moments:
        kinds = near.setdefault((moment.agent, (moment.step - 1) // window) if window else moment, {})
        stratum = (moment.kind, *sorted(strata.get(moment, {}).items()))
        kinds.setdefault(moment.kind, {}).setdefault(stratum, []).append(moment)
    found: dict[_Stratum, dict[int, list[Moment]]] = {}
    for _, kinds in sorted(near.items()):
        of_kind = kinds[_one(rng, sorted(kinds))]
        stratum = _one(rng, sorted(of_kind))
        moment = _one(rng, of_kind[stratum])
        found.setdefault(stratum, {}).setdefault((moment.step - 1) // (window or 1), []).append(moment)
    return found


def _one(rng: Generator, among: Sequence[_Item]) -> _Item:
    return among[int(rng.integers(len(among)))]


def _evenly(strata: Mapping[_Stratum, Mapping[int, list[Moment]]], rng: Generator) -> Iterator[Moment]:
    """Yield moments from the strata in turn, and within each stratum from the windows in turn."""
    queues = [_in_turns(list(strata[one].values()), rng) for one in sorted(strata)]
    return _round_robin([queues[place] for place in rng.permutation(len(queues))])


def _in_turns(groups: Sequence[list[Moment]], rng: Generator) -> Iterator[Moment]:
    """Yield moments from the groups in turn, each group in a random order."""
    shuffled = [[mine[place] for place in rng.permutation(len(mine))] for mine in groups]
    return _round_robin([iter(shuffled[place]) for place in rng.permutation(len(shuffled))])


def _round_robin(queues: Iterable[Iterator[Moment]]) -> Iterator[Moment]:
    """Yield the first item of each queue, then the next of each, until all are empty."""
    left = list(queues)
    while left:
        still = []
        for queue in left:
            if (moment := next(queue, None)) is not None:
                yield moment
                still.append(queue)
        left = still


def listed(file: Path, recorded: Mapping[str, Past]) -> Moments:
    """Return the moments in an earlier probe's file.

    Raises:
        InputError: the file cannot be read, or belongs to other runs.
    """
    try:
        found = msgspec.json.decode(file.read_bytes(), type=Moments)
    except OSError as error:
        raise InputError(f"moments={file} cannot be read. Give a number, or the moments.json of a probe.") from error
    except NOT_JSON as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    if not found.moments:
        raise InputError(f"moments={file} lists no moment.")
    for run in by_run(found.moments):
        if run not in recorded:
            raise not_found("Run", run, recorded, f"{file} lists moments of this run.")
    if kept_of(found.moments, recorded)[0].runs != found.runs or list(found.moments) != sorted(set(found.moments)):
        raise InputError(f"moments={file} belongs to runs with other answers. Give the sweep that it was drawn from.")
    return found


def kept_of(
    moments: Sequence[Moment], recorded: Mapping[str, Past], strata: Sequence[Strata] = ()
) -> tuple[Moments, dict[str, Past]]:
    """Return the moments to store, and the needed past of each run."""
    last = {run: max(moment.step for moment in mine) for run, mine in by_run(moments).items()}
    past = {run: recorded[run].up_to(step) for run, step in sorted(last.items())}
    runs = {run: Source(seed=one.seed, sha256=one.digest()) for run, one in past.items()}
    return Moments(runs=runs, moments=tuple(moments), strata=tuple(dict(one) for one in strata)), past
