"""Questions after a walk: how well an agent of a 3D world knows where things are, beyond chance."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from analysis.camera.camera_run import CameraRun
from analysis.formulas import mean
from analysis.measure import HIGH, LOW, Measure, Null, share

NAME = "map_probe"

_BLIND = "draws its answers at random from the possible ones"

MEASURES = {
    "above_chance": Measure(
        "Right answers beyond chance (share)",
        -1,
        1,
        Null(0, _BLIND),
        better=HIGH,
        says="answers {more|fewer} questions about its walk correctly",
    ),
    "accuracy": share("Right answers (share)", better=HIGH),
    "chance": share("Chance of a right answer (share)"),
    "accuracy_*": share("Right answers about * (share)", better=HIGH),
    "chance_*": share("Chance of a right answer about * (share)"),
    "distance_error": Measure("Error of distances (m)", low=0, better=LOW),
    "distance_relative": Measure("Error of distances, relative to the best constant answer", low=0, better=LOW),
}

HEADLINE = ("above_chance", "distance_relative")

DISTANCE = "distance"


def applies(run: CameraRun) -> bool:
    """Return whether the world asks questions after a walk."""
    return "questions" in run.world


def measure(run: CameraRun) -> dict[str, float]:
    """Return how well the agent answered the questions after a walk.

    A choice or a count is right or wrong. An unreadable choice or count is wrong, or left out if only readable answers
    count. A distance has an error in metres; an unreadable distance is left out.

    - accuracy: right answers / questions other than distances; 0..1. accuracy_*: accuracy for one kind of question.
    - chance: mean of 1 / number of possible answers over these questions; 0..1. chance_*: chance for one kind.
    - above_chance: accuracy - chance; -1..1. Random answers have mean 0.
    - distance_error: |answer - truth|, metres; 0 up.
    - distance_relative: distance_error / mean absolute deviation from the median distance of all things in question; 0
      up. Always answering that median gives 1 on average; correct answers give 0.

    Each measure is NaN without questions of its kind. Denominators: n_questions, n_distances.
    """
    counted = [answer for answer in run.answers if not run.readable_only or _is_read(answer)]
    chosen = [answer for answer in counted if answer["kind"] != DISTANCE]
    far = [answer for answer in counted if answer["kind"] == DISTANCE and _is_read(answer)]
    kinds = [kind for kind in run.world.get("questions", ()) if kind != DISTANCE]
    measures = {"above_chance": _accuracy(chosen) - _chance(chosen)}
    measures |= {"accuracy": _accuracy(chosen), "chance": _chance(chosen)}
    for kind in kinds:
        own = [answer for answer in chosen if answer["kind"] == kind]
        measures |= {f"accuracy_{kind}": _accuracy(own), f"chance_{kind}": _chance(own)}
    errors = [abs(float(answer["answer"]) - float(answer["truth"])) for answer in far]
    return {
        **measures,
        "distance_error": mean(errors),
        "distance_relative": mean([error / answer["scale"] for error, answer in zip(errors, far, strict=True)]),
        "n_questions": float(len(chosen)),
        "n_distances": float(len(far)),
    }


def _is_read(answer: Mapping[str, Any]) -> bool:
    return answer["answer"] is not None


def _accuracy(answers: Sequence[Mapping[str, Any]]) -> float:
    return mean([answer["answer"] == answer["truth"] for answer in answers])


def _chance(answers: Sequence[Mapping[str, Any]]) -> float:
    return mean([answer["chance"] for answer in answers]) if answers else math.nan
