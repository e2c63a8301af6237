"""Stability: how much an agent's next action depends on its previous one of the same kind."""

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray, IntArray, TextArray
from analysis.formulas import ratio
from analysis.measure import share
from analysis.repeats import MEASURES as KNOWN

NAME = "stability"

MEASURES = {
    "persistence": KNOWN["persistence"],
    "switching": share("Action differs from the previous one (share)"),
    "repeats_beyond_chance": KNOWN["repeats_beyond_chance"],
    "run_length": KNOWN["run_length"],
}

HEADLINE = ("persistence", "repeats_beyond_chance")


def measure(run: AnyRun) -> dict[str, float]:
    """Return how steadily the agents of a run repeat their actions.

    A pair is two successive decisions of one agent and one kind that both count and both have an action. Pairs are
    pooled over agents and kinds.

    - persistence: pairs of equal actions / pairs; 0..1. switching: pairs of different actions / pairs, 1 - persistence.
    - repeats_beyond_chance: persistence minus its expectation if each agent's actions of a kind came in random order;
      -1..1. If n_k of n counted actions are of sort k, a pair is equal by chance with probability sum of n_k (n_k - 1)
      / (n (n - 1)). This is exact even for few actions and for agents with different habits.
    - run_length: mean number of equal actions in a row. A decision without an action, or one that does not count, ends
      a row. NaN without any action.

    The other measures are NaN without pairs. Denominators: n_pairs, n_runs (rows of equal actions).
    """
    asked = _numbered(run.agent, _codes(run.kind))
    order = np.argsort(asked, kind="stable")
    asked, action, acted = asked[order], _actions(run)[order], (run.counted & _has_action(run))[order]
    pairs = acted[:-1] & acted[1:] & (asked[:-1] == asked[1:])
    equal = pairs & (action[:-1] == action[1:])
    repeats, total = int(equal.sum()), int(pairs.sum())
    return {
        "persistence": ratio(repeats, total),
        "switching": ratio(total - repeats, total),
        "repeats_beyond_chance": ratio(repeats - _by_chance(asked, action, acted, pairs), total),
        "run_length": ratio(int(acted.sum()), int(acted.sum()) - repeats),
        "n_pairs": float(total),
        "n_runs": float(int(acted.sum()) - repeats),
    }


def _by_chance(asked: IntArray, action: IntArray, acted: BoolArray, pairs: BoolArray) -> float:
    """Return how many pairs of successive actions would be equal by chance.

    By chance means: on average over random orders of each agent's actions of one kind.

    Args:
        asked: number of the agent and kind of each decision, (K,).
        action: number of the action of each decision, (K,).
        acted: whether each decision counts and has an action, (K,).
        pairs: whether each decision and the next one are a pair, (K - 1,).
    """
    if not pairs.any():
        return 0.0
    cells, sizes = np.unique(_numbered(asked[acted], action[acted]), return_counts=True)
    whose = cells // (int(action[acted].max()) + 1)
    alike = np.bincount(whose, weights=sizes * (sizes - 1.0))
    every = np.bincount(asked[acted])
    number = np.bincount(asked[:-1][pairs], minlength=len(alike))
    some = number > 0
    return float((number[some] * alike[some] / (every[some] * (every[some] - 1.0))).sum())


def _has_action(run: AnyRun) -> BoolArray:
    return np.array([action is not None for action in run.action.tolist()], dtype=np.bool_) | ~np.isnan(run.number)


def _actions(run: AnyRun) -> IntArray:
    """Return one number for each decision's action, (K,); equal actions get equal numbers."""
    return _numbered(_codes(run.action), np.unique(run.number, return_inverse=True)[1])


def _codes(values: TextArray) -> IntArray:
    """Return one number for each text, (K,); equal texts get equal numbers."""
    known: dict[str | None, int] = {}
    return np.array([known.setdefault(value, len(known)) for value in values.tolist()], dtype=np.int64)


def _numbered(first: IntArray, second: IntArray) -> IntArray:
    """Return a number for each pair of numbers, the same for equal pairs, (K,)."""
    return first * (int(second.max(initial=0)) + 1) + second
