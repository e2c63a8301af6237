"""Action: which actions agents choose, and how evenly."""

import math

from analysis.any.any_run import AnyRun
from analysis.any.decided import DecisionsOfKind, decided
from analysis.formulas import entropy, mean, normalised_entropy, ratio, spread, variety
from analysis.measure import Measure, share

NAME = "action"

PRIMARY = False

MEASURES = {
    "share_*": share("Decisions for * (share of actions)", says="decides * {more|less} often"),
    "variety": share("Pairs of actions that differ (share)"),
    "variety_*": share("Pairs of actions that differ, * (share)"),
    "entropy": share("Entropy of actions (of its maximum)"),
    "entropy_*": share("Entropy of actions, * (of its maximum)"),
    "bits": Measure("Entropy of actions (bits)", low=0),
    "bits_*": Measure("Entropy of actions, * (bits)", low=0),
    "mean": Measure("Mean number decided"),
    "mean_*": Measure("Mean number decided, *"),
    "sd": Measure("Standard deviation of the numbers decided", low=0),
    "sd_*": Measure("Standard deviation of the numbers decided, *", low=0),
}

HEADLINE = ("share_*", "variety", "variety_*", "mean", "mean_*", "sd", "sd_*")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the actions of a run, over the counted decisions with an action, pooled over agents.

    If a world has several kinds of decisions, the names of measures end in `_<kind>`, and shares are named
    share_<kind>_<label>. For actions that are labels:

    - share_<label>: actions with this label / actions; 0..1. Only for declared labels.
    - variety: pairs of actions that differ / pairs of actions; 0..1. Its mean does not depend on the number of actions;
      for L equally frequent labels it is 1 - 1/L. NaN below two actions. Source: Simpson 1949.
    - bits: entropy of the labels, bits; 0..log2 L. entropy: bits / log2 L, for the L declared labels; 0..1. NaN for
      fewer than two declared labels. For n actions, bits is biased low by about (L - 1) / (2 n ln 2), and entropy
      by about (L - 1) / (2 n ln L), if all L labels can occur. Source: Shannon 1948; Miller 1955 for the bias.

    For numbers: mean; sd, the standard deviation (ddof 1), NaN below two actions.

    NaN without actions. Denominator: n_actions.
    """
    kinds = decided(run)
    measures_of_kinds: dict[str, float] = {}
    for kind in kinds:
        suffix = f"_{kind.kind}" if len({other.kind for other in kinds}) > 1 else ""
        measures = _labels(kind, suffix, bool(run.declared.actions)) if kind.labels else _numbers(kind)
        measures_of_kinds |= {
            name if name.startswith("share_") else f"{name}{suffix}": value for name, value in measures.items()
        }
    return measures_of_kinds


def _labels(decisions: DecisionsOfKind, suffix: str, declared: bool) -> dict[str, float]:
    total = len(decisions.step)
    names = [f"share{suffix}_{label}" for label in decisions.labels] if declared else []
    return {
        **{name: ratio(int(count), total) for name, count in zip(names, decisions.counts, strict=False)},
        "variety": variety(decisions.counts),
        "entropy": normalised_entropy(decisions.counts) if declared else math.nan,
        "bits": entropy(decisions.counts),
        "n_actions": float(total),
    }


def _numbers(decisions: DecisionsOfKind) -> dict[str, float]:
    numbers = decisions.values[:, 0]
    return {"mean": mean(numbers), "sd": spread(numbers), "n_actions": float(len(numbers))}
