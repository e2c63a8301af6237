"""What the signature of the fishery says of months worked by hand, and of policies whose results are known."""

from __future__ import annotations

import json
import math
from itertools import chain

import pytest

from analysis.rounds.signatures.fishery import MEASURES, applies, measure
from foundry.worlds.rounds.fishery import Fishery
from scripted_rounds import answered_run, scripted_run


def measured(*months: tuple[object, ...], steps: int = 4, stock: int = 100, readable: bool = False) -> dict[str, float]:
    """Return the measures of a run in which the agents want so much by month; "?" cannot be read."""
    settings = {"name": "fishery", "agents": len(months[0]), "steps": steps, "stock": stock, "collapse": 5, "talk": 0}
    scenario = Fishery(**settings, sharing="stochastic", universalisation=False, outsider=None)  # type: ignore[arg-type]
    answers = (json.dumps({"action": one}) for one in chain(*months))
    run = answered_run(scenario, answers, settings)
    assert applies(run)
    return measure(run.only_readable() if readable else run)


def test_months_worked_by_hand():
    found = measured((25, 25), (40, 20), (20, 0), (60, 20))  # stocks 100, 100, 80, 100
    assert found == {
        "months": 4, "survived": 1, "gain": (145 + 65) / 2, "efficiency": 1, "equality": pytest.approx(1 - 80 / 420),
        "over_use": 2 / 8, "n_agents": 2, "n_catches": 8,
    }  # fmt: skip
    assert {type(value) for value in found.values()} == {float}


def test_a_collapse_ends_the_months_and_what_was_caught_is_held_against_all_of_them():
    found = measured((10, 10), (50, 46))
    assert (found["months"], found["survived"]) == (2, 0)
    assert found["efficiency"] == pytest.approx(116 / 200) and found["over_use"] == 1 / 2


def test_what_was_not_read_or_never_caught_says_nothing():
    every, readable = (measured((30, "?"), (0, 0), (0, 0), (0, 0), readable=one) for one in (False, True))
    assert (every["over_use"], every["n_catches"]) == (1 / 8, 8)
    assert (readable["over_use"], readable["n_catches"]) == (1 / 7, 7)
    assert every["gain"] == readable["gain"] == 15
    nothing = measured(("?", "?"), ("?", "?"), ("?", "?"), ("?", "?"), readable=True)
    assert all(math.isnan(nothing[name]) for name in MEASURES)
    assert math.isnan(measured((0, 0), (0, 0), (0, 0), (0, 0))["equality"])
    found = measured(*[(1, 0, 0, 0)] * 4, stock=7)
    assert math.isnan(found["efficiency"]) and found["gain"] == 1 and found["over_use"] == 1 / 4


def test_who_takes_all_comes_to_one_month_and_who_takes_the_sustainable_share_to_all_there_is():
    greedy, lasting = (measure(scripted_run("fishery", policy, 2)) for policy in ("greedy_catch", "sustainable"))
    assert (greedy["months"], greedy["survived"], greedy["gain"]) == (1, 0, 20)
    assert lasting == {
        "months": 12, "survived": 1, "gain": 120, "efficiency": 1, "equality": 1, "over_use": 0, "n_agents": 5,
        "n_catches": 60,
    }  # fmt: skip
