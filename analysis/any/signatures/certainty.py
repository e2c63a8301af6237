"""Certainty: how probable the model's decisions are by its own log-probabilities, and whether it is right as often."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.formulas import mean
from analysis.measure import LOW, Measure, Null, share
from foundry.certainty import GREATEST_ERROR, LEAST_COVERED, Certainty

NAME = "certainty"

PRIMARY = False

READABLE_TOO = False

MEASURES = {
    "probability": share(
        "Probability of the decision, among declared decisions", says="is {more|less} sure of its decisions"
    ),
    "entropy": share("Entropy of the probabilities of declared decisions (of its maximum)"),
    "covered": share("Probability of all declared decisions together"),
    "expected_*": share("Expected to decide * (share)", says="is expected to decide * {more|less} often"),
    "beyond_draws": Measure(
        "Expected share of the actual decision, minus its mean for random draws",
        -1,
        1,
        Null(0, "draws each decision by its expected shares", by_random=False),
    ),
    "brier": Measure("Brier score of the probabilities (0 best, 2 worst)", 0, 2, better=LOW),
    "overconfidence": Measure(
        "Probability of the likeliest decision, minus the share of right decisions",
        -1,
        1,
        Null(0, "is right as often as it is sure", by_random=False),
        says="is {more|less} overconfident",
    ),
}

HEADLINE = ("probability", "entropy", "expected_*", "overconfidence")


def applies(run: AnyRun) -> bool:
    """Return whether the log has log-probabilities (`model.logprobs`) and the world declares labels as decisions."""
    return run.probabilities is not None and any(actions.labels for actions in run.declared.actions.values())


def measure(run: AnyRun) -> dict[str, float]:
    """Return how certain a model is of its decisions, from the log-probabilities of the tokens of its replies.

    A decision has probabilities if one token of the reply decides between the declared labels. p(l) is the probability
    of label l at this token, divided by that of all labels together, at temperature 1 and before filters and grammar.
    q(l) is the share of decisions for l that is expected with the temperature and the filters of the call.

    - probability: mean of p(decided); 0..1.
    - entropy: mean of (-sum p log2 p) / log2 L, for the L declared labels; 0..1. Source: Shannon 1948.
    - covered: mean probability of all labels together; 0..1. Decisions that other measures leave out count too.
    - expected_<label>: mean of q(label); 0..1. If there are several kinds, the name is expected_<kind>_<label>. The
      measure estimates the same share as `action.share_<label>`, without the noise of drawing one decision.
    - beyond_draws: mean of (q(decided) - sum of q^2); -1..1. The measure is 0 if decisions are drawn with the
      probabilities q. Another value means that the server does not draw as the call says, for example at another
      temperature. Then expected shares are wrong.

    In worlds that record the right decision as `truth`:

    - brier: mean of sum over labels of (p(l) - [l is right])^2; 0..2. Source: Brier 1950.
    - overconfidence: mean of max p minus the share of decisions in which the likeliest label is right; -1..1. The
      measure is unbiased for any number of decisions, unlike an expected calibration error in bins (Naeini et al.
      2015). Source: Lichtenstein, Fischhoff and Phillips 1982.

    If labels cover less than LEAST_COVERED (.95) of a decision's probability, all measures but covered leave out the
    decision; n_low counts such decisions. A decision whose q may be wrong by more than GREATEST_ERROR (.05, total
    variation) is left out of expected and beyond_draws. NaN without decisions. Denominators: n_told, n_low, n_expected,
    n_right (with a right decision).
    """
    decisions = list(_run_decisions(run))
    knows_truth = run.probabilities is not None and run.probabilities.knows_truth
    covered = [decision for decision in decisions if decision.found.covered >= LEAST_COVERED]
    drawn = [decision for decision in covered if decision.found.error <= GREATEST_ERROR]
    return {
        "probability": mean(decision.found.probability for decision in covered),
        "entropy": mean(decision.found.entropy / math.log2(len(decision.found.shares)) for decision in covered),
        "covered": mean(decision.found.covered for decision in decisions),
        **_expected(run, drawn),
        "beyond_draws": mean(_beyond_draws(decision.found) for decision in drawn),
        **(
            _calibration([decision for decision in covered if decision.right in decision.found.shares])
            if knows_truth
            else {}
        ),
        "n_told": float(len(covered)),
        "n_low": float(len(decisions) - len(covered)),
        "n_expected": float(len(drawn)),
    }


@dataclass(frozen=True)
class _RunDecision:
    """The probabilities of one decision, the decision's kind, and the right answer, if there is one."""

    kind: str
    found: Certainty
    right: object


def _run_decisions(run: AnyRun) -> Iterator[_RunDecision]:
    if run.probabilities is None:
        return
    for number in np.flatnonzero(run.counted).tolist():
        certainty = run.probabilities.told[number]
        if certainty is not None and len(certainty.shares) > 1:
            yield _RunDecision(run.kind[number], certainty, run.probabilities.truth[number])


def _expected(run: AnyRun, drawn: list[_RunDecision]) -> dict[str, float]:
    declared = {kind: actions.labels for kind, actions in run.declared.actions.items()}
    return {
        f"expected_{kind}_{label}" if len(declared) > 1 else f"expected_{label}": mean(
            decision.found.expected[label] for decision in drawn if decision.kind == kind
        )
        for kind, labels in declared.items()
        for label in labels
    }


def _beyond_draws(certainty: Certainty) -> float:
    return certainty.expected[certainty.decided] - math.fsum(share**2 for share in certainty.expected.values())


def _calibration(decisions: list[_RunDecision]) -> Mapping[str, float]:
    return {
        "brier": mean(
            math.fsum((share - (label == decision.right)) ** 2 for label, share in decision.found.shares.items())
            for decision in decisions
        ),
        "overconfidence": mean(
            max(decision.found.shares.values()) - (_likeliest(decision.found) == decision.right)
            for decision in decisions
        ),
        "n_right": float(len(decisions)),
    }


def _likeliest(certainty: Certainty) -> str:
    return max(certainty.shares, key=lambda label: certainty.shares[label])
