"""Events of runs of 2D worlds: first warnings, flights from fires, arrivals at places, crowds, exits, deaths."""

from collections.abc import Iterator

import numpy as np

from analysis.arrays import OUTCOMES
from analysis.grid.grid_run import NO_EXIT, OUTSIDE, GridRun
from analysis.labelling.warning_rule import is_warning
from analysis.measuring.events import LONGEST_TEXT, Event, beginnings
from foundry.texts import one_line


def events(run: GridRun) -> Iterator[Event]:
    """Yield all events of a run, kind by kind."""
    yield from _first_warning(run)
    yield from _flights(run)
    yield from _arrivals(run)
    yield from _crowds(run)
    yield from _leaving(run)
    for step, agent in np.argwhere(run.there & ~run.message_readable).tolist():
        outcome = OUTCOMES[int(run.message_outcome[step, agent])]
        yield Event(step + 1, agent, "unreadable", f"agent {agent}: no readable message ({outcome})")


def _first_warning(run: GridRun) -> Iterator[Event]:
    fires = tuple(fire.name for fire in run.world.fires)
    labels = dict(run.labels or {})
    for step, agent in np.argwhere(run.spoke).tolist():
        text = run.said[step, agent]
        if text not in labels:
            labels[text] = run.labels is None and bool(is_warning(text, fires))
        if labels[text]:
            warning = one_line(text, LONGEST_TEXT)
            yield Event(step + 1, agent, "first_warning", f'agent {agent} is the first to warn: "{warning}"')
            return


def _flights(run: GridRun) -> Iterator[Event]:
    """Yield each agent's first step away from the nearest perceived fire; nothing if fires spread."""
    if run.world.spreads or not run.perceived.any():
        return
    fires = np.array([fire.position for fire in run.world.fires])
    away = np.hypot(run.x[..., None] - fires[:, 0], run.y[..., None] - fires[:, 1])
    nearest = np.where(run.fires, away[:-1], np.inf).argmin(axis=2)[..., None]
    before, after = (np.take_along_axis(distances, nearest, axis=2)[..., 0] for distances in (away[:-1], away[1:]))
    fled = run.perceived & run.moved & (after > before)
    for agent in np.flatnonzero(fled.any(axis=0)).tolist():
        step = int(fled[:, agent].argmax())
        fire = run.world.fires[int(nearest[step, agent, 0])].name
        yield Event(step + 1, agent, "fled", f"agent {agent} steps away from {fire}")


def _arrivals(run: GridRun) -> Iterator[Event]:
    entered = (run.place[1:] != run.place[:-1]) & run.there & run.moved
    for index, place in enumerate(run.world.places):
        arrived = entered & (run.place[1:] == index)
        for agent in np.flatnonzero(arrived.any(axis=0)).tolist():
            step = int(arrived[:, agent].argmax())
            yield Event(step + 1, agent, "arrived", f"agent {agent} arrives at {place.name}")


def _crowds(run: GridRun) -> Iterator[Event]:
    """Yield, for each place, the first step after which it holds more agents than its capacity."""
    for index, place in enumerate(run.world.places):
        count = ((run.place[1:] == index) & (run.place[1:] != OUTSIDE)).sum(axis=1)
        for step in beginnings(count > place.capacity):
            text = f"{place.name} is crowded: {count[step]} agents, capacity {place.capacity}"
            yield Event(step + 1, None, "crowded", text)


def _leaving(run: GridRun) -> Iterator[Event]:
    if run.left is not None:
        for step, agent in np.argwhere(run.left != NO_EXIT).tolist():
            exit_name = run.world.exits[int(run.left[step, agent])].name
            yield Event(step + 1, agent, "left", f"agent {agent} leaves by {exit_name}")
    if run.lost is not None:
        for step, agent in np.argwhere(run.lost).tolist():
            yield Event(step + 1, agent, "died", f"agent {agent} dies")
