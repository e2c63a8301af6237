"""Converts decisions of any form to arrays."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import OUTCOMES, FloatArray, IntArray, TextArray
from analysis.lines import MESSAGES, STEPS, read_agents
from foundry.declared import Actions, Declared
from foundry.errors import RecordError
from foundry.records import Agent, Message
from foundry.storing.store import RunFolder

COMMON = ("step", "agent", "kind", "action", "outcome", "utility", "message")
"""The keys that a decision has in every form, with the same meaning."""

UNNAMED = "action"
"""The kind that every decision gets if its world names no kinds."""

MOST_AGENTS = 1_000_000
"""Maximum number of agents; without this limit, a damaged id in a record could fill the memory."""

_OUTCOME = {outcome: index for index, outcome in enumerate(OUTCOMES)}

Action: TypeAlias = str | int | float | None


def any_run(
    folder: RunFolder, declared: Declared, decisions: Mapping[str, Sequence[Any]], messages: Sequence[Message]
) -> AnyRun:
    """Return a complete run as arrays.

    Args:
        folder: the run.
        declared: the world's record schema.
        decisions: values of the decisions by key, for the keys COMMON; None where a line lacks the key.
        messages: the delivered messages.

    Raises:
        RecordError: a decision does not fit the world's schema, or the steps are not in order.
    """
    file, summary = folder.path / STEPS, folder.summary()
    kinds = [_kind_of(declared, kind, file) for kind in decisions["kind"]]
    _check_actions(declared, kinds, decisions["action"], file)
    step = np.array(decisions["step"], dtype=np.int64)
    if (np.diff(step) < 0).any():
        raise RecordError(f"{file}: the steps are not in ascending order.")
    deliveries, agent = _deliveries(folder, messages), np.array(decisions["agent"], dtype=np.int64)
    personas = _personas(
        folder, read_agents(folder, summary), max(agent.max(initial=-1), deliveries[:, 1:].max(initial=-1))
    )
    return AnyRun(
        id=folder.id,
        declared=declared,
        step=step,
        agent=agent,
        kind=objects(kinds),
        action=objects(decision if isinstance(decision, str) else None for decision in decisions["action"]),
        number=_numbers(None if isinstance(decision, str) else decision for decision in decisions["action"]),
        outcome=np.array([_OUTCOME[decision] for decision in decisions["outcome"]], dtype=np.int64),
        utility=_numbers(decisions["utility"]),
        said=objects(decisions["message"]),
        deliveries=deliveries,
        agents=len(personas),
        personas=personas,
        totals=None if summary is None else summary.counts,
        wall_s=math.nan if summary is None else summary.duration_s,
        world=folder.config().get("world", {}),
    )


def _kind_of(declared: Declared, kind: str | None, file: Path) -> str:
    if kind is not None:
        return kind
    if len(declared.actions) > 1:
        raise RecordError(
            f"{file}: a decision has no `kind`, but the world declares several: {', '.join(declared.actions)}."
        )
    return next(iter(declared.actions), UNNAMED)


def _check_actions(declared: Declared, kinds: Sequence[str], actions: Sequence[Action], file: Path) -> None:
    """Raise an error for an action that the world does not declare; a world without declared actions allows any."""
    if not declared.actions:
        return
    lines = dict(zip(reversed(list(zip(kinds, actions, strict=True))), range(len(kinds), 0, -1), strict=True))
    for (kind, action), line in lines.items():
        declared_actions = declared.actions.get(kind)
        wrong = (
            f"the world declares no kind '{kind}'" if declared_actions is None else _refused(declared_actions, action)
        )
        if action is not None and wrong:
            raise RecordError(f"{file}, line {line}: {action!r} is not an action of its world: {wrong}.")


def _refused(declared: Actions, action: Action) -> str:
    """Return why an action is not among the declared ones, or an empty text if it is."""
    if declared.labels:
        return "" if action in declared.labels else f"the declared actions are {', '.join(declared.labels)}"
    if isinstance(action, str | None):
        return "it must be a number"
    if declared.whole and action != int(action):
        return "it must be a whole number"
    low, high = declared.low, declared.high
    is_in = (low is None or action >= low) and (high is None or action <= high)
    ends = ("any" if bound is None else f"{bound:g}" for bound in (low, high))
    return "" if is_in else f"the number must be within {'..'.join(ends)}"


def _deliveries(folder: RunFolder, messages: Sequence[Message]) -> IntArray:
    _check_ids(folder.path / MESSAGES, (agent for line in messages for agent in (line.sender, line.recipient)))
    try:
        rows = np.array([(line.step, line.sender, line.recipient) for line in messages], dtype=np.int64)
    except OverflowError as error:
        raise RecordError(f"{folder.path / MESSAGES} holds a step that does not fit into 64 bits: {error}") from error
    return rows.reshape(-1, 3)


def _personas(folder: RunFolder, recorded: Sequence[Agent], greatest: int) -> tuple[Mapping[str, str], ...]:
    """Return the persona of each agent, by id, up to the greatest id in personas, decisions or messages."""
    _check_ids(folder.path, (line.agent for line in recorded))
    personas = {line.agent: line.persona for line in recorded}
    return tuple(personas.get(agent, {}) for agent in range(max([int(greatest), *personas]) + 1))


def _check_ids(file: Path, ids: Iterable[int]) -> None:
    wrong = [token for token in ids if not 0 <= token < MOST_AGENTS]
    if wrong:
        raise RecordError(f"{file} names agent {wrong[0]}, but ids must be from 0 to {MOST_AGENTS - 1}.")


def objects(values: Iterable[Any]) -> TextArray:
    """Return values of any type as an object array."""
    items = list(values)
    return np.fromiter(items, dtype=np.object_, count=len(items))


def _numbers(values: Iterable[float | None]) -> FloatArray:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
