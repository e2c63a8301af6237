"""Evacuations on arrays worked out by hand, the bound against exact assignments, and whole runs."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from analysis import signatures
from analysis.grid.grid_run import NO_EXIT, Exit, Fire, GridRun, Leaders
from analysis.grid.signatures import clustering, evacuation, exploration, hazard
from analysis.grid.signatures.evacuation import NO_WAY, exit_steps
from foundry.leaving import FAR, soonest_departures
from grid_runs import grid_run, whole_run

LEFT, RIGHT = Exit("left", ((-2, 0),), 1), Exit("right", ((2, 0),), 1)


def leaving(paths: list[list[tuple[int, int]]], steps: int, **world: Any) -> GridRun:
    """Return the run in which agents go along their paths and leave where these end on an exit, else stay there."""
    exits = world.pop("exits", (LEFT, RIGHT))
    padded = [path + [path[-1]] * (steps + 1 - len(path)) for path in paths]
    left = np.full((steps, len(paths)), NO_EXIT)
    present = np.ones((steps, len(paths)), dtype=np.bool_)
    for agent, path in enumerate(paths):
        for index, one in enumerate(exits):
            if path[-1] in one.cells:
                left[len(path) - 2, agent] = index
                present[len(path) - 1 :, agent] = False
    run = grid_run(padded, half_size=2, left=left, present=present, lost=np.zeros_like(present), **world.pop("run", {}))
    return replace(run, world=world_of(run, exits=exits, **world))


def world_of(run: GridRun, **changes: Any) -> Any:
    return msgspec.structs.replace(run.world, **changes)


def test_times_choices_and_ways_of_three_agents():
    run = leaving(
        [
            [(-1, 0), (-2, 0)],  # the nearest exit, at once
            [(-1, 1), (-1, 0), (0, 0), (1, 0), (2, 0)],  # turns away from the nearest: 4 moves where 4 are the way
            [(0, 0), (0, 1)],  # stays in
        ],
        steps=5,
        leaders=Leaders(1),
    )
    measures = evacuation.measure(run)
    assert measures["out"] == pytest.approx(2 / 3) and measures["lost"] == 0
    assert measures["time_50"] == 4 and math.isnan(measures["time_90"])
    assert (measures["lower_bound_50"], measures["lower_bound"]) == (2, 2), (
        "1, 2 and 2 moves to two exits of one a step"
    )
    assert measures["over_bound_50"] == 2
    assert (measures["share_left"], measures["share_right"]) == (0.5, 0.5)
    assert measures["nearest"] == 0.5 and measures["with_leaders"] == 0
    assert measures["herding"] == -1, "both had the left one nearest, and left by two"
    assert measures["path_efficiency"] == 1
    assert (measures["n_out"], measures["n_leaders_out"]) == (2, 1)


def test_waiting_ways_and_warnings_count_as_worked_by_hand():
    run = leaving([[(0, 0), (0, 0), (1, 0), (1, 0), (2, 0)]], steps=4)
    measures = evacuation.measure(run)
    assert (measures["path_efficiency"], measures["path_efficiency_moving"]) == (0.5, 1)
    run = leaving([[(0, 0)]], steps=1, walls=(((-1, -1), (-1, 2)),))
    steps = exit_steps(run.world)
    assert steps[0, 2, 2] == 6, "down, round the wall, and up again"
    assert steps[1, 2, 2] == 2 and steps[0, 1, 2] == NO_WAY
    said = np.full((2, 2), None, dtype=np.object_)
    said[:, 0] = "Fire! There is a fire, get out!"
    deliveries = np.array([(1, 0, 1), (2, 0, 1)])
    run = leaving([[(0, 0)], [(0, 0), (1, 0), (2, 0)]], steps=2, run={"said": said, "deliveries": deliveries})
    measures = evacuation.measure(run)
    assert (measures["warned"], measures["warnings_heard"]) == (1, 1)
    measures = evacuation.measure(leaving([[(0, 0)], [(0, 1)]], steps=2))
    missing = {name for name, value in measures.items() if math.isnan(value)}
    assert measures["out"] == 0 and {"time_50", "time_90", "nearest", "path_efficiency", "share_left"} <= missing


def exact_steps(distances: list[list[int]], capacities: list[int | None]) -> list[int]:
    """Return the steps in which agents leave, ascending, where their sum is the smallest of all assignments."""
    able = [own for own in distances if min(own) < FAR]
    horizon = len(able) + max((far for own in able for far in own if far < FAR), default=0)
    places = [
        (index, step)
        for index, capacity in enumerate(capacities)
        for step in range(1, horizon + 1)
        for _ in range(capacity or len(able))
    ]
    costs = [[step if own[index] <= step else FAR for index, step in places] for own in able]
    rows, columns = linear_sum_assignment(np.array(costs).reshape(len(able), len(places)))
    return sorted(costs[row][column] for row, column in zip(rows, columns, strict=True))


def test_the_plan_is_an_exact_assignment_from_many_random_starts():
    rng = np.random.default_rng(0)
    for _ in range(100):
        agents, exits = rng.integers(1, 10), rng.integers(1, 4)
        distances = rng.choice([*range(1, 9), FAR], size=(agents, exits)).tolist()
        capacities = [(1, 2, None)[index] for index in rng.integers(0, 3, size=exits)]
        steps = sorted(
            departure.step for departure in soonest_departures(distances, capacities) if departure is not None
        )
        assert steps == exact_steps(distances, capacities), (distances, capacities)


def test_the_oracle_meets_the_bound_where_nobody_is_in_its_way(tmp_path: Path):
    alone = ("world.cell_capacity=null", "world.agents=6")
    run = whole_run(tmp_path / "sweep", "evacuation_corridor", "shortest_path", *alone, seed=0)
    measures = evacuation.measure(run)
    assert measures["over_bound"] == measures["over_bound_50"] == 1 and measures["path_efficiency_moving"] == 1


def test_signatures_count_no_agent_that_is_not_there(tmp_path: Path):
    run = whole_run(tmp_path / "sweep", "evacuation", "shortest_path", "world.steps=12", "world.agents=10", seed=0)
    assert not run.there.all()
    measures = signatures.measure(run)
    asked = int(run.there.sum())
    assert (
        measures["idle_rate.n_decisions"]
        == measures["outcome.n_decisions"]
        == measures["movement.n_decisions"]
        == asked
    )
    assert math.isnan(measures["clustering.nni"]) and 0 < measures["clustering.largest_group"] <= 1
    assert (
        math.isnan(measures["exploration.walker_ratio"])
        and measures["exploration.n_cells"] == run.world.cells < 17 * 17
    )
    assert not any(name.startswith("hazard.") for name in measures), "its fire spreads"
    assert run.choice[~run.there].max() == 0 and not run.moved[~run.there].any()
    doors = {cell for exit_zone in run.world.exits for cell in exit_zone.cells}
    gone = np.flatnonzero((run.left != NO_EXIT).any(axis=0))
    assert len(gone) and all((run.x[-1, agent], run.y[-1, agent]) in doors for agent in gone), (
        "where it left, it is kept"
    )


def test_signatures_of_an_open_grid_are_what_they_were():
    run = grid_run([[(0, 0), (1, 0), (2, 0)], [(5, 5), (5, 6), (5, 7)]])
    full = replace(run, present=np.ones((2, 2), dtype=np.bool_))
    for module in (clustering, exploration):
        assert module.measure(full) == pytest.approx(module.measure(run), nan_ok=True)
    assert hazard.applies(run) and not evacuation.applies(run)
    assert not hazard.applies(replace(run, world=world_of(run, fires=(Fire("f", 1, (0, 0), 2.0, 0.1),))))
