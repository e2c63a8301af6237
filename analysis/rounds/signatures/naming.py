"""Naming: whether and how soon agents agree on a name, on which one, and whether a minority overturns it."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from analysis.arrays import IntArray
from analysis.formulas import mean, ratio
from analysis.measure import HIGH, Measure, outcome, share
from analysis.rounds.rounds_run import RoundsRun

NAME = "naming"
SAY, MEETINGS = "say", "meetings"
KEYS = {"first_name", "second_name", "equal"}
READABLE_TOO = False
"""A meeting is between two: to leave out what one of them did not say would leave out what the other did."""
AGREED = 0.95
"""Share of the interactions of a round that succeed in a consensus."""

MEASURES = {
    "success": share("Interactions that succeed", better=HIGH, says="agrees on names {more|less} often"),
    "success_last": share("Interactions that succeed in the last round", better=HIGH),
    "converged": outcome("Reached consensus (1) or not (0)", better=HIGH),
    "rounds": Measure("Rounds to consensus", 1),
    "names": Measure("Different names said in a round (mean of rounds)", 0),
    "names_last": Measure("Different names said in the last round", 0),
    "names_ever": Measure("Different names said in the run", 0),
    "committed_share": share("Names said in the last round, of those free to choose, that are the committed one"),
    "turned": outcome("The committed name prevails (1) or not (0)"),
    "won_*": replace(share("Consensus on * (1) or on another name (0)"), exclusive=True),
}

HEADLINE = ("success", "converged", "rounds", "names")


def applies(run: RoundsRun) -> bool:
    """Tell whether its world is one of pairs that meet and say names: it declares what is said and the meetings."""
    return SAY in run.declared.actions and run.declared.streams.get(MEETINGS, {}).keys() >= KEYS


def measure(run: RoundsRun) -> dict[str, float]:
    """Return what came of the meetings, those among committed agents included.

    A consensus is a round in which at least 95 % of the interactions succeed; what is not read names nothing.
    A meeting is between two, so no measure is over the readable decisions alone.

    - success, success_last: share of all interactions that succeed, and of those of the last round.
    - converged: 1 with a consensus, else 0. rounds: the first round of one, NaN without.
    - names, names_last, names_ever: different names that anyone said: in a round, mean over rounds; in the last one; in
      the whole run.
    - committed_share: share of what was said by those who were asked in the last round that is the committed name. NaN
      where the world names none, or nothing was said.
    - turned: 1 where that is more than a half, else 0.
    - won_*: 1 where this is the name said most in the round of the consensus, else 0, by each name that the world is
      set to. NaN without a consensus, and where the world names an established or a committed one, so that names are
      not alike from the start. The mean over runs is what share of consensuses a name wins; without any bias for one of
      k names it is 1/k. `equal_chances.csv` holds the counts of all against that.

    Denominators: n_rounds, n_meetings. Source: Ashery, Aiello and Baronchelli 2025 (arXiv 2410.08948); Baronchelli et
    al. 2006.
    """
    meetings = run.streams.get(MEETINGS, ())
    steps: IntArray = np.array([one["step"] for one in meetings], dtype=np.int64)
    number = np.bincount(steps)[1:]
    successes = np.bincount(steps, weights=[one["equal"] for one in meetings])[1:]
    by_round = [_names(meetings[end - count : end]) for count, end in zip(number, number.cumsum(), strict=True)]
    agreed = np.flatnonzero(successes >= AGREED * number)
    alike = run.world["established"] is None and run.world["committed_name"] is None
    winner = max(by_round[agreed[0]].items(), key=_most)[0] if agreed.size and alike else None
    return {
        "success": ratio(float(successes.sum()), len(meetings)),
        "success_last": float(successes[-1] / number[-1]) if number.size else np.nan,
        "converged": float(agreed.size > 0),
        "rounds": float(agreed[0] + 1) if agreed.size else np.nan,
        "names": mean(map(len, by_round)),
        "names_last": float(len(by_round[-1])) if by_round else np.nan,
        "names_ever": float(len(set().union(*by_round))),
        **_minority(run),
        **{f"won_{name}": np.nan if winner is None else float(name == winner) for name in run.world["names"] or ()},
        "n_rounds": float(len(number)),
        "n_meetings": float(len(meetings)),
    }


def _names(meetings: Sequence[Mapping[str, Any]]) -> Counter[str]:
    """Return how often each name was said."""
    said: Iterable[str | None] = (one[key] for one in meetings for key in ("first_name", "second_name"))
    return Counter(name for name in said if name is not None)


def _most(named: tuple[str, int]) -> tuple[int, str]:
    return named[1], named[0]


def _minority(run: RoundsRun) -> dict[str, float]:
    name = run.world["committed_name"]
    asked = (run.kind == SAY) & (run.step == run.steps) & run.readable
    found = ratio(float((run.action[asked] == name).sum()), float(asked.sum())) if name is not None else np.nan
    return {"committed_share": found, "turned": np.nan if np.isnan(found) else float(found > 0.5)}
