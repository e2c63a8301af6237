"""Communication: how much agents say, to how many, and in what rhythm."""

import math
from collections import Counter

import numpy as np

from analysis.arrays import BoolArray
from analysis.formulas import gini, mean, ratio, variety
from analysis.grid.grid_run import GridRun
from analysis.measure import Measure, share

NAME = "communication"
QUESTION = "message"

MEASURES = {
    "delivered": Measure("Messages delivered per agent and step", low=0, says="reaches others {more|less} often"),
    "rate": share("Messages said per agent and step, heard or not", says="speaks {more|less} often"),
    "conditional_rate": share("Messages per agent and step with someone in reach"),
    "silent_share": share("Agents that never speak (share)"),
    "gini": share("Inequality of speaking (Gini)"),
    "burstiness": Measure("Burstiness, B", low=-1, high=1),
    "burstiness_finite": Measure("Burstiness, corrected for few messages", low=-1, high=1),
    "reciprocity": share("Links that go both ways (share)"),
    "audience": Measure("Hearers per message", low=0),
    "length": Measure("Length of a message (characters)", low=0, says="writes {longer|shorter} messages"),
    "variety": share("Pairs of messages with different texts (share)", says="says {more|less} varied things"),
    "distinct_share": share("Different texts (share of messages)"),
}

HEADLINE = ("delivered", "conditional_rate", "length", "variety")

_FEWEST_MESSAGES = 3
"""Minimum number of an agent's messages for burstiness: three messages have two intervals, so intervals can differ."""


def measure(run: GridRun) -> dict[str, float]:
    """Return the communication of a run, over the counted decisions on messages.

    A message counts as said even if nobody hears it, and as delivered once per hearer.

    - delivered: deliveries / decisions; 0..N-1.
    - rate: messages / decisions; 0..1.
    - conditional_rate: messages at decisions with a neighbour / decisions with a neighbour; 0..1. NaN without such
      decisions.
    - silent_share: agents that say nothing in the whole run / agents with any decision; 0..1.
    - gini: Gini coefficient of the number of messages per agent; 0 (equal)..1 - 1/N. NaN without messages.
    - burstiness: B = (r - 1) / (r + 1), where r is the standard deviation (ddof 0) of the steps between an agent's
      messages, divided by their mean; -1 (regular)..1. Mean over the agents with at least three messages; NaN without
      such agents. Source: Goh and Barabasi 2008.
    - burstiness_finite: burstiness corrected for n intervals (Kim and Jo 2016): (sqrt(n+1) r - sqrt(n-1)) / ((sqrt(n+1)
      - 2) r + sqrt(n-1)).
    - reciprocity: links with a link in the other direction / links; 0..1. A link leads from a sender to an agent that
      hears it in any step. NaN without deliveries.
    - audience: deliveries / messages; 0..N-1. NaN without messages.
    - length: mean length of a message, Unicode characters. NaN without messages.
    - variety: pairs of messages with different texts / pairs of messages; 0..1. NaN below two messages. Unlike
      distinct_share it does not fall with the number of messages. Source: Simpson 1949.
    - distinct_share: different texts / messages; 0..1. NaN without messages.

    Denominators: n_messages, n_deliveries, n_decisions, n_with_neighbour (decisions), n_links, n_rhythmic (agents with
    three messages or more), n_agents (with any decision).
    """
    counted = run.message_counted
    spoke, heard = run.spoke & counted, (run.neighbours > 0) & counted
    by_agent, present = spoke.sum(axis=0), counted.any(axis=0)
    messages, texts = int(by_agent.sum()), run.said[spoke].tolist()
    deliveries = run.deliveries[counted[run.deliveries[:, 0] - 1, run.deliveries[:, 1]]]
    links = np.zeros((run.agents, run.agents), dtype=np.bool_)
    links[deliveries[:, 1], deliveries[:, 2]] = True
    return {
        "delivered": ratio(len(deliveries), int(counted.sum())),
        "rate": ratio(messages, int(counted.sum())),
        "conditional_rate": ratio(int((spoke & heard).sum()), int(heard.sum())),
        "silent_share": ratio(int((by_agent == 0)[present].sum()), int(present.sum())),
        "gini": gini(by_agent),
        **_rhythm(spoke),
        "reciprocity": ratio(int((links & links.T).sum()), int(links.sum())),
        "n_links": float(links.sum()),
        "audience": ratio(len(deliveries), messages),
        "length": mean(len(text) for text in texts),
        "variety": variety(list(Counter(texts).values())),
        "distinct_share": ratio(len(set(texts)), messages),
        "n_messages": float(messages),
        "n_deliveries": float(len(deliveries)),
        "n_decisions": float(counted.sum()),
        "n_with_neighbour": float(heard.sum()),
        "n_agents": float(present.sum()),
    }


def _rhythm(spoke: BoolArray) -> dict[str, float]:
    times = [np.flatnonzero(flags) for flags in spoke.T]
    gaps = [np.diff(steps).astype(np.float64) for steps in times if len(steps) >= _FEWEST_MESSAGES]
    spreads = [(float(waits.std() / waits.mean()), len(waits)) for waits in gaps]
    return {
        "burstiness": mean((spread - 1) / (spread + 1) for spread, _ in spreads),
        "burstiness_finite": mean(_finite(spread, number) for spread, number in spreads),
        "n_rhythmic": float(len(spreads)),
    }


def _finite(spread: float, number: int) -> float:
    """Return the burstiness, corrected for a small number of gaps with this relative spread."""
    above, below = math.sqrt(number + 1), math.sqrt(number - 1)
    return (above * spread - below) / ((above - 2) * spread + below)
