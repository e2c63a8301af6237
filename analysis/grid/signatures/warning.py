"""Warnings: how far news of a fire travels by messages.

A labeller decides which messages are warnings: the rule in `warning_rule`, or a model (`foundry label`). The module
`grid.cascade` says in which order agents perceive, speak and hear within a step.
"""

import math

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.formulas import mean, ratio, restricted_mean
from analysis.grid.cascade import NEVER, NOBODY, Cascade, Relays, find_relays, first_step, spread, trace
from analysis.grid.grid_run import GridRun
from analysis.labelling.correcting import Correction, corrected_mean
from analysis.labelling.warning_rule import is_warning
from analysis.measure import Measure, Null, share
from foundry import seeding
from foundry.labels.definition import Label
from foundry.labels.items import first_aware

NAME = "warning"
QUESTION = "message"

_SIGHT = "warns only of fires in its own sight"

MEASURES = {
    "informed_fraction": share("Informed agents (share)"),
    "social_reach": share(
        "Told of a fire before seeing one (share of agents that did not see it first)",
        says="warns its neighbours {more|less}",
    ),
    "traced_reach": share("Told by a chain of warnings from an agent that saw a fire (share)"),
    "oracle_reach": share("Told if all agents always passed news on (share)"),
    "normalised_reach": share("Told / told if all agents always passed news on"),
    "relay_probability": share(
        "Warned others after being told (share of told agents)",
        Null(0, _SIGHT),
        says="passes warnings on {more|less} often",
    ),
    "relay_above_chance": Measure(
        "Warned others after being told, minus its mean for shifted labels (share)",
        -1,
        1,
        Null(0, "warns at any rate, without regard to messages it hears"),
    ),
    "reproduction": share("Agents told per informed agent (R)"),
    "depth": Measure("Longest chain of warnings", low=0),
    "trees": Measure("Separate chains of warnings", low=0),
    "virality": Measure("Distance within a chain of warnings (structural virality)", low=1),
    "rmst": Measure("Mean time to the first warning (steps, restricted)", low=0),
    "false_alarm_rate": share(
        "False alarms (share of messages)", Null(0, _SIGHT), says="gives false alarms {more|less} often"
    ),
    "warning_share": share("Warnings (share of messages)"),
    "unknown": share("Messages without a label (share)"),
}

HEADLINE = ("social_reach", "relay_probability", "false_alarm_rate")

LABEL = "warning"
"""The name of the label from which the measures are computed."""
UNLABELLED = ("oracle_reach", "unknown")

COPIED = (
    "informed_fraction", "social_reach", "traced_reach", "normalised_reach", "reproduction", "depth", "trees",
    "virality", "rmst", "false_alarm_rate",
)  # fmt: skip
"""Measures that foundry computes on copies of a run and then averages, to correct them by people's labels.

In each copy, every message that nobody labelled gets a random label.
"""

RELAY_WITHIN = 5
"""An agent relays a warning if it warns others at most this number of steps after it was told."""

SHUFFLES = 100
"""Number of times that labels are shifted in time at random, to compute `relay_above_chance`."""


def measure(run: GridRun) -> dict[str, float]:
    """Return how far warnings of a fire travel among the agents of a run.

    An agent is *told* if it receives a warning before the step of its first perception of a fire, or if it never
    perceives one. An agent is *direct* if it perceives a fire and is not told. An agent is *informed* if it is *told*
    or *direct*.

    - informed_fraction: informed agents / N; 0..1.
    - social_reach: told agents / (N - direct agents); 0..1. NaN if all are direct.
    - traced_reach: social_reach, counting only warnings that are traced to a perceived fire. The sender of a traced
      warning has perceived a fire by then, or has received a traced warning at an earlier step. Without false alarms it
      equals social_reach.
    - oracle_reach: social_reach if every agent that has news told all its recorded neighbours at every step; an upper
      bound for the agents' actual paths.
    - normalised_reach: agents told by traced warnings / agents told under the oracle; 0..1. NaN if the oracle reaches
      nobody. A low normalised_reach means that agents did not pass news on to agents near them.
    - relay_probability: told agents that send a warning within RELAY_WITHIN steps after being told / told agents that
      decided on a message in these steps; 0..1. As soon as an agent perceives a fire, its
      steps do not count, because it may then warn of what it sees. NaN without such agents.
    - relay_above_chance: relay_probability minus its mean over SHUFFLES shifts of the labels; -1..1. A shift moves the
      labels of an agent's messages in time, in a circle; messages before and after its first sight of a fire are
      shifted separately. So an agent that warns often, or several times in a row, still does so after a shift. After
      each shift, it is determined again which agents were told. The measure is 0 if being warned does not make a
      warning more likely. The measure is also 0 if all messages of each agent are warnings, because a shift changes
      nothing then. NaN where relay_probability is NaN.
    - reproduction: R, edges / informed agents; 0..1. An edge leads from the sender of an agent's first warning (lowest
      step, then lowest id) to that agent, if the agent is told and had sent no warning before. Otherwise the agent
      begins a new chain. So the edges form trees (a forest).
    - depth: edges on the longest path of the forest; 0..N-1.
    - trees: trees of the forest with two agents or more.
    - virality: mean distance over the pairs of agents of a tree, averaged over the trees with two agents or more;
      1..(N+1)/3, at least 1. NaN without such trees.
    - rmst: restricted mean time to the first warning, steps; 0..T. rmst is the area under the Kaplan-Meier curve of
      `waiting_times` from the run's start to T; after the last event the curve stays level. NaN if all are direct.
    - false_alarm_rate: warnings whose sender has perceived no fire by then and received no earlier warning / messages;
      0..1. NaN without messages.
    - warning_share: warnings / messages; 0..1. NaN without messages.
    - unknown: messages without a label / messages; 0..1. NaN without messages.

    All measures but the last two are NaN if no agent perceives a fire, for example in a world without fires. A
    perceived fire that is never passed on gives a reach, R and depth of 0.

    Messages without a label, such as texts in neither English nor Japanese, are left out of both parts of
    false_alarm_rate and warning_share. All other measures are computed twice, once with these messages as warnings and
    once with none of them, and are NaN if the two values differ. If only readable decisions count, messages of other
    decisions count as not said.

    Denominators: n_agents, n_direct, n_told, n_reachable, n_chances (of relays), n_warnings (labelled), n_messages,
    n_unlabelled (messages). Source: Goel et al. 2015 for the forest and virality; Kaplan and Meier 1958.
    """
    said = run.spoke & run.message_counted
    warned, labelled = find_labels(run)
    unknown = said & ~labelled
    measures = _measure(run, said & warned, said & labelled)
    if unknown.any():
        other = _measure(run, said & (warned | ~labelled), said & labelled)
        measures = {name: value if value == other[name] else math.nan for name, value in measures.items()}
    counts = {"n_messages": float(said.sum()), "n_unlabelled": float(unknown.sum())}
    return measures | counts | {"unknown": ratio(int(unknown.sum()), int(said.sum()))}


def correct(run: GridRun, correction: Correction) -> dict[str, FloatArray]:
    """Return by name the measures that labels by people correct.

    A measure has one value, (1,), or one value per copy of the run, (COPIES,).

    The share of warnings is a mean of labels and is corrected directly. Measures of chains and false alarms are
    computed on copies of the run, in which messages that nobody labelled get random labels. Relaying has no correction:
    a copy draws each label independently, which would hide part of any difference in relaying
    (`benchmarks/label_correction.py`).
    """
    said, reachable = run.spoke & run.message_counted, _reachable(run)
    by_copy: list[dict[str, float]] = []
    for copy in labels_of_copies(run, correction):
        labels = np.zeros(said.shape, dtype=np.bool_)
        labels[said] = copy
        by_copy.append(_of_chains(run, labels, said, reachable))
    return {
        "warning_share": np.array([corrected_share(run, correction)]),
        **{name: np.array([values[name] for values in by_copy]) for name in COPIED},
    }


def corrected_share(run: GridRun, correction: Correction) -> float:
    """Return the share of warnings, corrected by people's labels; NaN without messages."""
    said = run.spoke & run.message_counted
    warned, _ = find_labels(run)
    truth, weight = np.full(said.shape, math.nan), np.ones(said.shape)
    for labelled in correction.by_run.get(run.id, ()):
        decision = labelled.step - 1, labelled.agent
        truth[decision] = labelled.shares.get(correction.label.choices[0], 0.0)
        weight[decision] = labelled.weight
    return corrected_mean(warned[said].astype(np.float64), truth[said], weight[said])


def labels_of_copies(run: GridRun, correction: Correction) -> BoolArray:
    """Return, for each copy of the run, which of the M counted messages are warnings, (COPIES, M)."""
    said = run.spoke & run.message_counted
    aware = knows_of_a_fire(run, correction.label)
    messages = list(zip(run.said[said].tolist(), aware[said].tolist(), strict=True))
    distinct = sorted(set(messages))
    copies = correction.copies(run.id, [(text, _context(run), knows) for text, knows in distinct])
    number = {message: place for place, message in enumerate(distinct)}
    return copies[:, np.array([number[message] for message in messages], dtype=np.int64)]


def knows_of_a_fire(run: GridRun, label: Label) -> BoolArray:
    """Return whether each agent knows of a fire when it speaks: it saw one, or heard of one by the rule, (T, N)."""
    sighted = ((step + 1, agent) for step, agent in np.argwhere(run.perceived).tolist())
    heard = ((step, recipient, run.said[step - 1, sender]) for step, sender, recipient in run.deliveries.tolist())
    aware_from = np.full(run.agents, NEVER)
    for agent, step in first_aware(label, _context(run), sighted, heard).items():
        aware_from[agent] = step
    return np.arange(1, run.steps + 1)[:, None] >= aware_from


def _context(run: GridRun) -> dict[str, tuple[str, ...]]:
    return {"fires": tuple(fire.name for fire in run.world.fires)}


def find_labels(run: GridRun) -> tuple[BoolArray, BoolArray]:
    """Return which messages are warnings, and which have a label, (T, N) each; silence is not a warning."""
    texts = set(run.said[run.spoke].tolist())
    labels = run.labels
    if labels is None:
        fires = tuple(fire.name for fire in run.world.fires)
        by_rule = {text: is_warning(text, fires) for text in texts}
        labels = {text: label for text, label in by_rule.items() if label is not None}
    said = run.said.ravel().tolist()
    warned = np.array([labels.get(text, False) for text in said], dtype=np.bool_)
    labelled = np.array([text is None or text in labels for text in said], dtype=np.bool_)
    return warned.reshape(run.said.shape), labelled.reshape(run.said.shape)


def waiting_times(run: GridRun, warned: BoolArray) -> tuple[IntArray, BoolArray]:
    """Return the step of each agent's first warning, or of its censoring, and whether a warning came, (N,) each.

    An agent that perceives a fire at step d before any warning is censored at d - 1. An agent without fire and warning
    is censored at its last step. `warned` is (T, N), as from `find_labels`.
    """
    perceived_at = first_step(run.perceived)
    return _waited(perceived_at, trace(perceived_at, first_step(warned), deliveries_of(run, warned)), run.last)


def _waited(perceived_at: IntArray, cascade: Cascade, last: IntArray) -> tuple[IntArray, BoolArray]:
    waited = np.where(cascade.told, cascade.told_at, np.where(cascade.direct, perceived_at - 1, last))
    return waited, cascade.told


def deliveries_of(run: GridRun, warned: BoolArray) -> IntArray:
    """Return the deliveries of warnings, (K, 3): rows (step, sender, recipient); warned is (T, N)."""
    return run.deliveries[warned[run.deliveries[:, 0] - 1, run.deliveries[:, 1]]]


def _measure(run: GridRun, warned: BoolArray, labelled: BoolArray) -> dict[str, float]:
    """Return the measures of a run.

    Args:
        run: the run.
        warned: whether an agent's message was a warning, (T, N).
        labelled: whether it has a label; denominators count only messages with a label, (T, N).
    """
    perceived_at = first_step(run.perceived)
    relays = _relays(run, warned, perceived_at)
    if not (perceived_at < NEVER).any():
        relays |= dict.fromkeys(("relay_probability", "relay_above_chance"), math.nan)
    return relays | _of_chains(run, warned, labelled, _reachable(run))


def _reachable(run: GridRun) -> BoolArray:
    """Return which agents would hear of a fire before they see one if all agents always passed news on, (N,)."""
    perceived_at = first_step(run.perceived)
    return spread(perceived_at, run.contacts) < perceived_at


def _of_chains(run: GridRun, warned: BoolArray, labelled: BoolArray, reachable: BoolArray) -> dict[str, float]:
    """Return all measures except the relay measures; the arguments are as in `_measure` and `_reachable`."""
    perceived_at, heard = first_step(run.perceived), deliveries_of(run, warned)
    cascade = trace(perceived_at, first_step(warned), heard)
    traced = spread(perceived_at, heard) < perceived_at
    measures = _reach(run, cascade, perceived_at, traced=traced, reachable=reachable)
    if not (perceived_at < NEVER).any():
        measures = dict.fromkeys(measures, math.nan)
    grounded = _informed(perceived_at, cascade.told_at, run.steps)
    return measures | {
        "false_alarm_rate": ratio(int((warned & labelled & ~grounded).sum()), int(labelled.sum())),
        "warning_share": ratio(int((warned & labelled).sum()), int(labelled.sum())),
        "n_agents": float(run.agents),
        "n_direct": float(cascade.direct.sum()),
        "n_told": float(cascade.told.sum()),
        "n_reachable": float(reachable.sum()),
        "n_warnings": float((warned & labelled).sum()),
    }


def _reach(
    run: GridRun, cascade: Cascade, perceived_at: IntArray, *, traced: BoolArray, reachable: BoolArray
) -> dict[str, float]:
    """Return how far the news of a fire got, as measures that are defined only if an agent perceives a fire."""
    warned_agents, direct = int(cascade.told.sum()), int(cascade.direct.sum())
    waited, observed = _waited(perceived_at, cascade, run.last)
    return {
        "informed_fraction": (warned_agents + direct) / run.agents,
        "social_reach": ratio(warned_agents, run.agents - direct),
        "traced_reach": _share_reached(traced, perceived_at),
        "oracle_reach": _share_reached(reachable, perceived_at),
        "normalised_reach": ratio(int(traced.sum()), int(reachable.sum())),
        "reproduction": ratio(cascade.edges, warned_agents + direct),
        "depth": float(cascade.depth),
        "trees": float(cascade.trees),
        "virality": cascade.virality,
        "rmst": restricted_mean(waited, observed, run.steps) if direct < run.agents else math.nan,
    }


def _share_reached(reached: BoolArray, perceived_at: IntArray) -> float:
    """Return the agents that news reached, divided by all agents except those that perceived a fire before any news."""
    first_hand = (perceived_at < NEVER) & ~reached
    return ratio(int(reached.sum()), int((~first_hand).sum()))


def _informed(perceived_at: IntArray, heard_at: IntArray, steps: int) -> BoolArray:
    """Return whether each agent knew of a fire when it spoke at each step, (T, N)."""
    step = np.arange(1, steps + 1)[:, None]
    return (perceived_at <= step) | (heard_at < step)


def _relays(run: GridRun, warned: BoolArray, perceived_at: IntArray) -> dict[str, float]:
    """Return how often warnings are relayed: with the actual labels, and minus the mean over shifted labels."""
    said = run.spoke & run.message_counted
    step, agent = np.nonzero(said)
    periods = 2 * agent + (step + 1 >= perceived_at[agent])
    relays = relays_of(run, _with_shifts(warned[said], periods))
    chance = relays.shares[1:]
    relayed = float(relays.shares[0])
    return {
        "relay_probability": relayed,
        "relay_above_chance": relayed - mean(chance[~np.isnan(chance)].tolist()),
        "n_chances": float(relays.could[0]),
    }


def relays_of(run: GridRun, labels: BoolArray) -> Relays:
    """Return how many agents passed warnings on, for S ways of labelling the M counted messages, (S, M)."""
    said = run.spoke & run.message_counted
    warned = np.zeros((len(labels), *said.shape), dtype=np.bool_)
    warned[:, said] = labels
    told_at = _first_warned_at(run, said, labels)
    return find_relays(warned, told_at, first_step(run.perceived), able=run.message_counted, within=RELAY_WITHIN)


def _with_shifts(labels: BoolArray, periods: IntArray) -> BoolArray:
    """Return the labels of M messages, then SHUFFLES shifts of these labels in time, (1 + SHUFFLES, M).

    Args:
        labels: labels of the messages by step, then agent, (M,).
        periods: number of the period of each message, (M,); labels are shifted within a period: the messages of an
            agent before it saw a fire, or after it.
    """
    rows, rng = np.tile(labels, (1 + SHUFFLES, 1)), seeding.stream(0, "labels of messages")
    for period in np.unique(periods):
        own = np.flatnonzero(periods == period)
        shifts = rng.integers(len(own), size=SHUFFLES)
        if labels[own].any():  # a shift of messages of which none is a warning changes nothing
            rows[1:, own] = labels[own[(np.arange(len(own)) - shifts[:, None]) % len(own)]]
    return rows


def _first_warned_at(run: GridRun, said: BoolArray, labels: BoolArray) -> IntArray:
    """Return the step at which each agent first hears a warning, or NEVER, for S ways of labelling messages, (S, N).

    Args:
        run: the run.
        said: which agents sent a message that has a label, (T, N); M in all.
        labels: whether each message is a warning, by labelling, (S, M).
    """
    number = np.full(said.shape, NOBODY)
    number[said] = np.arange(labels.shape[1])
    rows = run.deliveries[np.argsort(run.deliveries[:, 2], kind="stable")]
    rows = rows[number[rows[:, 0] - 1, rows[:, 1]] != NOBODY]
    told_at = np.full((len(labels), run.agents), NEVER)
    recipients, starts = np.unique(rows[:, 2], return_index=True)
    if len(recipients):
        heard = np.where(labels[:, number[rows[:, 0] - 1, rows[:, 1]]], rows[:, 0], NEVER)
        told_at[:, recipients] = np.minimum.reduceat(heard, starts, axis=1)
    return told_at
