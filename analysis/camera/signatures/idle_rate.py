"""Idle rate: how often an agent stays in place by choice, at an obstacle, or after an unreadable reply."""

from analysis.camera.camera_run import CameraRun
from analysis.formulas import longest_run, mean
from analysis.measure import Measure, share

NAME = "idle_rate"

MEASURES = {
    "chosen": share("Chose to stay (share of decisions)", says="stays where it is {more|less} often"),
    "blocked": share(
        "Blocked by the edge or an obstacle (share of decisions)", says="runs against an obstacle {more|less} often"
    ),
    "invalid": share("No readable decision (share of decisions)"),
    "immobile": share("Did not move (share of decisions)"),
    "longest_run": Measure("Most successive steps without a move (mean of agents)", low=0),
}

HEADLINE = ("chosen", "blocked", "invalid")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the idle rate of a run of a 3D world, over its counted decisions.

    - chosen: decisions to stay / decisions; 0..1.
    - blocked: translations that an obstacle cut to less than a millimetre / decisions; 0..1. The body may still have
      turned.
    - invalid: unreadable decisions, which leave the agent in place / decisions; 0..1.
    - immobile: decisions that change neither place nor heading nor gaze / decisions; 0..1. immobile need not be the sum
      of chosen, blocked and invalid: a turn on the spot can count as blocked or chosen, but never as immobile.
    - longest_run: longest unbroken run of immobile decisions; 0..T.

    All are NaN without decisions. Denominator: n_decisions.
    """
    counted = run.counted
    return {
        "chosen": mean((run.stay & run.readable)[counted]),
        "blocked": mean(((run.asked > 0) & ~run.walked & run.collided)[counted]),
        "invalid": mean(~run.readable[counted]),
        "immobile": mean(run.immobile[counted]),
        "longest_run": mean([longest_run(run.immobile[counted])] if counted.any() else []),
        "n_decisions": float(counted.sum()),
    }
