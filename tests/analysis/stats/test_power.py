"""How many seeds a difference needs, at one look or several, and `foundry plan --pilot`."""

import math
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from analysis.stats.power import paired_power, pairs_needed, power, sd_bound
from analysis.stats.sequential import levels
from analysis.stats.sign_flip import sign_flip_p
from analysis.stats.stopping import error_of, with_looks
from commands import refusal, succeeds
from signature_tables import MEASURE, runs, table
from walkers import WORLD, make_condition, rewrite_run, write_sweep

FIRST = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4, 0.6, 0.3]
SECOND = [0.2, 0.7, 0.3, 0.6, 0.9, 0.8, 0.7, 0.1]
LOOKS = (8, 12, 18, 26, 34)
MODELS = ("first", "second")


def judged(second: list[float] = SECOND, **more) -> pd.Series:
    return power(table([*runs("a", FIRST), *runs("b", second)]), **more).iloc[0]


def test_the_seeds_that_known_effects_need():
    effects = np.array([0.5, 0.8, 1.0, 1.5, math.nan, 0.0])
    found = pairs_needed(effects, np.full(6, 0.05), 0.8)
    assert found[:4].tolist() == [34, 15, 10, 6]
    assert np.isnan(found[4:]).all()


@pytest.mark.parametrize(("effect", "n", "level"), [(0.7, 12, 0.01), (1.5, 6, 0.05), (0.2, 150, 0.001), (3.0, 3, 0.05)])
def test_the_power_is_that_of_the_noncentral_t(effect, n, level):
    critical, centre = stats.t.ppf(1 - level / 2, n - 1), effect * math.sqrt(n)
    expected = stats.nct.sf(critical, n - 1, centre) + stats.nct.cdf(-critical, n - 1, centre)
    found = paired_power(np.array([effect]), np.array([n]), np.array([level]))
    assert found[0] == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(("effect", "seeds"), [(1.5, 7), (1.0, 11)])
def test_the_promised_seeds_give_the_promised_power_by_the_test_in_use(effect: float, seeds: int):
    normal = np.random.default_rng(0).normal(size=200)
    wanted = effect * normal.std(ddof=1)
    column = power(table([*runs("a", [0] * 200), *runs("b", normal.tolist())]), difference=wanted).iloc[0]
    assert column["n_alone"] == seeds
    again = np.random.default_rng(1).normal(wanted, size=(1_000, seeds))
    assert (sign_flip_p(again) <= 0.05).mean() > 0.78


def test_a_pilot_gives_its_own_difference_and_large_ones_still_need_six_seeds():
    column = judged()
    differences = np.subtract(SECOND, FIRST)
    assert (column["observed"], column["sd"]) == pytest.approx((differences.mean(), differences.std(ddof=1)))
    assert column["difference"] == abs(column["observed"])
    assert (column["n_pairs"], column["family"], column["n_exact"]) == (8, 1, 6)
    assert column["n_alone"] == column["n_family"] < column["n_cautious"]
    column = judged(difference=5.0)
    assert (column["n_alone"], column["n_family"]) == (6, 6)


def test_the_cautious_spread_is_exceeded_in_one_of_five_pilots():
    pilots = np.random.default_rng(0).normal(size=(20_000, 8)).std(axis=1, ddof=1)
    assert (sd_bound(pilots, np.full(20_000, 8.0)) < 1).mean() == pytest.approx(0.2, abs=0.01)


def of_models(names: str) -> pd.DataFrame:
    """Return the plan of models that differ ever more from the first."""
    rows = [run for place, one in enumerate(names) for run in runs(one, np.multiply(FIRST, place + 1).tolist())]
    return power(table(rows), difference=0.3)


@pytest.mark.slow
def test_more_tests_need_more_seeds_and_looks_are_cautious_of_their_family():
    frame = of_models("abc")
    assert frame["family"].unique().tolist() == [3]
    assert frame["n_exact"].unique().tolist() == [7]
    assert (frame["n_family"] > frame["n_alone"]).all()
    of_family = with_looks(frame, LOOKS).iloc[1]
    alone = with_looks(frame.assign(pairs=1), LOOKS).iloc[1]
    assert of_family["power_cautious"] < of_family["power"] < alone["power"]
    assert of_family["seeds_cautious"] > of_family["seeds"] > alone["seeds"]
    equal = power(table([*runs("a", [0.1] * 8), *runs("b", [0.1] * 8)]))
    assert math.isnan(with_looks(equal, LOOKS).iloc[0]["power"]), "without a difference there is no power"


@pytest.mark.parametrize(
    ("second", "note"),
    [
        ([value + 0.1 for value in FIRST], "no variation in the pilot"),
        ([0.1, *[math.nan] * 7], "fewer than two pairs"),
        ([0.5, 0.1, 0.3, 0.2, 0.9, 0.4, 0.6, 0.3], "no difference to find"),
        ([0.5, 0.1, 0.3, 0.2, 0.9, 0.4, 0.6, 0.3 + 4e-16], "no difference to find"),  # from rounding
    ],
)
def test_what_a_pilot_cannot_tell_is_said(second, note):
    column = judged(second)
    assert column["note"] == note
    assert math.isnan(column["n_cautious"])


@pytest.mark.slow
@pytest.mark.parametrize("effect", [0.5, 1.5])
def test_the_promised_power_and_seeds_of_several_looks_are_those_of_the_test_in_use(effect: float):
    normal = np.random.default_rng(0).normal(size=200)
    plan = power(table([*runs("a", [0] * 200), *runs("b", normal.tolist())]), difference=effect * normal.std(ddof=1))
    promised = with_looks(plan, LOOKS).iloc[0]
    sweeps = np.random.default_rng(1).normal(effect, size=(400, LOOKS[-1]))
    by_look = levels(LOOKS, np.array([0.05]))[:, 0]
    significant = np.stack([sign_flip_p(sweeps[:, :n]) <= level for n, level in zip(LOOKS, by_look, strict=True)])
    ended = np.where(significant.any(axis=0), np.array(LOOKS)[significant.argmax(axis=0)], LOOKS[-1])
    assert promised["power"] == pytest.approx(significant.any(axis=0).mean(), abs=0.07)
    assert promised["seeds"] == pytest.approx(ended.mean(), abs=1.5)


@pytest.mark.parametrize(("count", "error"), [(1, 0.050), (2, 0.083), (5, 0.142)])
def test_many_seeds_at_equal_steps_err_as_often_as_was_published(count, error):
    """Armitage, McPherson and Rowe 1969, table 2."""
    assert error_of(tuple(range(100, 100 * count + 1, 100)), 0.05) == pytest.approx(error, abs=0.009)


def test_few_seeds_err_more_often_than_many():
    assert error_of((8, 12, 18), 0.05) > error_of((80, 120, 180), 0.05) > 0.09


@pytest.fixture(scope="module")
def pilot(tmp_path_factory) -> Path:
    world = {**WORLD, "agents": 4, "steps": 8, "fires": [], "places": []}
    conditions = [make_condition(one, range(6), sampling_seed=at, world=world) for at, one in enumerate(MODELS)]
    return write_sweep(tmp_path_factory.mktemp("pilot") / "sweep", conditions).path


@pytest.fixture(scope="module")
def plan_printed(pilot) -> Callable[..., str]:
    """A function that runs the command, the same one once, and returns what it prints."""

    @cache
    def run(*options: str) -> str:
        done = succeeds("plan", "--pilot", str(pilot), *options, cwd=pilot)
        return done.stdout

    return run


def seeds_of(text: str) -> list[str]:
    """Return the line of the measure, its last numbers being those of seeds."""
    line = next(line for line in text.splitlines() if line.startswith(MEASURE))
    return re.split(r"\s{2,}", line.strip())


@pytest.mark.slow
def test_a_pilot_ends_with_one_recommendation_a_pair_and_keeps_the_whole_table(plan_printed, pilot, monkeypatch):
    monkeypatch.setattr("analysis.stats.power.RESAMPLES", 30)  # how sure the numbers are is not looked at
    text = plan_printed()
    plan = pd.read_csv(pilot / "analysis" / "power.csv")
    declared = plan[plan["declared"]]
    assert plan["declared"].tolist() == sorted(plan["declared"], reverse=True) and 0 < len(declared) < len(plan)
    within = declared[declared["n_cautious"] <= 200]
    most = within.loc[within["n_cautious"].idxmax()]
    lines = text.splitlines()
    advice = lines[lines.index(f"second - first: play {most['n_cautious']:.0f} seeds") + 1 :]
    assert advice[0].startswith(f"  enough for: {most['measure']}") and advice[0].count(", ") == len(within) - 1
    beyond = declared.loc[declared["n_cautious"] > 200, "measure"]
    assert advice[1] == f"  more than 200 seeds: {', '.join(beyond)}" and len(advice) <= 3
    shown = [line for line in lines if "second - first" in line]
    assert len(shown) == len(declared) + 1 and f"the whole table, with {len(plan)} rows: " in text


@pytest.mark.slow
def test_smaller_differences_need_more_seeds_more_power_more_and_calls_stand_beside_them(plan_printed):
    sweep = ("-m", "model=scripted/random", "seed=0-1", "world.agents=3", "world.steps=2")
    small = plan_printed("--difference", "0.02", "--measure", MEASURE, *sweep)
    assert "at most 0 calls would be sent" in small
    large = plan_printed("--difference", "0.04", "--measure", MEASURE)
    sure = plan_printed("--difference", "0.02", "--measure", MEASURE, "--power", "0.95")
    assert int(seeds_of(sure)[5]) > int(seeds_of(small)[5]) > int(seeds_of(large)[5]) >= 6


def test_looks_say_how_often_and_how_early_a_difference_is_found(plan_printed):
    text = plan_printed("--looks", "8,12,20", "--difference", "0.05", "--measure", MEASURE)
    texts = seeds_of(text)
    assert 0.5 < float(texts[5]) <= 1
    assert 8 <= float(texts[6]) <= float(texts[8]) <= 20
    assert "at level .05, corrected for " in text


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--measure", "idle_rate.chozen"), "Did you mean 'idle_rate.chosen'"),
        (("--power", "1.5"), "between 0 and 1"),
        (("--difference", "0"), "above 0"),
        (("--looks", "12,8"), "must ascend: use 8,12"),
        (("--looks", "a"), "must have the form"),
    ],
)
def test_wrong_options_are_refused_in_one_line(pilot, options, message):
    assert message in refusal("plan", "--pilot", str(pilot), *options, cwd=pilot)


def test_a_pilot_without_a_complete_run_or_of_one_model_is_refused(tmp_path):
    sweep = write_sweep(tmp_path / "failed", [make_condition(model, [0]) for model in MODELS])
    for run in sweep.runs():
        rewrite_run(run, "failed")
    path = write_sweep(tmp_path / "lonely", [make_condition("first", range(2))]).path
    for refused, message in ((sweep.path, "no complete run"), (path, "two models")):
        assert message in refusal("plan", "--pilot", str(refused), cwd=tmp_path)
