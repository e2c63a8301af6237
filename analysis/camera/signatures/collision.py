"""Collision: how often an agent of a 3D world runs into something."""

from analysis.camera.camera_run import CameraRun
from analysis.formulas import ratio
from analysis.measure import share

NAME = "collision"

MEASURES = {
    "rate": share("Collisions (share of decisions)", says="runs into things {more|less} often"),
    "rate_moving": share("Collisions (share of translations)"),
    "lost_way": share("Requested distance not covered (share)"),
}

HEADLINE = ("rate", "rate_moving")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the collisions of a run.

    A decision is a collision if its `boundary` names an obstacle, the bounds of the world or the edge of the floor. A
    gaze at its limit is not one. A decision counts once, even if the body slides along several obstacles.

    - rate: collisions / decisions; 0..1.
    - rate_moving: collisions / decisions that request a translation; 0..1. NaN without translations.
    - lost_way: 1 - covered distance / requested distance, over the whole run; 0..1. NaN without translations. A slide
      counts as covered distance.

    All are NaN without decisions. Denominators: n_decisions, n_translations. Numerator: n_collisions.
    """
    decisions = int(run.counted.sum())
    asked, travelled = run.asked[run.counted], run.travelled[run.counted]
    translations, collisions = int((asked > 0).sum()), int((run.collided & run.counted).sum())
    return {
        "rate": ratio(collisions, decisions),
        "rate_moving": ratio(collisions, translations),
        "lost_way": ratio(float((asked - travelled).sum()), float(asked.sum())),
        "n_decisions": float(decisions),
        "n_translations": float(translations),
        "n_collisions": float(collisions),
    }
