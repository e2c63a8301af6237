"""The first decision of each run that parts from another model's after the same prompt, as an event."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from analysis.figures.members import Member
from analysis.findings.moments import MESSAGE, PROMPT, Moment
from analysis.measuring.events import Event
from foundry.storing.store import RunFolder

EVENT = "first_parting"
FindMoment = Callable[[RunFolder, RunFolder, int, str], Moment | None]
"""`analysis.findings.moments.first_moment`, or the same with a memory."""


def first_partings(members: Sequence[Member], model: int, find: FindMoment) -> list[list[Event]]:
    """Return the parting of each run from the first model's run of its group and seed; none where they never part.

    The first model's run parts where the earliest other one parts from it. Baselines and unfinished runs have none.

    Args:
        members: the runs.
        model: place of the model in their groups.
        find: finds the first moment of two runs.
    """
    partings: list[list[Event]] = [[] for _ in members]
    peers: dict[tuple[object, ...], list[int]] = {}
    for place, member in enumerate(members):
        if member.complete and not member.shown.baseline:
            group = member.shown.group
            peers.setdefault((*group[:model], *group[model + 1 :], member.seed), []).append(place)
    for first, *others in peers.values():
        for other in others:
            moment = _first([members[first].folder, members[other].folder], members[first].seed, find)
            if moment is not None:
                partings[first].append(_event(moment, members[other].shown.group[model]))
                partings[other].append(_event(moment, members[first].shown.group[model]))
        partings[first] = sorted(partings[first], key=lambda event: event.step)[:1]
    return partings


def _first(runs: Sequence[RunFolder], seed: int, find: FindMoment) -> Moment | None:
    """Return where two runs part; of a message and an action of one step the message, which is asked for first."""
    moments = [find(runs[0], runs[1], seed, question) for question in (MESSAGE, "")]
    return min(filter(None, moments), key=lambda moment: moment.step, default=None)


def _event(moment: Moment, other: str) -> Event:
    asked = "the same prompt" if moment.asked == PROMPT else "the same prompt but for its own earlier words"
    text = f"agent {moment.agent} decides unlike {other} on {moment.question} after {asked}"
    return Event(moment.step, moment.agent, EVENT, text)
