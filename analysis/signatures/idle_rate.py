"""Idle rate: how often agents stay where they are, by choice, against an obstacle, or for want of a decision."""

from __future__ import annotations

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.formulas import longest_run, mean, ratio
from analysis.run import STAY, BoolArray, GridRun

NAME = "idle_rate"

MEASURES = {
    "chosen": share("Chose to stay (share of decisions)"),
    "chosen_readable": share("Chose to stay (share of readable decisions)"),
    "blocked": share("Blocked by the edge or an obstacle (share of decisions)"),
    "invalid": share("No readable decision (share of decisions)"),
    "immobile": share("Did not move (share of decisions)"),
    "longest_run": Measure("Longest immobile run (steps, mean of agents)", low=0),
}

HEADLINE = ("chosen", "blocked", "invalid")


def measure(run: GridRun) -> dict[str, float]:
    """Return the idle rate of a run, over all T*N decisions.

    - chosen: decisions read as `stay` / decisions; 0..1.
    - chosen_readable: the same over the chosen and repaired decisions alone; NaN when there is none.
    - blocked: moves asked for over the edge, so not made / decisions; 0..1.
    - invalid: decisions that could not be read, which leave the agent in place / decisions; 0..1.
    - immobile: steps without a change of position / decisions; chosen + blocked + invalid.
    - longest_run: longest unbroken run of immobile steps, steps, mean over agents; 0..T.

    Denominators: n_decisions, n_readable. A uniform walker over stay and the moves has chosen = 1/5.
    """
    parts = idle_parts(run.choice == STAY, run.moved, run.readable)
    runs = [longest_run(~run.moved[:, agent]) for agent in range(run.agents)]
    return {**parts, "longest_run": mean(runs)}


def measure_camera(run: CameraRun) -> dict[str, float]:
    """Return the idle rate of a run of a 3D world, over all T decisions.

    - chosen: decisions to stay by its own word / decisions; 0..1.
    - chosen_readable: the same over the chosen and repaired decisions alone; NaN when there is none.
    - blocked: translations asked for that came to less than a millimetre, for an obstacle / decisions; 0..1. The
      body may have turned all the same.
    - invalid: decisions that could not be read, which leave the agent in place / decisions; 0..1.
    - immobile: decisions after which place, heading and gaze are what they were / decisions; 0..1. Turning on the
      spot is no idleness, so chosen, blocked and invalid need not add up to it.
    - longest_run: longest unbroken run of immobile decisions; 0..T.

    All but the last are NaN without decisions. Denominators: n_decisions, n_readable.
    """
    readable, decisions = int(run.readable.sum()), run.decisions
    chosen = int((run.stay & run.readable).sum())
    return {
        "chosen": ratio(chosen, decisions),
        "chosen_readable": ratio(chosen, readable),
        "blocked": ratio(int(((run.asked > 0) & ~run.walked & run.collided).sum()), decisions),
        "invalid": ratio(decisions - readable, decisions),
        "immobile": ratio(int(run.immobile.sum()), decisions),
        "longest_run": float(longest_run(run.immobile)),
        "n_decisions": float(decisions),
        "n_readable": float(readable),
    }


def idle_parts(stay: BoolArray, moved: BoolArray, readable: BoolArray) -> dict[str, float]:
    """Return the shares of the kinds of immobility.

    Args:
        stay: whether the decision was, or was taken as, to stay; any shape.
        moved: whether the position changed; same shape.
        readable: whether the decision could be read; same shape.
    """
    chosen, decisions = int((stay & readable).sum()), stay.size
    return {
        "chosen": ratio(chosen, decisions),
        "chosen_readable": ratio(chosen, int(readable.sum())),
        "blocked": ratio(int((~stay & ~moved).sum()), decisions),
        "invalid": ratio(int((~readable).sum()), decisions),
        "immobile": ratio(int((~moved).sum()), decisions),
        "n_decisions": float(decisions),
        "n_readable": float(readable.sum()),
    }
