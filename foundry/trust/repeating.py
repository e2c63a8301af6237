"""Makes recorded calls again at the end of a sweep, one by one and under load: whether its servers repeat themselves.

Nothing of it is behaviour: no answer cache is read or written, and the records of runs stay as they are.
"""

from __future__ import annotations

import asyncio
import datetime
import logging
from collections.abc import Callable, Coroutine, Mapping, Sequence
from typing import Any, TypeVar

from foundry.expansion import sent_key, settings_key
from foundry.models.base import Model, Reply
from foundry.models.serving import serving_of
from foundry.models.wrappers.retried import RetriedModel
from foundry.records import RunSummary
from foundry.running.build import build, served_by_others
from foundry.running.load import at_once, one_by_one
from foundry.storing.determinism import (
    Again,
    Budget,
    Repeat,
    Repeats,
    answered_calls,
    claim_repeats,
    is_measured,
    repeats_of,
    write_repeats,
)
from foundry.storing.store import RunFolder, SweepFolder
from foundry.texts import visible, without_secrets
from foundry.trust.repeated_calls import Repeatable, decides_alike, decision_of, draw
from foundry.worlds.base import Scenario

LOOK_EVERY_S = 0.1
"""So often it is looked whether the sweep is to stop."""
T = TypeVar("T")


def repeat_calls(
    folder: SweepFolder, setting: int | str, model: Mapping[str, Any], in_flight: int, stopping: Callable[[], bool]
) -> None:
    """Make calls of a served model again and keep what came of them, unless that was done or a run of it is missing.

    What goes wrong is told in one line and changes nothing else.

    Args:
        folder: the sweep.
        setting: how many calls of each model, as `Budget.of` reads it.
        model: its configuration; of a population each member is measured that a server answers for.
        in_flight: calls that were allowed in flight at once when it was asked; 0 where that is not known.
        stopping: says whether the sweep is to stop.
    """
    of = str(model["name"])
    served = served_by_others(build(model))
    left = [member for member in served if not _is_known(folder, of, member)]
    live = _live_runs(folder, sent_key(model)) if left else {}
    calls = sum(answered_calls(summary, {member.name for member in served}) for summary in live.values())
    for member in left if live else ():
        bounds = serving_of(member).in_flight
        budget = Budget.of(setting, calls // len(served), min(in_flight or bounds.initial, bounds.max))
        try:
            with claim_repeats(folder) as mine:
                if mine and not _is_known(folder, of, member):
                    _repeat_of_member(folder, list(live), member, of, budget=budget, stopping=stopping)
        except Exception as error:  # noqa: BLE001 - the boundary: a backend or world of one's own may raise anything
            cause = without_secrets(" ".join(str(error).split())) or type(error).__name__
            _log("%s: determinism not measured: %s", visible(member.name), visible(cause))


def _is_known(folder: SweepFolder, of: str, member: Model) -> bool:
    return is_measured(repeats_of(folder), of, member.name, member.parameters())


def _live_runs(folder: SweepFolder, key: str) -> dict[RunFolder, RunSummary]:
    """Return the runs of a model in which its server answered; none where not all of its runs are complete."""
    asked = {number for number, one in enumerate(folder.sweep.conditions) if sent_key(one.config["model"]) == key}
    runs = [(run, run.summary()) for run in folder.runs() if run.run.condition in asked]
    if not all(summary is not None and summary.status == "complete" for _, summary in runs):
        return {}
    summaries = {run: summary for run, summary in runs if summary is not None}
    return {run: one for run, one in summaries.items() if one.counts.calls > one.counts.cached}


def _repeat_of_member(
    folder: SweepFolder,
    runs: Sequence[RunFolder],
    member: Model,
    of: str,
    *,
    budget: Budget,
    stopping: Callable[[], bool],
) -> None:
    together = budget.again + budget.beside
    drawn = draw(runs, member, together, most_runs=budget.again)
    calls, others = drawn[: budget.again], drawn[budget.again : together]
    if not calls:
        return
    said = "%s: making %d recorded calls again, alone, then with %d others at once (determinism=0 leaves it out)"
    _log(said, visible(member.name), len(calls), len(others))
    replies = asyncio.run(_unless_stopped(_asked(member, calls, others), stopping))
    if replies is None:
        return
    found = Repeats(
        model=member.name,
        of=of,
        parameters=calls[0].call.parameters,
        measured=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        at_once=len(calls) + len(others),
        calls=_compared(calls, *replies),
    )
    write_repeats(folder, [*repeats_of(folder), found])


def _log(text: str, *values: object) -> None:
    logging.getLogger("foundry").warning(text, *values)


async def _asked(
    member: Model, calls: Sequence[Repeatable], others: Sequence[Repeatable]
) -> tuple[list[Reply], list[Reply]]:
    """Return the replies to calls, made one by one and then together with others.

    Raises:
        BackendError: the server gave no answer.
    """
    model = RetriedModel.as_set(serving_of(member).retry, member)
    try:
        await model.warm_up()
        alone = await one_by_one(model, [one.request for one in calls])
        loaded = await at_once(model, [one.request for one in (*calls, *others)])
    finally:
        await model.close()
    return [one.reply for one in alone], [one.reply for one in loaded[: len(calls)]]


async def _unless_stopped(work: Coroutine[Any, Any, T], stopping: Callable[[], bool]) -> T | None:
    """Return what some work gives, or None where the sweep was to stop before."""
    task = asyncio.ensure_future(work)
    while not task.done():
        await asyncio.wait({task}, timeout=LOOK_EVERY_S)
        if stopping():
            task.cancel()
    return None if task.cancelled() else task.result()


def _compared(calls: Sequence[Repeatable], alone: Sequence[Reply], loaded: Sequence[Reply]) -> tuple[Repeat, ...]:
    scenarios: dict[str, Scenario] = {}
    return tuple(
        Repeat(
            run=one.run.id,
            step=one.call.step,
            agent=one.call.agent,
            kind=one.call.kind,
            alone=_again(one, scenarios, by_itself),
            loaded=_again(one, scenarios, among_many),
        )
        for one, by_itself, among_many in zip(calls, alone, loaded, strict=True)
    )


def _again(one: Repeatable, scenarios: dict[str, Scenario], reply: Reply) -> Again:
    """Return what came of a call; worlds are built where they are needed, and once."""
    recorded = decision_of(one)
    if (reply.text, reply.ending) == (one.call.text, one.call.ending):
        return Again(alike=None if recorded is None else True)
    if recorded is None:
        return Again(text=reply.text)
    world = one.run.config()["world"]
    key = settings_key(world)
    scenarios[key] = scenarios[key] if key in scenarios else build(world)
    return Again(text=reply.text, alike=decides_alike(one, recorded, scenarios[key], reply))
