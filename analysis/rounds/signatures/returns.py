"""Returns: the sum of an agent's rewards in an episode."""

import numpy as np

from analysis.measure import HIGH, Measure
from analysis.rounds.rounds_run import RoundsRun

NAME = "returns"
STREAM = "returns"
READABLE_TOO = False
MEASURES = {
    "mean": Measure("Return, mean over agents", better=HIGH, says="earns {more|less}"),
    "first": Measure("Return of the agent that begins", better=HIGH),
    "turns": Measure("Decisions of an agent", low=0),
}
HEADLINE = ("mean", "first")


def applies(run: RoundsRun) -> bool:
    """Return whether its world records what agents got in all."""
    return {"agent", "total", "turns"} <= run.declared.streams.get(STREAM, {}).keys()


def measure(run: RoundsRun) -> dict[str, float]:
    """Return the measures.

    - mean: sum of an agent's rewards over the episode, undiscounted, mean over agents. Source: Sutton and Barto 2018.
    - first: that of agent 0, who begins where agents act in turn.
    - turns: decisions of an agent, mean over agents.

    Denominator: n_agents. Rewards count that an agent was told after its last decision.
    """
    lines = sorted(run.streams[STREAM], key=lambda line: int(line["agent"]))
    totals = np.array([line["total"] for line in lines], dtype=np.float64)
    turns = np.array([line["turns"] for line in lines], dtype=np.float64)
    found = {"mean": totals.mean(), "first": totals[0], "turns": turns.mean()}
    return {name: float(value) for name, value in found.items()} | {"n_agents": float(totals.size)}
