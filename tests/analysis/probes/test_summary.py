"""What a probe says of itself: declared rows, what they rest on, and nothing of what cannot be said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from analysis.paper.summary import EXPLORES
from analysis.probes.probe_declaring import Family
from analysis.probes.probe_summary import summary_of

FIGURES = {"kind": "all", "moments": 40, "seeds": 24, "distance": 0.4, "floor": 0.1, "excess": 0.3,
           "excess_low": 0.2, "excess_high": 0.4, "p": 0.001, "p_holm": 0.002}  # fmt: skip


def pair(first: str, second: str, **changes: Any) -> dict[str, Any]:
    return {"first": first, "second": second, **FIGURES, **changes}


def edit(name: str, leaves: str, **changes: Any) -> dict[str, Any]:
    return {"model": "a", "edit": name, "leaves": leaves, **FIGURES, **changes}


def spread(choice: str, **changes: Any) -> dict[str, Any]:
    return {"model": "a", "choice": choice, **FIGURES, "kind": "action", "least": 0.1, "least_format": "none",
            "greatest": 0.7, "greatest_format": "spread/0", **changes}  # fmt: skip


def found(
    *rows: dict[str, Any],
    declared: str = "a",
    asked: int = 8,
    unread: int = 0,
    lost: dict[tuple[str, str, str], int] | None = None,
    spreads: tuple[dict[str, Any], ...] = (),
    known: str = "",
) -> list[str]:
    """Return the summary of a probe with these rows, the models named, and two that answered as often.

    Args:
        rows: of `agreement` and `edits`.
        declared: the models that are named.
        asked: how often each moment was asked.
        unread: of how many of these the answers of `b` could not be read.
        lost: the same by model, edit and format.
        spreads: rows of `formats`.
        known: what was known before the plan.
    """
    columns = ["model", "edit", "format", "run", "step", "choice", "count", "share"]
    lost = {("a", "none", "none"): 0, ("b", "none", "none"): unread, **(lost or {})}
    answers = [(*key, "r", 1, "up", asked - count, 1.0) for key, count in lost.items()]
    answers += [(*key, "r", 1, "unreadable", count, 0.0) for key, count in lost.items() if count]
    frames = {
        "agreement": pd.DataFrame([one for one in rows if "first" in one], columns=["first", "second", *FIGURES]),
        "edits": pd.DataFrame([one for one in rows if "edit" in one], columns=["model", "edit", "leaves", *FIGURES]),
        "moments": pd.DataFrame(answers, columns=columns),
        "formats": pd.DataFrame(spreads),
        "steepness": pd.DataFrame(),
    }
    lead, *told = summary_of(frames, Family(frozenset(declared), frozenset()), known=known)
    assert not (rows or spreads) or lead == EXPLORES  # also where a family is named with the analysis
    return told if rows or spreads else [lead]


def test_a_difference_stands_there_with_its_figures_and_what_weakens_it():
    (told,) = found(pair("a", "b"), unread=2)
    assert told == (
        "a and b choose differently beyond chance in the same moments: total variation 0.4, by chance 0.1, excess 0.3 "
        "[0.2, 0.4], 40 moments of 24 seeds, p = .002 in the only test (level .05); 25 % of the answers of b could not "
        "be read."
    )


def test_what_an_edit_does_is_said_by_what_it_should_leave():
    told = found(edit("mirror", "equivariance"), edit("names", "invariance"), edit("no_fire", "cause", p_holm=0.3))
    assert [one.split(":")[0] for one in told] == [
        "Under mirror a does not choose what it should",
        "names changes what a chooses, which it should not",
        "No change of what a chooses was found under no_fire, which takes a possible cause away",
    ]
    assert "after correction in 3" in told[0]


def test_formats_are_told_behind_the_rest_and_alone():
    spreads = (spread("left"), spread("right", p_holm=0.03), spread("unreadable", p_holm=0.001))
    told = found(pair("a", "b"), spreads=spreads)
    assert len(told) == 2 and told[1] == (
        "The format of the prompt changes how often a chooses left (action): 0.1 in format none, 0.7 in spread/0, "
        "excess 0.3 [0.2, 0.4], 40 moments of 24 seeds, p = .002 after correction in 3 (level .05); 1 further choice "
        "in formats.md."
    )
    assert found(spreads=(spread("left", p_holm=0.4),)) == [
        "No choice depends on the format of the prompt beyond chance in 1 test."
    ]
    assert "no share of a choice could be tested" in found(spreads=(spread("left", p_holm=np.nan),))[0]
    assert len(found(*(pair("a", str(n)) for n in range(8)), declared="", spreads=spreads)) == 5


def test_what_could_not_be_read_is_told_of_the_edit_and_the_format_in_which_it_was():
    lost = {("a", "none", "spread/0"): 8, ("a", "names", "none"): 2, ("a", "mirror", "none"): 0}
    rows = (pair("a", "b"), edit("names", "invariance"), edit("mirror", "equivariance"))
    told = {line.split(":")[0]: line for line in found(*rows, lost=lost, spreads=(spread("left"),))}
    unread = {start: line.count("could not be read") for start, line in told.items()}
    assert list(unread.values()) == [0, 1, 0, 1]
    assert (
        "25 % of the answers of a under names could not be read"
        in told["names changes what a chooses, which it should not"]
    )
    assert list(told.values())[-1].endswith("; 100 % of the answers of a in format spread/0 could not be read.")


def test_differences_stand_first_what_has_no_room_is_counted_and_what_was_not_declared_is_not_said():
    rows = [pair("a", str(number), p_holm=0.9 if number < 3 else 0.01, seeds=30) for number in range(8)]
    told = found(*rows, declared="")
    assert all("choose differently" in one for one in told[:4]) and len(told) == 5
    assert told[4] == (
        "4 further comparisons are in agreement.md and edits.md: 1 different and 3 without a difference found."
    )
    assert len(found(pair("a", "b"), pair("b", "c", p_holm=np.nan))) == 1
    known = "known before the plan: 8 answers, runs in out"
    told = found(pair("a", "b"), edit("names", "invariance"), known=known)
    assert len(told) == 2 and all(f"(level .05); {known}." in sentence for sentence in told)


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
