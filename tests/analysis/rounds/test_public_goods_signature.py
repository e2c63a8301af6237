"""What the signature of public goods says of rounds worked by hand, and of policies whose results are known."""

from __future__ import annotations

import math
from itertools import chain

import numpy as np
import pytest

from analysis import analyze
from analysis.figures.pictures import means_picture
from analysis.rounds.signatures.public_goods import applies, measure
from commands import foundry
from foundry.worlds.rounds.public_goods import PublicGoods, PunishedGoods
from foundry.worlds.rounds.reading import deciding
from scripted_rounds import answered_run, scripted_run

SETTINGS = {"name": "goods", "tokens": 20, "multiplier": 2, "reset": True}


def measured(*rounds: tuple[int | str, ...], readable: bool = False) -> dict[str, float]:
    settings = SETTINGS | {"agents": len(rounds[0]), "steps": len(rounds)}
    scenario = PublicGoods(**settings)
    run = answered_run(scenario, (one if isinstance(one, str) else deciding(one) for one in chain(*rounds)), settings)
    assert applies(run)
    return measure(run.only_readable() if readable else run)


def test_rounds_worked_by_hand_and_what_could_not_be_read():
    found = measured((20, 10, 0), (10, 5, 0))
    assert found["contribution"] == 7.5 and found["score"] == pytest.approx(62.5)
    assert found["efficiency"] == pytest.approx(0.375)
    assert found["trend"] == pytest.approx(-0.25)
    assert (found["free_riders"], found["nothing"]) == (1 / 3, 1 / 3)
    assert math.isnan(found["conditional"])
    assert measured((20, "?"), (20, "?"))["score"] == 50
    alone = measured((20, "?"), (20, "?"), readable=True)
    assert (alone["score"], alone["n_agents"]) == (0, 1)
    assert math.isnan(measured(("?", "?"), readable=True)["score"])


def test_who_gives_half_of_what_others_gave_has_that_slope_and_needs_ten_rounds_for_it():
    rng, rounds = np.random.default_rng(0), [(0, 20)]
    while len(rounds) < 60:
        given = np.array(rounds[-1])[::-1] / 2 + rng.integers(0, 11, size=2)
        rounds.append(tuple(given.astype(int).tolist()))
    assert measured(*rounds)["conditional"] == pytest.approx(0.5, abs=0.12)
    rng = np.random.default_rng(0)
    rounds = [tuple(row) for row in rng.integers(0, 21, size=(10, 4)).tolist()]
    assert math.isnan(measured(*rounds[:9])["conditional"]) and not math.isnan(measured(*rounds)["conditional"])


def test_who_gives_less_every_round_by_itself_follows_nobody():
    assert measured(*((18 - 2 * step, 9 - step) for step in range(8)))["trend"] < 0
    values = [measured(*zip(*((np.random.default_rng(9 * seed + one).integers(0, 20 - 2 * np.arange(10))).tolist()
              for one in range(4)), strict=True))["conditional"] for seed in range(30)]  # fmt: skip
    assert abs(np.mean(values)) < 3 * np.std(values) / math.sqrt(30)


def test_punishment_is_counted_with_what_it_costs_and_whom_it_hits():
    settings = SETTINGS | {"agents": 3, "steps": 1, "cost": 2, "loss": 3}
    said = [*map(deciding, (20, 10, 10)), *map(deciding, ("agent 2", "agent 2", "nobody"))]
    found = measure(answered_run(PunishedGoods(**settings), said, settings))
    assert (found["punishing"], found["spent"], found["antisocial"]) == pytest.approx((2 / 3, 4 / 3, 1 / 2))
    assert found["efficiency"] == pytest.approx((40 - (2 * 2 + 2 * 3)) / 3 / 20)


@pytest.mark.parametrize(
    ("policy", "column", "value"),
    [
        ("free_rider", "score", 100),
        ("random", "score", 50),
        ("conditional", "score", 100 - 100 * (1 - 0.8**20) / (2 * 20 * 0.2)),
        ("conditional", "conditional", 0.8),
    ],
)
def test_policies_come_to_what_is_known_of_them(policy: str, column: str, value: float):
    values = [measure(scripted_run("public_goods", policy, seed))[column] for seed in range(6)]
    assert abs(np.mean(values) - value) <= 4 * np.std(values) / math.sqrt(len(values)) + 1e-9


@pytest.mark.slow
def test_games_with_different_questions_are_compared_by_their_own_measures_in_their_own_words(tmp_path):
    asked = ("-m", "world=public_goods,public_goods_punishment", "model=scripted/first,scripted/random", "seed=0-6")
    rest = ("prompt=public_goods", "world.steps=2", "world.agents=3", "analyze=false", "output.dir=games")
    assert foundry(*asked, *rest, cwd=tmp_path).returncode == 0
    found = analyze(tmp_path / "games", plots=False, family=["idle_rate.chosen"])
    measures = found.contrasts.groupby("factor")["signature"].unique()
    assert {"public_goods", "idle_rate"} <= set(measures["model"])
    assert "public_goods" in measures["world"] and "idle_rate" not in measures["world"]
    assert any("ask different questions: public_goods and public_goods_punishment" in note for note in found.notes)
    for others in (found.variance["measure"], found.fingerprint.measures):
        assert "public_goods.score" in set(others) and "idle_rate.chosen" not in set(others)
    titles = means_picture(found.compared, found.shown, "idle_rate").says
    assert "Chose to do nothing" in titles and "stay" not in titles
    differing = [line for line in found.summary if "idle_rate.chosen" in line]
    assert differing and all("does nothing" in line and "stays" not in line for line in differing)
