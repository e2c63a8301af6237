"""Communication: how much agents say, to how many, in what rhythm."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from analysis.described import Measure, share
from analysis.formulas import mean, ratio
from analysis.run import GridRun, IntArray

NAME = "communication"

MEASURES = {
    "rate": share("Messages per agent and step"),
    "conditional_rate": share("Messages per agent and step with someone in reach"),
    "silent_share": share("Agents that never speak (share)"),
    "gini": share("Inequality of speaking (Gini)"),
    "burstiness": Measure("Burstiness, B", low=-1, high=1),
    "burstiness_finite": Measure("Burstiness, corrected for few messages", low=-1, high=1),
    "reciprocity": share("Links that go both ways (share)"),
    "audience": Measure("Hearers per message", low=0),
    "length": Measure("Length of a message (characters)", low=0),
    "distinct_share": share("Distinct texts (share of messages)"),
}

HEADLINE = ("rate", "conditional_rate", "length", "distinct_share")

_FEWEST_MESSAGES = 3
"""Messages of one agent that make two intervals, the least that has a spread."""


def measure(run: GridRun) -> dict[str, float]:
    """Return the communication of a run; a message counts as said even when nobody is near enough to hear it.

    - rate: messages / (T*N); 0..1.
    - conditional_rate: messages at agent-steps with a neighbour / agent-steps with a neighbour; 0..1. NaN
      when nobody ever has one.
    - silent_share: agents that say nothing in the whole run / N; 0..1.
    - gini: Gini coefficient of the messages by agent; 0 (equal)..1 - 1/N. NaN without messages.
    - burstiness: B = (r - 1) / (r + 1), r = sd / mean (ddof 0) of the steps between an agent's messages;
      -1 (regular)..1. Mean over the agents with three messages or more; NaN when there is none.
      Source: Goh and Barabasi 2008.
    - burstiness_finite: the same with the correction for n intervals of Kim and Jo 2016,
      (sqrt(n+1) r - sqrt(n-1)) / ((sqrt(n+1) - 2) r + sqrt(n-1)).
    - reciprocity: directed links (who ever reached whom) with a link back / links; 0..1. NaN without deliveries.
    - audience: deliveries / messages; 0..N-1. NaN without messages.
    - length: mean length of a message, Unicode characters. NaN without messages.
    - distinct_share: different texts / messages; 0..1. NaN without messages.

    Denominators: n_messages, n_deliveries, n_decisions (agent-steps), n_with_neighbour (agent-steps),
    n_links, n_rhythmic (agents with three messages or more).
    """
    by_agent = run.spoke.sum(axis=0)
    messages, texts = int(by_agent.sum()), run.said[run.spoke].tolist()
    heard = run.neighbours > 0
    times = [np.flatnonzero(run.spoke[:, agent]) for agent in range(run.agents)]
    rhythms = [steps for steps in times if len(steps) >= _FEWEST_MESSAGES]
    links = set(map(tuple, run.deliveries[:, 1:].tolist()))
    return {
        "rate": ratio(messages, run.decisions),
        "conditional_rate": ratio(int((run.spoke & heard).sum()), int(heard.sum())),
        "silent_share": ratio(int((by_agent == 0).sum()), run.agents),
        "gini": gini(by_agent),
        "burstiness": mean(burstiness(steps) for steps in rhythms),
        "burstiness_finite": mean(burstiness(steps, finite=True) for steps in rhythms),
        "reciprocity": reciprocity(links),
        "audience": ratio(len(run.deliveries), messages),
        "length": mean(len(text) for text in texts),
        "distinct_share": ratio(len(set(texts)), messages),
        "n_messages": float(messages),
        "n_deliveries": float(len(run.deliveries)),
        "n_decisions": float(run.decisions),
        "n_with_neighbour": float(heard.sum()),
        "n_links": float(len(links)),
        "n_rhythmic": float(len(rhythms)),
    }


def gini(counts: IntArray) -> float:
    """Return the Gini coefficient of counts (N,), 0..1 - 1/N; NaN when all are 0."""
    ranked = np.sort(counts)
    ranks = np.arange(1, len(ranked) + 1)
    return ratio(float(((2 * ranks - len(ranked) - 1) * ranked).sum()), float(len(ranked) * ranked.sum()))


def burstiness(times: IntArray, *, finite: bool = False) -> float:
    """Return the burstiness of event times, -1..1; NaN with fewer than two intervals.

    Args:
        times: ascending event times, (n + 1,).
        finite: whether to correct for the number of intervals n.
    """
    gaps = np.array([later - earlier for earlier, later in pairwise(times)], dtype=np.float64)
    if len(gaps) < _FEWEST_MESSAGES - 1:
        return math.nan
    spread = float(gaps.std() / gaps.mean())
    if not finite:
        return (spread - 1) / (spread + 1)
    above, below = math.sqrt(len(gaps) + 1), math.sqrt(len(gaps) - 1)
    return (above * spread - below) / ((above - 2) * spread + below)


def reciprocity(links: set[tuple[int, ...]]) -> float:
    """Return the share of directed links (from, to) with a link back; NaN without links."""
    return ratio(sum((target, source) in links for source, target in links), len(links))
