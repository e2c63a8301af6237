"""What the signature of the naming game says of meetings worked by hand, and of policies whose results are known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.rounds.rounds_run import RoundsRun
from analysis.rounds.signatures.naming import applies, measure
from scripted_rounds import scripted_run


def met(*rounds: str) -> list[dict[str, Any]]:
    """Return the meetings of rounds such as "aa ab a-": two names a meeting, - for none."""
    names = {"-": None, "a": "ama", "b": "bodo", "c": "ceri"}
    return [
        {
            "step": step,
            "first_name": names[pair[0]],
            "second_name": names[pair[1]],
            "equal": pair[0] == pair[1] != "-",
        }
        for step, pairs in enumerate(rounds, start=1)
        for pair in pairs.split()
    ]


def run(*rounds: str, **settings: Any) -> RoundsRun:
    usual = {"names": ["ama", "bodo", "ceri"], "committed_name": None, "established": None}
    played = scripted_run("naming", "focal_name", steps=1)
    return replace(played, streams={"meetings": met(*rounds)}, world=usual | settings)


def test_meetings_worked_by_hand():
    found = measure(run("ab aa", "bc --", "bb bb", "bb bb"))
    assert found["success"] == 5 / 8 and found["success_last"] == 1
    assert (found["converged"], found["rounds"]) == (1, 3)
    assert (found["names"], found["names_last"], found["names_ever"]) == (6 / 4, 1, 3)
    assert (found["won_ama"], found["won_bodo"], found["won_ceri"]) == (0, 1, 0)
    assert (found["n_rounds"], found["n_meetings"]) == (4, 8)
    assert {type(value) for value in found.values()} == {float}


@pytest.mark.parametrize("setting", ["established", "committed_name"])
def test_nobody_wins_where_names_are_not_alike_from_the_start(setting: str):
    found = measure(run("bb bb", **{setting: "ama"}))
    assert found["converged"] == 1 and math.isnan(found["won_bodo"])


def test_nobody_wins_without_a_consensus_and_new_names_have_no_column():
    found = measure(run("ab aa", "aa ab"))
    assert found["converged"] == 0 and math.isnan(found["rounds"]) and math.isnan(found["won_ama"])
    assert not any(name.startswith("won_") for name in measure(run("aa", names=None)))


@pytest.mark.parametrize(("failures", "converged"), [(1, 1), (2, 0)])
def test_a_consensus_is_nineteen_of_twenty(failures: int, converged: float):
    assert measure(run(" ".join(["ab"] * failures + ["aa"] * (20 - failures))))["converged"] == converged


def minority(names: Sequence[str | None], committed: str | None) -> tuple[float, float]:
    found = run("ab", "ab", committed_name=committed)
    last, first = (np.full(len(names), step) for step in (2, 1))
    before = np.array(["bodo"] * len(names), dtype=np.object_)
    said = replace(
        found,
        step=np.concatenate((first, last)),
        agent=np.concatenate([np.arange(len(names))] * 2),
        kind=np.array(["say"] * 2 * len(names), dtype=np.object_),
        action=np.concatenate((before, np.array(names, dtype=np.object_))),
        outcome=np.array([0] * len(names) + [0 if one else 2 for one in names]),
    )
    measured = measure(said)
    return measured["committed_share"], measured["turned"]


def test_the_committed_name_has_turned_the_others_where_most_of_them_say_it_in_the_last_round():
    assert minority(["ama", "ama", "bodo", None], "ama") == (2 / 3, 1)
    assert minority(["ama", "bodo", None], "ama") == (1 / 2, 0)
    assert all(map(math.isnan, minority(["ama", "ama"], None)))
    assert all(map(math.isnan, minority([None, None], "ama")))


def test_it_is_about_meetings_alone_in_which_one_name_wins_at_once_or_never():
    assert applies(run("aa"))
    assert not applies(scripted_run("fishery", "greedy_catch"))
    focal = measure(scripted_run("naming", "focal_name", steps=3))
    assert (focal["success"], focal["rounds"], focal["won_bafu"], focal["names_ever"]) == (1, 1, 1, 1)
    drawn = [measure(scripted_run("naming", "random", seed)) for seed in range(2)]
    success = np.mean([one["success"] for one in drawn])
    assert abs(success - 0.1) < 5 * math.sqrt(0.09 / (2 * 360)) and all(one["converged"] == 0 for one in drawn)


def test_who_answers_best_agrees_within_thirty_rounds():
    found = [measure(scripted_run("naming", "best_response", seed, until="consensus")) for seed in range(2)]
    assert all(one["converged"] == 1 and 1 < one["rounds"] == one["n_rounds"] for one in found)
