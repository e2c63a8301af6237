"""Formulas of 2D worlds against what independent libraries and all possible walks come to."""

import math
from itertools import product

import numpy as np
import pytest
from scipy import stats

from analysis.agreement import fleiss_kappa, pairwise_agreement
from analysis.formulas import restricted_mean, survival
from analysis.grid.distances import steps_to
from analysis.grid.walker import expected_cells


def test_the_kaplan_meier_curve_and_its_area():
    rng = np.random.default_rng(0)
    times, observed = rng.integers(1, 9, 40), rng.random(40) < 0.6
    events, remaining = survival(times, observed)
    found = stats.ecdf(stats.CensoredData(uncensored=times[observed], right=times[~observed])).sf
    assert remaining.tolist() == pytest.approx(found.evaluate(events).tolist(), abs=1e-9)
    times, observed = np.array([1, 3, 6]), np.array([True, True, True])
    assert restricted_mean(times, observed, 2) == pytest.approx(1 + 2 / 3)
    assert math.isnan(restricted_mean(times[:0], observed[:0], 5))


def test_steps_on_a_grid_go_around_walls():
    free, goal = np.ones((5, 5), dtype=bool), np.zeros((5, 5), dtype=bool)
    free[2, :4], goal[4, 0] = False, True
    found = steps_to(goal, free)
    assert (found[0, 0], found[2, 0], found[4, 0]) == (12, -1, 0)
    free[2, 4] = False
    assert steps_to(goal, free)[0, 0] == -1


def test_consistency_of_repeated_choices():
    counts = np.array([[4, 0], [3, 1], [2, 2]])
    assert (pairwise_agreement(counts), fleiss_kappa(counts)) == pytest.approx((11 / 18, -1 / 27))
    assert math.isnan(fleiss_kappa(np.array([[3, 0], [4, 0]])))
    assert pairwise_agreement(np.array([[3, 0], [4, 0]])) == 1


@pytest.mark.parametrize("start", [(0, 0), (1, 1), (-1, 0)])
def test_expected_cells_are_those_of_all_walks(start: tuple[int, int]):
    total = 0.0
    for turns in product(range(12), repeat=3):  # 12 is a multiple of all numbers of legal moves, so each counts alike
        cell, seen = start, {start}
        for turn in turns:
            ways = [(cell[0] + dx, cell[1] + dy) for dx, dy in ((0, 1), (0, -1), (-1, 0), (1, 0))]
            legal = [to for to in ways if max(map(abs, to)) <= 1]
            cell = legal[turn % len(legal)]
            seen.add(cell)
        total += len(seen)
    found = expected_cells(np.array([start[0]]), np.array([start[1]]), np.array([3]), half_size=1)
    assert found == pytest.approx(total / 12**3, abs=1e-12)


@pytest.mark.parametrize("start", [(0, 0), (-20, 7), (19, -20), (20, 20), (14, -16)])
def test_a_far_edge_makes_no_difference_to_a_walker(start: tuple[int, int]):
    """The small grid that stands for a large one gives what the large one would."""
    moves = np.array([6])
    near = expected_cells(np.array([start[0]]), np.array([start[1]]), moves, half_size=20)
    shift = [math.copysign(30 - 20, at) if abs(at) > 10 else 0 for at in start]
    x, y = (np.array([int(at + by)]) for at, by in zip(start, shift, strict=True))
    assert near == pytest.approx(expected_cells(x, y, moves, half_size=30), abs=1e-12)
