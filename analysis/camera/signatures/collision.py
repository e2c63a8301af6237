"""Collision: how often an agent of a 3D world runs into something."""

from analysis.camera.camera_run import CameraRun
from analysis.formulas import ratio
from analysis.measure import share

NAME = "collision"

MEASURES = {
    "rate": share("Collisions (share of decisions)", says="runs into things {more|less} often"),
    "rate_moving": share("Collisions (share of translations)"),
    "lost_way": share("Way asked for and not made (share)"),
}

HEADLINE = ("rate", "rate_moving")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the collisions of a run.

    A decision collides when its `boundary` names an obstacle, the bounds of the world or the edge of the floor; a
    gaze that cannot be turned any further is none. One decision counts once, whatever it slides along.

    - rate: decisions that collide / decisions; 0..1.
    - rate_moving: the same / decisions that ask for a translation; 0..1. NaN when there is none.
    - lost_way: 1 - way covered / way asked for, over the whole run; 0..1. NaN when none was asked for. A slide
      counts as covered way.

    All are NaN without decisions. Denominators: n_decisions, n_translations; n_collisions.
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
