"""Communication: how much agents say, how many say anything, and how they answer."""

from collections import Counter

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import IntArray
from analysis.formulas import gini, mean, ratio, variety
from analysis.measure import Measure, share

NAME = "communication"

MEASURES = {
    "rate": share("Messages per agent and step", says="speaks {more|less} often"),
    "reply_rate": share(
        "Messages per agent and step after hearing one", says="speaks {more|less} often after it was spoken to"
    ),
    "silent_share": share("Agents that never speak (share)"),
    "gini": share("Inequality of speaking (Gini)"),
    "audience": Measure("Hearers per message", low=0),
    "length": Measure("Length of a message (characters)", low=0, says="writes {longer|shorter} messages"),
    "variety": share("Pairs of messages with different texts (share)", says="says {more|less} varied things"),
    "distinct_share": share("Different texts (share of messages)"),
}

HEADLINE = ("rate", "reply_rate", "length", "variety")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the communication of a run over the counted decisions; empty if the world cannot send messages.

    An agent-step is one agent at one step with a decision.

    - rate: agent-steps with a message / agent-steps; 0..1.
    - reply_rate: `rate` over agent-steps whose agent received a message at the step before; 0..1. NaN without such
      agent-steps. reply_rate equals rate if messages do not depend on received messages and all agents speak equally
      often.
    - silent_share: agents that say nothing in the whole run / agents with any decision; 0..1.
    - gini: Gini coefficient of the number of messages per agent; 0 (equal)..1 - 1/N. NaN without messages.
    - audience: deliveries / messages; 0..N. NaN without messages.
    - length: mean length of a message, Unicode characters. NaN without messages.
    - variety: pairs of messages with different texts / pairs of messages; 0..1. NaN below two messages. Unlike
      distinct_share, variety does not fall with the number of messages. Source: Simpson 1949.
    - distinct_share: different texts / messages; 0..1. NaN without messages.

    Denominators: n_messages, n_deliveries, n_decisions (agent-steps), n_after_one (agent-steps after a message),
    n_agents (with any decision).
    """
    if not run.talks:
        return {}
    spoke = run.counted & np.array([text is not None for text in run.said.tolist()], dtype=np.bool_)
    texts, by_agent = run.said[spoke].tolist(), np.bincount(run.agent[spoke], minlength=run.agents)
    moments = np.unique(_cells(run, run.step, run.agent)[run.counted])
    speaking = np.isin(moments, _cells(run, run.step, run.agent)[spoke])
    has_received = np.isin(moments, _cells(run, run.deliveries[:, 0] + 1, run.deliveries[:, 2]))
    deliveries = int(np.isin(_cells(run, run.deliveries[:, 0], run.deliveries[:, 1]), moments[speaking]).sum())
    present = np.bincount(run.agent[run.counted], minlength=run.agents) > 0
    return {
        "rate": mean(speaking),
        "reply_rate": mean(speaking[has_received]),
        "silent_share": mean(by_agent[present] == 0),
        "gini": gini(by_agent),
        "audience": ratio(deliveries, len(texts)),
        "length": mean(len(text) for text in texts),
        "variety": variety(list(Counter(texts).values())),
        "distinct_share": ratio(len(set(texts)), len(texts)),
        "n_messages": float(len(texts)),
        "n_deliveries": float(deliveries),
        "n_decisions": float(len(moments)),
        "n_after_one": float(has_received.sum()),
        "n_agents": float(present.sum()),
    }


def _cells(run: AnyRun, step: IntArray, agent: IntArray) -> IntArray:
    """Return one number for each pair of step and agent, (n,); different pairs get different numbers."""
    return step * run.agents + agent
