"""Returns: the return of an agent is the sum of its rewards in an episode."""

import numpy as np

from analysis.measure import HIGH, Measure
from analysis.rounds.rounds_run import RoundsRun

NAME = "returns"
STREAM = "returns"
READABLE_TOO = False
MEASURES = {
    "mean": Measure("Return, mean over agents", better=HIGH, says="earns {more|less}"),
    "first": Measure("Return of the first agent", better=HIGH),
    "turns": Measure("Decisions per agent", low=0),
}
HEADLINE = ("mean", "first")


def applies(run: RoundsRun) -> bool:
    """Return whether the world records total rewards."""
    return {"agent", "total", "turns"} <= run.declared.streams.get(STREAM, {}).keys()


def measure(run: RoundsRun) -> dict[str, float]:
    """Return the measures.

    - mean: mean over agents of the undiscounted sum of an agent's rewards over the episode. Source: Sutton and Barto
      2018.
    - first: return of agent 0, who begins if agents act in turn.
    - turns: decisions per agent, mean over agents.

    Denominator: n_agents. Rewards after an agent's last decision count.
    """
    lines = sorted(run.streams[STREAM], key=lambda line: int(line["agent"]))
    totals = np.array([line["total"] for line in lines], dtype=np.float64)
    turns = np.array([line["turns"] for line in lines], dtype=np.float64)
    measures = {"mean": totals.mean(), "first": totals[0], "turns": turns.mean()}
    return {name: float(value) for name, value in measures.items()} | {"n_agents": float(totals.size)}
