"""Questions after a walk: how well an agent of a 3D world knows the places of things, beyond chance."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from analysis.camera.camera_run import CameraRun
from analysis.formulas import mean
from analysis.measure import HIGH, LOW, Measure, Null, share

NAME = "map_probe"

_BLIND = "draws its answers from those that are possible, whatever it sees"

MEASURES = {
    "above_chance": Measure(
        "Right answers beyond chance (share)",
        -1,
        1,
        Null(0, _BLIND),
        better=HIGH,
        says="answers {more|fewer} questions about its walk right",
    ),
    "accuracy": share("Right answers (share)", better=HIGH),
    "chance": share("Right answers of who draws them (share)"),
    "accuracy_*": share("Right answers about * (share)", better=HIGH),
    "chance_*": share("Right answers about * of who draws them (share)"),
    "distance_error": Measure("Error of distances (m)", low=0, better=LOW),
    "distance_relative": Measure(
        "Error of distances, against the best answer that is always the same", low=0, better=LOW
    ),
}

HEADLINE = ("above_chance", "distance_relative")

DISTANCE = "distance"


def applies(run: CameraRun) -> bool:
    """Return whether the world asks questions after a walk."""
    return "questions" in run.world


def measure(run: CameraRun) -> dict[str, float]:
    """Return how right the answers after a walk are.

    Of a choice or a count an answer is right or wrong; one that could not be read is wrong, and left out where the
    readable ones alone count. Of a distance an answer is off by some metres; one that could not be read is left out.

    - accuracy: right answers / questions but those for distances; accuracy_*: the same of one kind; 0..1.
    - chance: mean over those questions of 1 / answers that are possible; chance_*: of one kind; 0..1.
    - above_chance: accuracy - chance; -1..1. 0 in the mean for who draws.
    - distance_error: |answer - truth|, metres; 0 up.
    - distance_relative: the same / mean absolute deviation from their median of the distances of all things that could
      have been asked for: 1 in the mean for who knows that median and nothing else, 0 for who knows the way; 0 up.

    All are NaN without such a question. Denominators: n_questions, n_distances.
    """
    counted = [one for one in run.answers if not run.readable_only or _is_read(one)]
    chosen = [one for one in counted if one["kind"] != DISTANCE]
    far = [one for one in counted if one["kind"] == DISTANCE and _is_read(one)]
    kinds = [kind for kind in run.world.get("questions", ()) if kind != DISTANCE]
    found = {"above_chance": _accuracy(chosen) - _chance(chosen)}
    found |= {"accuracy": _accuracy(chosen), "chance": _chance(chosen)}
    for kind in kinds:
        own = [one for one in chosen if one["kind"] == kind]
        found |= {f"accuracy_{kind}": _accuracy(own), f"chance_{kind}": _chance(own)}
    errors = [abs(float(one["answer"]) - float(one["truth"])) for one in far]
    return {
        **found,
        "distance_error": mean(errors),
        "distance_relative": mean([error / one["scale"] for error, one in zip(errors, far, strict=True)]),
        "n_questions": float(len(chosen)),
        "n_distances": float(len(far)),
    }


def _is_read(one: Mapping[str, Any]) -> bool:
    return one["answer"] is not None


def _accuracy(answers: Sequence[Mapping[str, Any]]) -> float:
    return mean([one["answer"] == one["truth"] for one in answers])


def _chance(answers: Sequence[Mapping[str, Any]]) -> float:
    return mean([one["chance"] for one in answers]) if answers else math.nan
