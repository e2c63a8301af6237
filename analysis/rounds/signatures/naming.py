"""Naming: whether and when agents agree on a name, on which name, and whether a minority changes it."""

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
"""A meeting has two agents, so leaving out the unreadable reply of one would also leave out the reply of the other."""
AGREED = 0.95
"""Minimum share of successful interactions in a round that counts as a consensus."""

MEASURES = {
    "success": share("Interactions that succeed", better=HIGH, says="agrees on names {more|less} often"),
    "success_last": share("Interactions that succeed in the last round", better=HIGH),
    "converged": outcome("Reached consensus (1) or not (0)", better=HIGH),
    "rounds": Measure("Rounds to consensus", 1),
    "names": Measure("Different names said in a round (mean of rounds)", 0),
    "names_last": Measure("Different names said in the last round", 0),
    "names_ever": Measure("Different names said in the run", 0),
    "committed_share": share("Committed name among the names that uncommitted agents said in the last round"),
    "turned": outcome("The committed name prevails (1) or not (0)"),
    "won_*": replace(share("Consensus on * (1) or on another name (0)"), exclusive=True),
}

HEADLINE = ("success", "converged", "rounds", "names")


def applies(run: RoundsRun) -> bool:
    """Return whether agents meet in pairs and say names: the world declares `say` decisions and meetings."""
    return SAY in run.declared.actions and run.declared.streams.get(MEETINGS, {}).keys() >= KEYS


def measure(run: RoundsRun) -> dict[str, float]:
    """Return the results of all meetings, including those with committed agents.

    A consensus is a round in which at least 95 % of the interactions succeed; an unreadable reply names nothing. A
    meeting has two agents, so no measure uses the readable decisions alone.

    - success, success_last: share of successful interactions, in all rounds and in the last one.
    - converged: 1 with a consensus, else 0. rounds: first round with a consensus, NaN without.
    - names, names_last, names_ever: number of different names said in a round (mean over rounds), in the last round, in
      the run.
    - committed_share: share of the committed name among names that uncommitted agents said in the last round. NaN if
      the world has no committed name, or nothing was said.
    - turned: 1 if committed_share is above one half, else 0.
    - won_*: 1 for the most frequent name in the round of consensus, else 0, for each name of the world's settings. NaN
      without a consensus, and in worlds with an established or a committed name, where names are unequal from the
      start. The mean over runs is the share of consensuses that a name wins; without bias among k names it is 1/k.
      `equal_chances.csv` compares the counts of all names with equal shares.

    Denominators: n_rounds, n_meetings. Source: Ashery, Aiello and Baronchelli 2025 (arXiv 2410.08948); Baronchelli et
    al. 2006.
    """
    meetings = run.streams.get(MEETINGS, ())
    steps: IntArray = np.array([meeting["step"] for meeting in meetings], dtype=np.int64)
    number = np.bincount(steps)[1:]
    successes = np.bincount(steps, weights=[meeting["equal"] for meeting in meetings])[1:]
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
    said: Iterable[str | None] = (meeting[key] for meeting in meetings for key in ("first_name", "second_name"))
    return Counter(name for name in said if name is not None)


def _most(named: tuple[str, int]) -> tuple[int, str]:
    return named[1], named[0]


def _minority(run: RoundsRun) -> dict[str, float]:
    name = run.world["committed_name"]
    asked = (run.kind == SAY) & (run.step == run.steps) & run.readable
    share = ratio(float((run.action[asked] == name).sum()), float(asked.sum())) if name is not None else np.nan
    return {"committed_share": share, "turned": np.nan if np.isnan(share) else float(share > 0.5)}
