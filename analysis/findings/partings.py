"""Finds, for each run, the first decision that differs from another model's decision after the same prompt."""

from collections.abc import Sequence

from analysis.figures.members import Member
from analysis.findings.moments import Parting, partings
from analysis.measuring.events import Event

EVENT = "first_parting"


def first_partings(members: Sequence[Member], model: int) -> list[list[Event]]:
    """Return for each run a list with one event, the run's first difference from another model's run, or no event.

    A run is compared with the first model's run of the same seed and settings. The first model's run has its event at
    the earliest difference from any of these runs. Baselines and unfinished runs have no event.
    """
    events: list[list[Event]] = [[] for _ in members]
    peers: dict[tuple[object, ...], list[int]] = {}
    for place, member in enumerate(members):
        if member.complete and not member.shown.baseline:
            group = member.shown.group
            peers.setdefault((*group[:model], *group[model + 1 :], member.seed), []).append(place)
    for first, *others in peers.values():
        for other in others:
            parting = next(partings(members[first].folder, members[other].folder), None)
            if parting is not None:
                events[first].append(_event(parting, members[other].shown.group[model]))
                events[other].append(_event(parting, members[first].shown.group[model]))
        events[first] = sorted(events[first], key=lambda event: event.step)[:1]
    return events


def _event(parting: Parting, other: str) -> Event:
    text = f"agent {parting.agent} decides differently from {other} on {parting.question} after {parting.asked}"
    return Event(parting.step, parting.agent, EVENT, text)
