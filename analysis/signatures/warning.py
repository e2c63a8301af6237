"""Warning propagation: how far news of a fire travels by word of mouth.

What counts as a warning is said in `analysis.warning_rule`. Order within a step: agents perceive, speak, and
hear what was said at this step; so a message of step t can be passed on from step t + 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.described import Measure, share
from analysis.formulas import mean, ratio
from analysis.run import BoolArray, FloatArray, GridRun, IntArray
from analysis.warning_rule import is_warning

NAME = "warning"

MEASURES = {
    "informed_fraction": share("Informed agents (share)"),
    "social_reach": share("Told before seeing a fire (share of those not first to see)"),
    "traced_reach": share("Told by a chain from someone who saw a fire (share)"),
    "oracle_reach": share("Reachable if everyone relayed (share)"),
    "normalised_reach": share("Told / reachable if everyone relayed"),
    "relay_probability": share("Told agents that warn in turn (share)"),
    "reproduction": share("Told by an informed agent, per informed agent (R)"),
    "depth": Measure("Longest chain of warnings", low=0),
    "trees": Measure("Separate chains of warnings", low=0),
    "rmst": Measure("Mean time to the first warning (steps, restricted)", low=0),
    "false_alarm_rate": share("False alarms (share of messages)"),
    "warning_share": share("Warnings (share of messages)"),
}

HEADLINE = ("social_reach", "relay_probability", "false_alarm_rate")

RELAY_WITHIN = 5
"""Steps after being told within which a warning counts as a relay."""

NEVER: int = np.iinfo(np.int64).max
"""The step of what does not happen."""

_NOBODY = -1


@dataclass(frozen=True)
class Cascade:
    """Who learnt of a fire how; arrays by agent, (N,).

    Attributes:
        direct: perceived a fire itself, and was not warned before.
        told: received a warning before it perceived a fire, if it ever did.
        told_at: step of the first received warning, or NEVER.
        parent: sender of that warning where it makes an edge of the forest, else -1.
    """

    direct: BoolArray
    told: BoolArray
    told_at: IntArray
    parent: IntArray


def measure(run: GridRun) -> dict[str, float]:
    """Return the warning propagation of a run.

    An agent is *told* when it receives a warning at an earlier step than it first perceives a fire (or ever
    receives one, if it never does); *direct* when it perceives a fire and was not told; *informed* when either.

    - informed_fraction: informed agents / N; 0..1.
    - social_reach: told agents / (N - direct agents); 0..1. NaN when all are direct.
    - traced_reach: the same with warnings that go back to a perceived fire only: the sender has perceived one
      by then, or has at an earlier step received such a warning. Equals social_reach when nobody cries wolf.
    - oracle_reach: the same had everyone relayed at every step to all recorded neighbours: a bound that is set
      by where agents went.
    - normalised_reach: agents told by traced warnings / agents told under the oracle; 0..1. NaN when the
      oracle reaches nobody. Low means that news was not passed on, not that nobody was near.
    - relay_probability: told agents that send a warning 1..RELAY_WITHIN steps after being told / told agents;
      0..1. NaN when nobody is told.
    - reproduction: R, edges / informed agents; 0..1. An edge leads from the sender of an agent's first warning
      (lowest step, then lowest id) to that agent, if it is told and had sent no warning of its own by then;
      else it begins a chain of its own. So the edges form a forest.
    - depth: edges on the longest path of the forest; 0..N-1.
    - trees: trees of the forest with two agents or more.
    - rmst: restricted mean time to the first warning, steps, 0..T: area under the Kaplan-Meier curve over all
      agents from the run's start to T. An agent that perceives a fire itself, untold, at step d is censored at
      d - 1; one that does neither, at T. After the last event the curve stays level. NaN when all are direct.
    - false_alarm_rate: warnings whose sender has perceived no fire by then and received no warning at an
      earlier step / messages said; 0..1. NaN without messages.
    - warning_share: warnings / messages said; 0..1. NaN without messages.

    All but the last two are NaN when no agent perceives a fire (so also without fires). Perceived but never
    passed on gives a reach, R and depth of 0.

    Denominators: n_direct, n_told, n_reachable, n_warnings, n_messages.
    Source: Goel et al. 2015 for the forest; Kaplan and Meier 1958.
    """
    warned = _labels(run)
    perceived_at = first_step(run.perceived)
    heard = run.deliveries[warned[run.deliveries[:, 0] - 1, run.deliveries[:, 1]]]
    cascade = trace(perceived_at, first_step(warned), heard)
    messages = int(run.spoke.sum())
    false_alarms = int((warned & ~_informed(perceived_at, cascade.told_at, run.steps)).sum())
    reach = _reach(perceived_at, cascade, warned, heard=heard, contacts=run.contacts)
    if not (perceived_at < NEVER).any():
        reach = dict.fromkeys(reach, math.nan)
    return reach | {
        "false_alarm_rate": ratio(false_alarms, messages),
        "warning_share": ratio(int(warned.sum()), messages),
        "n_direct": float(cascade.direct.sum()),
        "n_told": float(cascade.told.sum()),
        "n_reachable": float((spread(perceived_at, run.contacts) < perceived_at).sum()),
        "n_warnings": float(warned.sum()),
        "n_messages": float(messages),
    }


def _labels(run: GridRun) -> BoolArray:
    """Return which messages were warnings, (T, N)."""
    fires = tuple(fire.name for fire in run.world.fires)
    texts = set(run.said[run.spoke].tolist())
    warnings = {text for text in texts if is_warning(text, fires)}
    labels = [text in warnings for text in run.said.ravel().tolist()]
    return np.array(labels, dtype=np.bool_).reshape(run.said.shape)


def _reach(
    perceived_at: IntArray, cascade: Cascade, warned: BoolArray, *, heard: IntArray, contacts: IntArray
) -> dict[str, float]:
    """Return the measures that need a perceived fire."""
    steps, agents = warned.shape
    told, direct = int(cascade.told.sum()), int(cascade.direct.sum())
    traced = spread(perceived_at, heard) < perceived_at
    reachable = spread(perceived_at, contacts) < perceived_at
    edges = int((cascade.parent != _NOBODY).sum())
    times, observed = survival_times(perceived_at, cascade, steps)
    return {
        "informed_fraction": (told + direct) / agents,
        "social_reach": ratio(told, agents - direct),
        "traced_reach": _share_reached(traced, perceived_at),
        "oracle_reach": _share_reached(reachable, perceived_at),
        "normalised_reach": ratio(int(traced.sum()), int(reachable.sum())),
        "relay_probability": relay_probability(cascade, warned),
        "reproduction": ratio(edges, told + direct),
        "depth": float(depth(cascade)),
        "trees": float(trees(cascade)),
        "rmst": restricted_mean(times, observed, steps) if direct < agents else math.nan,
    }


def _share_reached(reached: BoolArray, perceived_at: IntArray) -> float:
    """Return the reached agents over those that did not perceive a fire first."""
    first_hand = (perceived_at < NEVER) & ~reached
    return ratio(int(reached.sum()), int((~first_hand).sum()))


def first_step(flags: BoolArray) -> IntArray:
    """Return the 1-based step at which each agent's flag is first set, or NEVER; flags (T, N), result (N,)."""
    return np.where(flags.any(axis=0), flags.argmax(axis=0) + 1, NEVER)


def _informed(perceived_at: IntArray, heard_at: IntArray, steps: int) -> BoolArray:
    """Return whether an agent had a ground to warn when it spoke at a step, (T, N)."""
    step = np.arange(1, steps + 1)[:, None]
    return (perceived_at <= step) | (heard_at < step)


def trace(perceived_at: IntArray, warned_at: IntArray, heard: IntArray) -> Cascade:
    """Return who learnt how.

    Args:
        perceived_at: step at which each agent first perceives a fire, or NEVER, (N,).
        warned_at: step at which each agent first sends a warning, or NEVER, (N,).
        heard: rows (step, sender, recipient) of delivered warnings, (M, 3).
    """
    told_at = np.full(len(perceived_at), NEVER)
    sender = np.full(len(perceived_at), _NOBODY)
    for step, source, recipient in sorted(heard.tolist()):
        if told_at[recipient] == NEVER:
            told_at[recipient], sender[recipient] = step, source
    told = told_at < perceived_at
    return Cascade(
        direct=(perceived_at < NEVER) & ~told,
        told=told,
        told_at=told_at,
        parent=np.where(told & (warned_at > told_at), sender, _NOBODY),
    )


def spread(perceived_at: IntArray, links: IntArray) -> IntArray:
    """Return when each agent is first reached if all that know use all links.

    Args:
        perceived_at: step from which each agent knows by itself, or NEVER, (N,).
        links: rows (step, from, to), (K, 3); one link a step, since what is heard is passed on a step later.

    Returns:
        Step at which news first arrives over a link, or NEVER, (N,).
    """
    reached = np.full(len(perceived_at), NEVER)
    for step in np.unique(links[:, 0]).tolist():
        _, source, target = links[links[:, 0] == step].T
        knows = (perceived_at <= step) | (reached < step)
        arrived = target[knows[source]]
        reached[arrived] = np.minimum(reached[arrived], step)
    return reached


def relay_probability(cascade: Cascade, warned: BoolArray) -> float:
    """Return the share of told agents that warn within RELAY_WITHIN steps; warned (T, N)."""
    relays = [
        bool(warned[cascade.told_at[agent] : cascade.told_at[agent] + RELAY_WITHIN, agent].any())
        for agent in np.flatnonzero(cascade.told)
    ]
    return mean(relays)


def depth(cascade: Cascade) -> int:
    """Return the number of edges on the longest path of the forest."""
    depths = np.zeros(len(cascade.parent), dtype=np.int64)
    # A parent with an edge into it was told earlier, so its depth is final before its children's.
    for agent in np.argsort(cascade.told_at, kind="stable"):
        if cascade.parent[agent] != _NOBODY:
            depths[agent] = depths[cascade.parent[agent]] + 1
    return int(depths.max(initial=0))


def trees(cascade: Cascade) -> int:
    """Return the number of trees with two agents or more."""
    parents = set(cascade.parent[cascade.parent != _NOBODY].tolist())
    return sum(cascade.parent[agent] == _NOBODY for agent in parents)


def survival_times(perceived_at: IntArray, cascade: Cascade, steps: int) -> tuple[IntArray, BoolArray]:
    """Return how long each agent was waited for, steps, and whether it was told then, (N,) each."""
    waited = np.where(cascade.told, cascade.told_at, np.where(cascade.direct, perceived_at - 1, steps))
    return waited, cascade.told


def survival(times: IntArray, observed: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return the event times and the Kaplan-Meier estimate from each on; events precede censorings at ties."""
    events: IntArray = np.unique(times[observed])
    factors = [1 - (observed & (times == event)).sum() / (times >= event).sum() for event in events]
    remaining: FloatArray = np.multiply.accumulate(np.array(factors, dtype=np.float64))
    return events, remaining


def restricted_mean(times: IntArray, observed: BoolArray, horizon: int) -> float:
    """Return the area under the Kaplan-Meier curve from 0 to the horizon, steps; times, observed (N,)."""
    events, remaining = survival(times, observed)
    edges = np.concatenate(([0], events, [horizon]))
    return float((np.diff(edges) * np.concatenate(([1.0], remaining))).sum())
