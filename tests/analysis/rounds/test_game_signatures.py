"""What the signatures of games say of rounds worked by hand, and of policies whose results are known."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import pytest

import small_worlds as games
from analysis import analyze
from analysis.figures.pictures import means_picture
from analysis.rounds.rounds_run import RoundsRun
from analysis.rounds.signatures import bar, fishery, naming, public_goods
from commands import succeeds
from foundry.worlds.rounds.reading import deciding
from scripted_rounds import answered_run, scripted_run

REPLIES = {"g": deciding("go"), "s": deciding("stay"), "?": "perhaps"}


def evenings_of(*evenings: str, readable: bool = False, capacity: float = 0.5) -> dict[str, float]:
    """Return the measures of evenings such as "ggss", a letter an agent."""
    settings = {"name": "bar", "agents": len(evenings[0]), "steps": len(evenings), "capacity": capacity}
    run = answered_run(games.bar(**settings), (REPLIES[one] for one in chain(*evenings)), settings)
    assert bar.applies(run)
    return bar.measure(run.only_readable() if readable else run)


def test_evenings_worked_by_hand():
    found = evenings_of("ggss", "gggs", "gsss", "gsss")
    assert found["score"] == pytest.approx(100 * (1 - (0 + 0.25 + 0.25 + 0.25) / 4 / 0.5))
    assert found["score_of_coins"] == pytest.approx(100 * (1 - (2 * 0.5 + 8 * 0.25) / 16 / 0.5))
    assert (found["share"], found["crowded"], found["constant"]) == (7 / 16, 1 / 4, 1 / 2)
    assert found["volatility"] == pytest.approx(np.var([2, 3, 1, 1]) / 4)
    assert found["volatility_ratio"] == pytest.approx(np.var([2, 3, 1, 1]) / (1 / 4 + 3 / 16))
    assert found["alternation"] == pytest.approx(2 / 3 - 2 * 1 * 3 / (4 * 3))


def test_evenings_that_could_not_be_read_are_staying_or_left_out():
    assert evenings_of("gg??", "gg??")["share"] == 0.5
    alone = evenings_of("gg??", "gs??", readable=True)
    assert (alone["share"], alone["n_agents"]) == (0.75, 2)
    assert math.isnan(evenings_of("????", readable=True)["score"])
    apart = evenings_of("gg", "s?", "gs", readable=True)
    assert apart["volatility"] == pytest.approx(((5 / 6) ** 2 + (2 / 3) ** 2 + (1 / 6) ** 2) / 3 / 2)


def test_agents_that_take_turns_herd_or_toss_coins_have_known_figures():
    assert evenings_of("gs", "sg", "gs", "sg")["volatility_ratio"] == 0
    assert evenings_of("gggg", "ssss", "gggg", "ssss")["volatility_ratio"] == 4
    assert evenings_of("gggg", "ssss", "gggg", "ssss")["alternation"] == pytest.approx(1 / 3)
    assert bar.coins_off(10, 0.6) == pytest.approx(0.14766, abs=5e-6)
    assert bar.coins_off(1, 0.25) == 0.5


def fished(*months: tuple[object, ...], steps: int = 4, stock: int = 100, readable: bool = False) -> dict[str, float]:
    """Return the measures of a run in which the agents want so much by month; "?" cannot be read."""
    settings = {"name": "fishery", "agents": len(months[0]), "steps": steps, "stock": stock}
    answers = (json.dumps({"action": one}) for one in chain(*months))
    run = answered_run(games.fishery(**settings), answers, settings)
    assert fishery.applies(run)
    return fishery.measure(run.only_readable() if readable else run)


def test_months_worked_by_hand():
    found = fished((25, 25), (40, 20), (20, 0), (60, 20))  # stocks 100, 100, 80, 100
    assert found == {
        "months": 4, "survived": 1, "gain": (145 + 65) / 2, "efficiency": 1, "equality": pytest.approx(1 - 80 / 420),
        "over_use": 2 / 8, "n_agents": 2, "n_catches": 8,
    }  # fmt: skip
    assert {type(value) for value in found.values()} == {float}


def test_a_collapse_ends_the_months_and_what_was_caught_is_held_against_all_of_them():
    found = fished((10, 10), (50, 46))
    assert (found["months"], found["survived"]) == (2, 0)
    assert found["efficiency"] == pytest.approx(116 / 200) and found["over_use"] == 1 / 2


def test_what_was_not_read_or_never_caught_says_nothing():
    every, readable = (fished((30, "?"), (0, 0), (0, 0), (0, 0), readable=one) for one in (False, True))
    assert (every["over_use"], every["n_catches"]) == (1 / 8, 8)
    assert (readable["over_use"], readable["n_catches"]) == (1 / 7, 7)
    assert every["gain"] == readable["gain"] == 15
    nothing = fished(("?", "?"), ("?", "?"), ("?", "?"), ("?", "?"), readable=True)
    assert all(math.isnan(nothing[name]) for name in fishery.MEASURES)
    assert math.isnan(fished((0, 0), (0, 0), (0, 0), (0, 0))["equality"])
    found = fished(*[(1, 0, 0, 0)] * 4, stock=7)
    assert math.isnan(found["efficiency"]) and found["gain"] == 1 and found["over_use"] == 1 / 4


def met(*rounds: str) -> list[dict[str, Any]]:
    """Return the meetings of rounds such as "aa ab a-": two names a meeting, - for none."""
    names = {"-": None, "a": "ama", "b": "bodo", "c": "ceri"}
    return [
        {"step": step, "first_name": names[pair[0]], "second_name": names[pair[1]], "equal": pair[0] == pair[1] != "-"}
        for step, pairs in enumerate(rounds, start=1)
        for pair in pairs.split()
    ]


def meetings(*rounds: str, **settings: Any) -> RoundsRun:
    usual = {"names": ["ama", "bodo", "ceri"], "committed_name": None, "established": None}
    played = scripted_run("naming", "focal_name", steps=1)
    return replace(played, streams={"meetings": met(*rounds)}, world=usual | settings)


def test_meetings_worked_by_hand():
    measures = naming.measure(meetings("ab aa", "bc --", "bb bb", "bb bb"))
    assert measures["success"] == 5 / 8 and measures["success_last"] == 1
    assert (measures["converged"], measures["rounds"]) == (1, 3)
    assert (measures["names"], measures["names_last"], measures["names_ever"]) == (6 / 4, 1, 3)
    assert (measures["won_ama"], measures["won_bodo"], measures["won_ceri"]) == (0, 1, 0)
    assert (measures["n_rounds"], measures["n_meetings"]) == (4, 8)
    assert {type(value) for value in measures.values()} == {float}


@pytest.mark.parametrize("setting", ["established", "committed_name"])
def test_nobody_wins_where_names_are_not_alike_from_the_start(setting: str):
    measures = naming.measure(meetings("bb bb", **{setting: "ama"}))
    assert measures["converged"] == 1 and math.isnan(measures["won_bodo"])


def test_nobody_wins_without_a_consensus_and_new_names_have_no_column():
    measures = naming.measure(meetings("ab aa", "aa ab"))
    assert measures["converged"] == 0 and math.isnan(measures["rounds"]) and math.isnan(measures["won_ama"])
    assert not any(name.startswith("won_") for name in naming.measure(meetings("aa", names=None)))


@pytest.mark.parametrize(("failures", "converged"), [(1, 1), (2, 0)])
def test_a_consensus_is_nineteen_of_twenty(failures: int, converged: float):
    assert naming.measure(meetings(" ".join(["ab"] * failures + ["aa"] * (20 - failures))))["converged"] == converged


def minority(names: Sequence[str | None], committed: str | None) -> tuple[float, float]:
    rounds_run = meetings("ab", "ab", committed_name=committed)
    last, first = (np.full(len(names), step) for step in (2, 1))
    before = np.array(["bodo"] * len(names), dtype=np.object_)
    said = replace(
        rounds_run,
        step=np.concatenate((first, last)),
        agent=np.concatenate([np.arange(len(names))] * 2),
        kind=np.array(["say"] * 2 * len(names), dtype=np.object_),
        action=np.concatenate((before, np.array(names, dtype=np.object_))),
        outcome=np.array([0] * len(names) + [0 if name else 2 for name in names]),
    )
    measured = naming.measure(said)
    return measured["committed_share"], measured["turned"]


def test_the_committed_name_has_turned_the_others_where_most_of_them_say_it_in_the_last_round():
    assert minority(["ama", "ama", "bodo", None], "ama") == (2 / 3, 1)
    assert minority(["ama", "bodo", None], "ama") == (1 / 2, 0)
    assert all(map(math.isnan, minority(["ama", "ama"], None)))
    assert all(map(math.isnan, minority([None, None], "ama")))


def test_it_is_about_meetings_alone_in_which_one_name_wins_at_once_or_never():
    assert naming.applies(meetings("aa"))
    assert not naming.applies(scripted_run("fishery", "greedy_catch"))
    focal = naming.measure(scripted_run("naming", "focal_name", steps=3))
    assert (focal["success"], focal["rounds"], focal["won_bafu"], focal["names_ever"]) == (1, 1, 1, 1)
    drawn = [naming.measure(scripted_run("naming", "random", seed)) for seed in range(2)]
    success = np.mean([one["success"] for one in drawn])
    assert abs(success - 0.1) < 5 * math.sqrt(0.09 / (2 * 360)) and all(one["converged"] == 0 for one in drawn)


def rounds_of(*rounds: tuple[int | str, ...], readable: bool = False) -> dict[str, float]:
    settings = games.GOODS | {"agents": len(rounds[0]), "steps": len(rounds)}
    replies = (one if isinstance(one, str) else deciding(one) for one in chain(*rounds))
    run = answered_run(games.goods(**settings), replies, settings)
    assert public_goods.applies(run)
    return public_goods.measure(run.only_readable() if readable else run)


def test_rounds_worked_by_hand_and_what_could_not_be_read():
    found = rounds_of((20, 10, 0), (10, 5, 0))
    assert found["contribution"] == 7.5 and found["score"] == pytest.approx(62.5)
    assert found["efficiency"] == pytest.approx(0.375)
    assert found["trend"] == pytest.approx(-0.25)
    assert (found["free_riders"], found["nothing"]) == (1 / 3, 1 / 3)
    assert math.isnan(found["conditional"])
    assert rounds_of((20, "?"), (20, "?"))["score"] == 50
    alone = rounds_of((20, "?"), (20, "?"), readable=True)
    assert (alone["score"], alone["n_agents"]) == (0, 1)
    assert math.isnan(rounds_of(("?", "?"), readable=True)["score"])


def test_who_gives_half_of_what_others_gave_has_that_slope_and_needs_ten_rounds_for_it():
    rng, rounds = np.random.default_rng(0), [(0, 20)]
    while len(rounds) < 60:
        given = np.array(rounds[-1])[::-1] / 2 + rng.integers(0, 11, size=2)
        rounds.append(tuple(given.astype(int).tolist()))
    assert rounds_of(*rounds)["conditional"] == pytest.approx(0.5, abs=0.12)
    rng = np.random.default_rng(0)
    rounds = [tuple(row) for row in rng.integers(0, 21, size=(10, 4)).tolist()]
    assert math.isnan(rounds_of(*rounds[:9])["conditional"]) and not math.isnan(rounds_of(*rounds)["conditional"])


def test_who_gives_less_every_round_by_itself_follows_nobody():
    assert rounds_of(*((18 - 2 * step, 9 - step) for step in range(8)))["trend"] < 0
    values = [rounds_of(*zip(*((np.random.default_rng(9 * seed + one).integers(0, 20 - 2 * np.arange(10))).tolist()
              for one in range(4)), strict=True))["conditional"] for seed in range(12)]  # fmt: skip
    assert abs(np.mean(values)) < 3 * np.std(values) / math.sqrt(12)


def test_punishment_is_counted_with_what_it_costs_and_whom_it_hits():
    settings = games.GOODS | {"agents": 3, "steps": 1, "cost": 2, "loss": 3}
    said = [*map(deciding, (20, 10, 10)), *map(deciding, ("agent 2", "agent 2", "nobody"))]
    measures = public_goods.measure(answered_run(games.punished(**settings), said, settings))
    assert (measures["punishing"], measures["spent"], measures["antisocial"]) == pytest.approx((2 / 3, 4 / 3, 1 / 2))
    assert measures["efficiency"] == pytest.approx((40 - (2 * 2 + 2 * 3)) / 3 / 20)


@pytest.mark.slow
def test_games_with_different_questions_are_compared_by_their_own_measures_in_their_own_words(tmp_path):
    asked = ("-m", "world=public_goods,public_goods_punishment", "model=scripted/first,scripted/random", "seed=0-6")
    rest = ("prompt=public_goods", "world.steps=2", "world.agents=3", "analyze=false", "output.dir=games")
    succeeds(*asked, *rest, cwd=tmp_path)
    analysis = analyze(tmp_path / "games", plots=False, family=["idle_rate.chosen"])
    measures = analysis.contrasts.groupby("factor")["signature"].unique()
    assert {"public_goods", "idle_rate"} <= set(measures["model"])
    assert "public_goods" in measures["world"] and "idle_rate" not in measures["world"]
    assert any("ask different questions: public_goods and public_goods_punishment" in note for note in analysis.notes)
    for others in (analysis.variance["measure"], analysis.fingerprint.measures):
        assert "public_goods.score" in set(others) and "idle_rate.chosen" not in set(others)
    titles = means_picture(analysis.compared, analysis.shown, "idle_rate").says
    assert "Chose to do nothing" in titles and "stay" not in titles
    differing = [line for line in analysis.summary if "idle_rate.chosen" in line]
    assert differing and all("does nothing" in line and "stays" not in line for line in differing)
