"""Whole runs of scripted models, whose behaviour is known, through the worlds, the records and the analysis."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from analysis import signatures
from analysis.any.signatures.cost import cost_measures
from analysis.grid.grid_run import GridRun
from analysis.grid.walker import expected_cells
from analysis.load import read_records, read_run
from commands import foundry
from foundry import seeding
from foundry.storing.store import SweepFolder

pytestmark = pytest.mark.slow
Cell = tuple[int, int]
AGENTS, STEPS, HALF = 20, 50, 4
MODELS = ("stay", "random", "herd", "avoid", "seek", "flaky")
WORLD = (
    f"world.agents={AGENTS}", f"world.steps={STEPS}", f"world.half_size={HALF}",
    "world.places=[{name: cafe, type: cafe, center: [-3, 0], extent: [1, 1], capacity: 3},"
    "{name: library, type: library, center: [3, 0], extent: [1, 1], capacity: 2}]",
    "world.fires=[{name: fire1, start: 5, position: [0, 3], intensity: 0.8, radius: 3}]",
    "world.communication_distance=2",
)  # fmt: skip


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, GridRun]:
    """One run of each scripted model, and one of a walker that never stays, all from the same start."""
    folder = tmp_path_factory.mktemp("known")
    models = ",".join(f"scripted/{name}" for name in MODELS)
    common = (*WORLD, "seed=1", "analyze=false", "runner.workers=1")
    for arguments in (("-m", f"model={models}", "output.dir=all"),
                      ("model=scripted/random", "model.stay_probability=0", "output.dir=walker")):  # fmt: skip
        ended = foundry(*arguments, *common, cwd=folder)
        assert ended.returncode == 0, ended.stderr
    found = dict(zip(MODELS, sorted_runs(folder / "all"), strict=True))
    return found | {"walker": next(sorted_runs(folder / "walker"))}


def sorted_runs(path: Path) -> Iterator[GridRun]:
    """Yield the runs in the order in which their models were asked for."""
    for folder in SweepFolder.open(path).runs():
        run = read_run(folder, read_records(folder, folder.summary()))
        assert isinstance(run, GridRun)
        yield run


@pytest.fixture(scope="session")
def measured(runs: dict[str, GridRun]) -> dict[str, dict[str, float]]:
    return {name: signatures.measure(run) for name, run in runs.items()}


def legal(cell: Cell) -> list[Cell]:
    moves = [(cell[0] + dx, cell[1] + dy) for dx, dy in ((0, 1), (0, -1), (-1, 0), (1, 0))]
    return [to for to in moves if max(map(abs, to)) <= HALF]


def visited(run: GridRun) -> list[list[Cell]]:
    return [list(zip(x, y, strict=True)) for x, y in zip(run.x.T.tolist(), run.y.T.tolist(), strict=True)]


def test_a_model_that_stays_is_idle_and_nothing_else(measured: dict[str, dict[str, float]]):
    found = measured["stay"]
    assert found["idle_rate.chosen"] == found["idle_rate.immobile"] == found["stability.persistence"] == 1
    assert found["idle_rate.longest_run"] == STEPS
    assert found["exploration.coverage"] == pytest.approx(1 / 81)
    assert found["hazard.away"] == found["hazard.distance_change"] == found["movement.drift_place"] == 0
    assert found["hazard.latency"] == STEPS, "never away: the curve stays at 1"
    assert math.isnan(found["movement.direction_entropy"])


def test_a_random_walk_stays_and_covers_as_often_as_simulated_ones(
    runs: dict[str, GridRun], measured: dict[str, dict[str, float]]
):
    # An independent draw in each of 1,000 states: mean and deviation in closed form.
    chances = [1 / (1 + len(legal(cell))) for path in visited(runs["random"]) for cell in path[:-1]]
    deviation = math.sqrt(sum(p * (1 - p) for p in chances)) / len(chances)
    assert abs(measured["random"]["idle_rate.chosen"] - sum(chances) / len(chances)) < 3 * deviation
    assert measured["random"]["idle_rate.blocked"] == measured["random"]["idle_rate.invalid"] == 0
    draw = seeding.stream(5, "walks")
    means = []
    for _ in range(60):
        counts = []
        for path in visited(runs["random"]):
            cell, seen = path[0], {path[0]}
            for _ in range(STEPS):
                ways = [cell, *legal(cell)]
                cell = ways[int(draw.integers(len(ways)))]
                seen.add(cell)
            counts.append(len(seen) / 81)
        means.append(sum(counts) / len(counts))
    assert abs(measured["random"]["exploration.coverage"] - np.mean(means)) < 3.5 * np.std(means)


def test_a_walker_that_never_stays_goes_and_covers_as_is_expected_of_it(measured: dict[str, dict[str, float]]):
    found = measured["walker"]
    moves = found["movement.n_moves"]
    assert moves == AGENTS * STEPS
    for way in ("up", "down", "left", "right"):
        null = found[f"movement.walker_share_{way}"]
        assert abs(found[f"movement.share_{way}"] - null) < 3 * math.sqrt(null * (1 - null) / moves)
    # 2 n ln 2 KL is near chi-squared with 3 degrees of freedom: 16.3 is its 99.9 % quantile.
    assert 2 * moves * math.log(2) * found["movement.walker_kl"] < 16.3
    assert found["movement.direction_entropy"] > 1 - 16.3 / (4 * moves * math.log(2))
    assert measured["walker"]["exploration.walker_ratio"] == pytest.approx(1, abs=0.1)
    assert measured["stay"]["exploration.walker_ratio"] < 0.1
    assert measured["walker"]["hazard.away_beyond_blind"] == pytest.approx(0, abs=0.1)
    assert measured["stay"]["hazard.away_beyond_blind"] == measured["stay"]["hazard.distance_beyond_blind"] == 0


@pytest.mark.parametrize("start", [(0, 0), (1, 1), (-1, 0), (0, 1)])
def test_expected_cells_are_those_of_all_walks(start: Cell):
    total = 0.0
    for turns in product(range(12), repeat=3):  # 12 is a multiple of all numbers of legal moves, so each counts alike
        cell, seen = start, {start}
        for turn in turns:
            ways = [
                (cell[0] + dx, cell[1] + dy)
                for dx, dy in ((0, 1), (0, -1), (-1, 0), (1, 0))
                if max(abs(cell[0] + dx), abs(cell[1] + dy)) <= 1
            ]
            cell = ways[turn % len(ways)]
            seen.add(cell)
        total += len(seen)
    found = expected_cells(np.array([start[0]]), np.array([start[1]]), np.array([3]), half_size=1)
    assert found == pytest.approx(total / 12**3, abs=1e-12)


@pytest.mark.parametrize("start", [(0, 0), (-20, 7), (19, -20), (20, 20), (14, -16)])
def test_a_far_edge_makes_no_difference_to_a_walker(start: Cell):
    """The small grid that stands for a large one gives what the large one would."""
    moves = np.array([6])
    near = expected_cells(np.array([start[0]]), np.array([start[1]]), moves, half_size=20)
    shift = [math.copysign(30 - 20, at) if abs(at) > 10 else 0 for at in start]
    x, y = (np.array([int(at + by)]) for at, by in zip(start, shift, strict=True))
    assert near == pytest.approx(expected_cells(x, y, moves, half_size=30), abs=1e-12)


@pytest.mark.parametrize(
    ("column", "model", "low", "high"),
    [
        ("clustering.nni", "herd", 0, 0.8),
        ("movement.drift_agent_beyond_blind", "herd", -1, -0.02),
        ("movement.drift_place", "seek", -1, -0.01),
        ("hazard.away_beyond_blind", "avoid", 0.2, 1),
        ("hazard.distance_beyond_blind", "avoid", 0.3, 1),
        ("hazard.difference_walker_moving", "avoid", 0.2, 1),
        ("hazard.latency", "avoid", 1, 1.2),
        ("outcome.failure_rate", "flaky", 0.05, 0.5),
    ],
)
def test_what_a_model_is_made_for_shows_in_its_signature(
    measured: dict[str, dict[str, float]], column: str, model: str, low: float, high: float
):
    assert low <= measured[model][column] <= high
    assert not low <= measured["random"][column] <= high, "a random walk shows nothing of it"


def test_variants_are_computed_from_the_readable_decisions_and_are_the_same_where_all_are(
    measured: dict[str, dict[str, float]], runs: dict[str, GridRun]
):
    for column, value in measured["random"].items():
        if signatures.is_readable_only(column):
            assert value == pytest.approx(measured["random"][column.removesuffix("_readable")], nan_ok=True)
    assert measured["flaky"]["idle_rate.invalid"] == measured["flaky"]["outcome.failure_rate"] > 0
    assert measured["flaky"]["idle_rate.invalid_readable"] == 0
    assert measured["flaky"]["idle_rate.immobile_readable"] < measured["flaky"]["idle_rate.immobile"]
    run = runs["random"]
    for signature in signatures.discover():
        assert signature.measure(run.only_readable()) == pytest.approx(signature.measure(run), nan_ok=True)


def test_cost_is_what_the_run_says(runs: dict[str, GridRun]):
    found = cost_measures(runs["random"].cost, runs["random"].decisions)
    assert found["calls"] == 2 * AGENTS * STEPS
    assert found["calls_per_decision"] == 2
    assert (found["cached_share"], found["retries"], found["model_s"]) == (0, 0, 0)
    assert 0 < found["wall_s"] < 60
