"""Idle rate: how often agents stay where they are, by choice, against the edge, or for want of a decision."""

from __future__ import annotations

from analysis.described import Measure, share
from analysis.formulas import longest_run, mean, ratio
from analysis.run import STAY, BoolArray, GridRun

NAME = "idle_rate"

MEASURES = {
    "chosen": share("Chose to stay (share of decisions)"),
    "chosen_readable": share("Chose to stay (share of readable decisions)"),
    "blocked": share("Blocked by the edge (share of decisions)"),
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
