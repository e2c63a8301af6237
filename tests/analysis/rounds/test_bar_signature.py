"""What the signature of the bar says of evenings worked by hand, and of policies whose results are known."""

from __future__ import annotations

import math
from itertools import chain

import numpy as np
import pytest

from analysis.rounds.signatures.bar import applies, coins_off, measure
from foundry.worlds.rounds.bar import Bar
from foundry.worlds.rounds.reading import deciding
from scripted_rounds import answered_run, scripted_run

REPLIES = {"g": deciding("go"), "s": deciding("stay"), "?": "perhaps"}


def measured(*evenings: str, readable: bool = False, capacity: float = 0.5) -> dict[str, float]:
    """Return the measures of evenings such as "ggss", a letter an agent."""
    settings = {"name": "bar", "agents": len(evenings[0]), "steps": len(evenings), "capacity": capacity}
    scenario = Bar(**settings, fun=10, crowded=0, home=5, reports="explicit")
    run = answered_run(scenario, (REPLIES[one] for one in chain(*evenings)), settings)
    assert applies(run)
    return measure(run.only_readable() if readable else run)


def test_evenings_worked_by_hand():
    found = measured("ggss", "gggs", "gsss", "gsss")
    assert found["score"] == pytest.approx(100 * (1 - (0 + 0.25 + 0.25 + 0.25) / 4 / 0.5))
    assert found["score_of_coins"] == pytest.approx(100 * (1 - (2 * 0.5 + 8 * 0.25) / 16 / 0.5))
    assert (found["share"], found["crowded"], found["constant"]) == (7 / 16, 1 / 4, 1 / 2)
    assert found["volatility"] == pytest.approx(np.var([2, 3, 1, 1]) / 4)
    assert found["volatility_ratio"] == pytest.approx(np.var([2, 3, 1, 1]) / (1 / 4 + 3 / 16))
    assert found["alternation"] == pytest.approx(2 / 3 - 2 * 1 * 3 / (4 * 3))


def test_what_could_not_be_read_is_staying_or_left_out():
    assert measured("gg??", "gg??")["share"] == 0.5
    alone = measured("gg??", "gs??", readable=True)
    assert (alone["share"], alone["n_agents"]) == (0.75, 2)
    assert math.isnan(measured("????", readable=True)["score"])
    apart = measured("gg", "s?", "gs", readable=True)
    assert apart["volatility"] == pytest.approx(((5 / 6) ** 2 + (2 / 3) ** 2 + (1 / 6) ** 2) / 3 / 2)


def test_agents_that_take_turns_herd_or_toss_coins_have_known_figures():
    assert measured("gs", "sg", "gs", "sg")["volatility_ratio"] == 0
    assert measured("gggg", "ssss", "gggg", "ssss")["volatility_ratio"] == 4
    assert measured("gggg", "ssss", "gggg", "ssss")["alternation"] == pytest.approx(1 / 3)
    assert coins_off(10, 0.6) == pytest.approx(0.14766, abs=5e-6)
    assert coins_off(1, 0.25) == 0.5


@pytest.mark.parametrize(("policy", "score"), [("coin", 75.39), ("mixing", 80.0), ("always_go", 100 / 3)])
def test_policies_score_what_is_known_of_them(policy: str, score: float):
    values = [measure(scripted_run("bar", policy, seed))["score"] for seed in range(6)]
    assert abs(np.mean(values) - score) <= 4 * np.std(values) / math.sqrt(len(values)) + 1e-9
