"""`foundry plan --pilot`."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pandas as pd
import pytest

from commands import foundry

MEASURE = "idle_rate.chosen"
MODELS = ("first", "second")


@pytest.fixture(scope="module")
def pilot(tmp_path_factory, write_sweep, make_condition, small_world) -> Path:
    """Return a sweep of two models that walk at random."""
    world = {**small_world, "agents": 4, "steps": 8, "fires": [], "places": []}
    conditions = [make_condition(one, range(6), sampling_seed=at, world=world) for at, one in enumerate(MODELS)]
    return write_sweep(tmp_path_factory.mktemp("pilot") / "sweep", conditions).path


@pytest.fixture(scope="module")
def power(pilot) -> Callable[..., str]:
    """Return a function that runs the command, the same one once, and returns what it prints."""

    @cache
    def run(*options: str) -> str:
        done = foundry("plan", "--pilot", str(pilot), *options, cwd=pilot)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def seeds_of(text: str) -> list[str]:
    """Return the line of the measure, its last numbers being those of seeds."""
    line = next(line for line in text.splitlines() if line.startswith(MEASURE))
    return re.split(r"\s{2,}", line.strip())


@pytest.mark.slow
def test_a_pilot_ends_with_one_recommendation_a_pair_and_keeps_the_whole_table(power, pilot):
    text = power()
    plan = pd.read_csv(pilot / "analysis" / "power.csv")
    declared = plan[plan["declared"]]
    assert plan["declared"].tolist() == sorted(plan["declared"], reverse=True) and 0 < len(declared) < len(plan)
    within = declared[declared["n_cautious"] <= 200]
    most = within.loc[within["n_cautious"].idxmax()]
    lines = text.splitlines()
    assert lines[-1].startswith(f"second - first: run {most['n_cautious']:.0f} seeds ({most['measure']} needs the most")
    assert f"{(declared['n_cautious'] > 200).sum()} measures beyond 200 seeds" in lines[-1]
    shown = [line for line in lines if "second - first" in line]
    assert len(shown) == len(declared) + 1 and f"all {len(plan)} rows in" in text


@pytest.mark.slow
def test_a_larger_difference_needs_fewer_seeds_and_more_power_more(power):
    small, large = (seeds_of(power("--difference", size, "--measure", MEASURE)) for size in ("0.02", "0.04"))
    assert int(small[5]) > int(large[5]) >= 6
    usual, more = (seeds_of(power("--difference", "0.02", "--measure", MEASURE, *o)) for o in ((), ("--power", "0.95")))
    assert int(more[5]) > int(usual[5])


def test_calls_of_the_sweep_that_is_planned_stand_beside_the_seeds(power):
    asked = ("-m", "model=scripted/random", "seed=0-1", "world.agents=3", "world.steps=2")
    assert "at most 0 calls would be sent" in power("--difference", "0.02", "--measure", MEASURE, *asked)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--measure", "idle_rate.chozen"), "Did you mean 'idle_rate.chosen'"),
        (("--power", "1.5"), "between 0 and 1"),
        (("--difference", "0"), "above 0"),
    ],
)
def test_wrong_options_are_refused_in_one_line(pilot, options, message):
    done = foundry("plan", "--pilot", str(pilot), *options, cwd=pilot)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_pilot_without_a_complete_run_or_of_one_model_is_refused(tmp_path, write_sweep, make_condition, rewrite_run):
    sweep = write_sweep(tmp_path / "failed", [make_condition(model, [0]) for model in MODELS])
    for run in sweep.runs():
        rewrite_run(run, "failed")
    done = foundry("plan", "--pilot", str(sweep.path), cwd=tmp_path)
    assert done.returncode == 2
    assert "no complete run" in done.stderr
    path = write_sweep(tmp_path / "lonely", [make_condition("first", range(2))]).path
    done = foundry("plan", "--pilot", str(path), cwd=tmp_path)
    assert done.returncode == 2
    assert "two models" in done.stderr


def test_looks_say_how_often_and_how_early_a_difference_is_found(power):
    text = power("--looks", "8,12,20", "--difference", "0.05", "--measure", MEASURE)
    found = seeds_of(text)
    assert 0.5 < float(found[5]) <= 1
    assert 8 <= float(found[6]) <= float(found[8]) <= 20
    assert "as one of" in text


@pytest.mark.parametrize(("looks", "message"), [("12,8", "do not ascend: write 8,12"), ("a", "has not the form")])
def test_looks_that_cannot_be_are_refused_in_one_line(pilot, looks, message):
    done = foundry("plan", "--pilot", str(pilot), "--looks", looks, cwd=pilot)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert message in done.stderr
