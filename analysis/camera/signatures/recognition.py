"""Recognition: whether an agent of a 3D world says that it sees a thing only when the thing is in view."""

import math
from collections.abc import Sequence

import numpy as np

from analysis.arrays import BoolArray, FloatArray
from analysis.camera.camera_run import CameraRun
from analysis.camera.sight_rule import claims_to_see, is_readable, thing_of, things_claimed
from analysis.camera.sight_words import AMBIGUOUS, THINGS
from analysis.formulas import mean, ratio
from analysis.labelling.correcting import Correction, adjusted
from analysis.measure import HIGH, LOW, Measure, Null, share

NAME = "recognition"

_BLIND = "claims to see it without regard to the image"

MEASURES = {
    "informedness": Measure(
        "Claims to see the target when in view, minus those when not (share)",
        -1,
        1,
        Null(0, _BLIND),
        better=HIGH,
        says="tells {better|worse} whether the target is in view",
    ),
    "claim_rate": share("Claims to see the target (share of replies)"),
    "accuracy": share("Right about the target, seen or not (share of replies)", better=HIGH),
    "precision": share("True claims to see the target (share of claims)", better=HIGH),
    "recall": share("Target claimed when in view (share)", better=HIGH),
    "f1": share("Claims to see the target, F1", better=HIGH),
    "mcc": Measure("Claims to see the target, Matthews correlation", -1, 1, Null(0, _BLIND), better=HIGH),
    "miss_rate": share("Target not claimed when in view (share)", better=LOW),
    "false_claim_rate": share("Target claimed when not in view (share)", better=LOW),
    "hallucinated": share("False claims to see the target (share of claims)", better=LOW),
    "false_stop": share("Stays without the target in view (share of stays)"),
    "chair_i": share("Things named but not in view (share of mentions, CHAIR_i)", better=LOW),
    "chair_s": share("Replies that name a thing not in view (share, CHAIR_s)", better=LOW),
    "mentions": Measure("Things claimed to be seen, per reply", low=0),
    "object_precision": share("Things named that are in view (share of mentions)", better=HIGH),
    "object_recall": share("Things in view that are named (share)", better=HIGH),
    "object_f1": share("Things named and in view, F1", better=HIGH),
    "object_miss_rate": share("Things in view that are not named (share)", better=LOW),
}

HEADLINE = ("informedness", "recall", "false_claim_rate", "false_stop", "chair_i", "object_recall")

LABEL = "sight_claim"
"""Name of the label that says whether a reply claims to see the target; most measures are computed from it."""
UNLABELLED = ("false_stop",)

VISIBLE_PX = 20
"""A thing counts as in view if the image shows at least this number of its pixels."""


def measure(run: CameraRun) -> dict[str, float]:
    """Return how well claims to see things agree with the images.

    A reply makes a claim according to `sight_rule`. A thing is in view if it covers at least VISIBLE_PX pixels of the
    image. Only counted decisions with a non-empty reply are used. Replies in neither English nor Japanese have no
    label; only false_stop counts them.

    Of the target:

    - informedness: recall - false_claim_rate; -1..1. Claims that ignore the image give 0, for any number of claims and
      any path of the agent. The precision of such claims is the share of images with the target in view. NaN if the
      target is always or never in view. Source: Youden 1950.
    - claim_rate: claims / replies; 0..1.
    - accuracy: (claims with the target in view + replies without a claim and without the target in view) / replies;
      0..1.
    - precision: claims with the target in view / claims; 0..1. NaN without claims.
    - hallucinated: 1 - precision; the CHAIR_i of the target alone (Rohrbach et al. 2018).
    - recall: claims with the target in view / replies with it in view; 0..1. NaN if it is never in view.
    - miss_rate: 1 - recall: the target missed while visible.
    - f1: 2 true claims / (claims + replies with the target in view); 0..1. NaN if there are no claims and the target is
      never in view.
    - mcc: Matthews correlation between a claim and the target in view; -1..1. NaN if either never changes.
    - false_claim_rate: claims without the target in view / replies without it in view; 0..1. NaN if the target always
      is in view.
    - false_stop: decisions to stay without the target in view (a false "target found") / decisions to stay; 0..1. NaN
      without decisions to stay. This measure needs neither claims nor text.

    For all kinds of things (`thing_of` a label), in the fixed table of `sight_words` or labelled in an image of the
    run. A kind counts once per reply:

    - chair_i: mentions of kinds not in view / mentions; 0..1. NaN without mentions.
    - chair_s: replies with such a mention / replies; 0..1.
    - mentions: mentions / replies; 0 up. A silent model makes no mistakes, so always show this measure with the others.
    - object_precision: 1 - chair_i.
    - object_recall: mentions of kinds in view / kinds in view, over all replies; 0..1. NaN if no kind ever is in view.
    - object_miss_rate: 1 - object_recall. object_f1: 2 true mentions / (mentions + kinds in view).

    Measures of the target are NaN without a target; measures of things are NaN if the scene labels nothing. Unlabelled
    things count as absent. Denominators: n_claims, n_visible, n_replies (with a label), n_unlabelled (replies),
    n_stays, n_decisions, n_mentions, n_things (in view, over replies). Source: Rohrbach et al. 2018 (CHAIR), Li et al.
    2023 (yes/no probing: accuracy, f1, claim_rate).
    """
    answered = run.counted & np.array([bool(text.strip()) for text in run.replies.tolist()], dtype=np.bool_)
    replied = _has_readable_reply(run)
    replies = run.replies[replied].tolist()
    claimed = _claimed(run, replies)
    visible: BoolArray = run.target_px >= VISIBLE_PX
    stays = run.stay & run.readable & run.counted
    measures = agreement(claimed, visible[replied])
    measures["false_stop"] = ratio(int((stays & ~visible).sum()), int(stays.sum()))
    return {
        **(measures if run.has_target else dict.fromkeys(measures, math.nan)),
        **_of_things(run, replied, replies),
        "n_claims": float(claimed.sum()),
        "n_visible": float(visible[replied].sum()),
        "n_replies": float(replied.sum()),
        "n_unlabelled": float((answered & ~replied).sum()),
        "n_stays": float(stays.sum()),
        "n_decisions": float(run.counted.sum()),
    }


def correct(run: CameraRun, correction: Correction) -> dict[str, FloatArray]:
    """Return by name the measures that labels by people correct; each has one value, (1,).

    Shares of replies are means of labels. Measures with claims in their denominator have no correction.
    """
    replied = _has_readable_reply(run)
    if not run.has_target:
        return {}
    asked = {int(row["step"]) for row in run.answers}
    steps = [step for step in range(1, run.decisions + len(asked) + 1) if step not in asked]
    place = {step: number for number, step in enumerate(steps)}
    truth, weight = np.full(run.decisions, math.nan), np.ones(run.decisions)
    for weighed in (weighed for weighed in correction.by_run.get(run.id, ()) if weighed.step in place):
        truth[place[weighed.step]] = weighed.shares.get(correction.label.choices[0], 0.0)
        weight[place[weighed.step]] = weighed.weight
    claimed = _claimed(run, run.replies[replied].tolist()).astype(np.float64)
    visible: BoolArray = run.target_px >= VISIBLE_PX
    means = _means(adjusted(claimed, truth[replied], weight[replied]), visible[replied])
    return {name: np.array([value]) for name, value in means.items()}


def _has_readable_reply(run: CameraRun) -> BoolArray:
    """Return, for each decision, whether it counts and the rule can read its reply, (T,)."""
    texts = run.replies.tolist()
    return run.counted & np.array([bool(text.strip()) and is_readable(text) for text in texts], dtype=np.bool_)


def _claimed(run: CameraRun, replies: Sequence[str]) -> BoolArray:
    """Return, for each reply, whether it claims to see the target according to the rule, (n,)."""
    claims = {text: run.has_target and claims_to_see(text, run.episode.target) is True for text in set(replies)}
    return np.array([claims[text] for text in replies], dtype=np.bool_)


def agreement(claimed: BoolArray, visible: BoolArray) -> dict[str, float]:
    """Return the measures of claims to see the target, given whether each image shows it; both (n,)."""
    true, claims, present = int((claimed & visible).sum()), int(claimed.sum()), int(visible.sum())
    absent = len(claimed) - present
    rejected = absent - (claims - true)
    spread = claims * (len(claimed) - claims) * present * absent
    return {
        **_means(claimed.astype(np.float64), visible),
        "precision": ratio(true, claims),
        "hallucinated": ratio(claims - true, claims),
        "f1": ratio(2 * true, claims + present),
        "mcc": ratio(true * rejected - (claims - true) * (present - true), math.sqrt(spread)),
    }


def _means(claimed: FloatArray, visible: BoolArray) -> dict[str, float]:
    """Return the measures that are means over replies of whether a reply claims to see the target.

    Args:
        claimed: 1 for a claim, else 0, (n,); after a correction by people's labels, any number.
        visible: whether the image shows the target, (n,).
    """
    true, claims, present = float(claimed[visible].sum()), float(claimed.sum()), int(visible.sum())
    absent = len(claimed) - present
    return {
        "informedness": ratio(true, present) - ratio(claims - true, absent),
        "claim_rate": ratio(claims, len(claimed)),
        "accuracy": ratio(true + absent - (claims - true), len(claimed)),
        "recall": ratio(true, present),
        "miss_rate": ratio(present - true, present),
        "false_claim_rate": ratio(claims - true, absent),
    }


def hallucination(mentioned: Sequence[set[str]], visible: Sequence[set[str]]) -> dict[str, float]:
    """Return measures that compare the kinds of things that each reply claims to see with the kinds in its image."""
    false = [len(named - seen) for named, seen in zip(mentioned, visible, strict=True)]
    mentions, things = sum(map(len, mentioned)), sum(map(len, visible))
    true = mentions - sum(false)
    return {
        "chair_i": ratio(sum(false), mentions),
        "chair_s": mean(count > 0 for count in false),
        "mentions": ratio(mentions, len(mentioned)),
        "object_precision": ratio(true, mentions),
        "object_recall": ratio(true, things),
        "object_f1": ratio(2 * true, mentions + things),
        "object_miss_rate": ratio(things - true, things),
        "n_mentions": float(mentions),
        "n_things": float(things),
    }


def _of_things(run: CameraRun, replied: BoolArray, replies: Sequence[str]) -> dict[str, float]:
    labels = {label: thing_of(label) for label in set().union(*run.visible_px)}
    frames = [run.visible_px[index] for index in np.flatnonzero(replied).tolist()]
    visible = [{labels[name] for name, count in pixels.items() if count >= VISIBLE_PX} for pixels in frames]
    known = sorted({*labels.values(), *(thing for thing in THINGS if thing not in AMBIGUOUS)})
    named = {reply: things_claimed(reply, known) if labels else set() for reply in set(replies)}
    mentioned = [named[reply] for reply in replies]
    measures = hallucination(mentioned, visible)
    return measures if labels else {name: 0.0 if name.startswith("n_") else math.nan for name in measures}
