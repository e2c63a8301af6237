"""What a probe says of itself: declared rows, what they rest on, and nothing of what cannot be said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from analysis.paper.summary import EXPLORES
from analysis.probes.declaring import Family
from analysis.probes.summary import summary_of

FIGURES = {"kind": "all", "moments": 40, "seeds": 24, "distance": 0.4, "floor": 0.1, "excess": 0.3,
           "excess_low": 0.2, "excess_high": 0.4, "p": 0.001, "p_holm": 0.002}  # fmt: skip


def pair(first: str, second: str, **changes: Any) -> dict[str, Any]:
    return {"first": first, "second": second, **FIGURES, **changes}


def edit(name: str, leaves: str, **changes: Any) -> dict[str, Any]:
    return {"model": "a", "edit": name, "leaves": leaves, **FIGURES, **changes}


def found(*rows: dict[str, Any], declared: str = "a", asked: int = 8, unread: int = 0) -> list[str]:
    """Return the summary of a probe with these rows, the models named, and two that answered as often."""
    columns = ["model", "run", "step", "choice", "count", "share"]
    answers = [("a", "r", 1, "up", asked, 1.0), ("b", "r", 1, "up", asked - unread, 1.0)]
    answers += [("b", "r", 1, "unreadable", unread, 0.0)] if unread else []
    frames = {
        "agreement": pd.DataFrame([one for one in rows if "first" in one], columns=["first", "second", *FIGURES]),
        "edits": pd.DataFrame([one for one in rows if "edit" in one], columns=["model", "edit", "leaves", *FIGURES]),
        "moments": pd.DataFrame(answers, columns=columns),
        "formats": pd.DataFrame(),
        "steepness": pd.DataFrame(),
    }
    lead, *told = summary_of(frames, Family(frozenset(declared), frozenset()))
    assert not rows or lead == EXPLORES  # also where a family is named with the analysis
    return told if rows else [lead]


def test_a_difference_stands_there_with_its_figures_and_what_weakens_it():
    (told,) = found(pair("a", "b", excess_low=-0.01), unread=2)
    assert told == (
        "a and b choose differently beyond chance in the same moments: total variation 0.4, by chance 0.1, excess 0.3 "
        "[-0.01, 0.4], 40 moments of 24 seeds, p = .002 in the only test (level .05); its interval holds 0; 25 % of "
        "the answers of b could not be read."
    )


def test_what_an_edit_does_is_said_by_what_it_should_leave():
    told = found(edit("mirror", "equivariance"), edit("names", "invariance"), edit("no_fire", "cause", p_holm=0.3))
    assert [one.split(":")[0] for one in told] == [
        "Under mirror a does not choose what it should",
        "names changes what a chooses, which it should not",
        "No change of what a chooses was found under no_fire, which takes a possible cause away",
    ]
    assert "after correction in 3" in told[0]


def test_differences_stand_first_and_what_has_no_room_is_counted():
    rows = [pair("a", str(number), p_holm=0.9 if number < 3 else 0.01, seeds=30) for number in range(8)]
    told = found(*rows, declared="")
    assert all("choose differently" in one for one in told[:4]) and len(told) == 5
    assert told[4] == (
        "4 further comparisons are in agreement.md and edits.md: 1 different and 3 without a difference found."
    )


def test_rows_beside_what_was_declared_are_not_said():
    assert len(found(pair("a", "b"), pair("b", "c", p_holm=np.nan))) == 1


def test_nothing_is_said_of_what_no_answer_could_have_shown():
    assert found(pair("a", "b", seeds=5, p_holm=np.nan)) == [
        "Nothing can be said of 1 comparison, since fewer than 6 seeds only describe these runs."
    ]
    assert "since each moment was asked once" in found(pair("a", "b"), asked=1)[0]
    few = [pair("a", str(n), seeds=6, p_holm=0.0625) for n in range(4)]
    assert "no p can reach .05 with 6 seeds in 4 tests" in found(*few)[0]
    beside = [pair("a", str(n), seeds=10) for n in range(3)]
    assert "and a 3 choose differently" in found(*beside, pair("a", "a 3", seeds=6, p_holm=0.03))[3]
    assert found() == ["Nothing is compared: one model was asked, and nothing was edited."]
