"""Recognition: whether an agent of a 3D world says that it sees the target when it does, and only then."""

from __future__ import annotations

import math

import numpy as np

from analysis.camera_run import CameraRun
from analysis.described import share
from analysis.formulas import ratio
from analysis.run import BoolArray
from analysis.sight_rule import claims_to_see

NAME = "recognition"

MEASURES = {
    "claim_rate": share("Claims to see the target (share of replies)"),
    "precision": share("True claims to see the target (share of claims)"),
    "recall": share("Target claimed when in view (share)"),
    "f1": share("Claims to see the target, F1"),
    "miss_rate": share("Target not claimed when in view (share)"),
    "false_claim_rate": share("Target claimed when not in view (share)"),
    "hallucinated": share("Claims of a target not in view (share of claims)"),
    "false_stop": share("Stays without the target in view (share of stays)"),
}

HEADLINE = ("precision", "recall", "false_claim_rate", "false_stop")

VISIBLE_PX = 20
"""Pixels of the target from which it counts as in view: below, nobody could tell what it is."""


def measure_camera(run: CameraRun) -> dict[str, float]:
    """Return how claims to see the target fit what the image showed.

    A claim is a reply that says so by the rule of `analysis.sight_rule`. The truth is that VISIBLE_PX pixels or more
    of the image the model saw belong to the target. Counted over the decisions whose reply holds any text.

    - claim_rate: claims / replies; 0..1.
    - precision: claims with the target in view / claims; 0..1. NaN without claims.
    - hallucinated: 1 - precision; the CHAIR_i of the target alone (Rohrbach et al. 2018).
    - recall: claims with the target in view / replies with it in view; 0..1. NaN when it never is in view.
    - miss_rate: 1 - recall.
    - f1: 2 true claims / (claims + replies with the target in view); 0..1. NaN when there is neither.
    - false_claim_rate: claims without the target in view / replies without it in view; 0..1. NaN when it always is.
    - false_stop: decisions to stay without the target in view / decisions to stay; 0..1. NaN without any.

    A silent model makes no false claim, so show n_claims beside them. In a run without a target all but the
    denominators are NaN. Denominators: n_claims, n_visible, n_replies, n_stays, n_decisions.
    """
    spoken = np.array([bool(text.strip()) for text in run.replies.tolist()], dtype=np.bool_)
    claims = [run.has_target and claims_to_see(text, run.episode.target) for text in run.replies[spoken].tolist()]
    claimed = np.array(claims, dtype=np.bool_)
    visible: BoolArray = run.target_px >= VISIBLE_PX
    stays = run.stay & run.readable
    found = {
        **agreement(claimed, visible[spoken]),
        "false_stop": ratio(int((stays & ~visible).sum()), int(stays.sum())),
    }
    return {
        **(found if run.has_target else dict.fromkeys(found, math.nan)),
        "n_claims": float(claimed.sum()),
        "n_visible": float(visible[spoken].sum()),
        "n_replies": float(spoken.sum()),
        "n_stays": float(stays.sum()),
        "n_decisions": float(run.decisions),
    }


def agreement(claimed: BoolArray, visible: BoolArray) -> dict[str, float]:
    """Return how well claims agree with the truth; both (n,)."""
    true, claims, present = int((claimed & visible).sum()), int(claimed.sum()), int(visible.sum())
    return {
        "claim_rate": ratio(claims, len(claimed)),
        "precision": ratio(true, claims),
        "hallucinated": ratio(claims - true, claims),
        "recall": ratio(true, present),
        "miss_rate": ratio(present - true, present),
        "f1": ratio(2 * true, claims + present),
        "false_claim_rate": ratio(claims - true, len(claimed) - present),
    }
