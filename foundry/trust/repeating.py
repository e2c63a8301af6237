"""Checks whether servers are deterministic: repeats some recorded calls at the end of a sweep, alone and under load.

The repeated calls use no answer cache and do not change the records of runs.
"""

import asyncio
import datetime
import itertools
import logging
from collections.abc import Callable, Coroutine, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import msgspec

from foundry import seeding
from foundry.episode import answer_of
from foundry.expansion import sent_key, settings_key
from foundry.models.base import ChatMessage, Model, Reply, Request, RequestKeys
from foundry.models.serving import serving_of
from foundry.models.wrappers.retried import RetriedModel
from foundry.records import Call, RunSummary
from foundry.running.build import build, served_by_others
from foundry.running.load import at_once, one_by_one
from foundry.running.replayed import reply_of
from foundry.storing.determinism import (
    Budget,
    Repeat,
    RepeatResult,
    Repeats,
    answered_calls,
    is_measured,
    repeats_of,
    write_repeats,
)
from foundry.storing.matching import place_of
from foundry.storing.run_files import claimed, sha256_of
from foundry.storing.store import IMAGES, RunFolder, SweepFolder, lines_of, stored_picture
from foundry.texts import one_line, visible, without_secrets
from foundry.worlds.base import Scenario
from foundry.worlds.compared import Line, compared_of

LOOK_EVERY_S = 0.1
"""Time between two checks whether the sweep must stop, seconds."""
STREAM = "determinism"
"""The name of the random stream that draws the calls to repeat."""
T = TypeVar("T")


@dataclass(frozen=True)
class Repeatable:
    """A recorded call that can be repeated; `number` is its index in the run's log of calls, from 0."""

    run: RunFolder
    number: int
    call: Call
    request: Request


def repeat_calls(
    folder: SweepFolder, setting: int | str, model: Mapping[str, Any], in_flight: int, stopping: Callable[[], bool]
) -> None:
    """Repeat calls of a served model and record the results, unless that was done before or a run is not complete.

    An error is only logged.
    """
    of, served = str(model["name"]), served_by_others(build(model))

    def is_known(member: Model) -> bool:
        return is_measured(repeats_of(folder), of, member.name, member.parameters())

    left = [member for member in served if not is_known(member)]
    live = _live_runs(folder, sent_key(model)) if left else {}
    calls = sum(answered_calls(summary, {member.name for member in served}) for summary in live.values())
    for member in left if live else ():
        bounds = serving_of(member).in_flight
        budget = Budget.of(setting, calls // len(served), min(in_flight or bounds.initial, bounds.max))
        try:
            with claimed(folder.path / "locks" / "determinism.lock") as is_ours:  # several commands may run a sweep
                if (
                    is_ours
                    and not is_known(member)
                    and (repeats := _measured(list(live), member, of, budget, stopping))
                ):
                    write_repeats(folder, [*repeats_of(folder), repeats])
        except Exception as error:  # noqa: BLE001 - the boundary: a backend or world of one's own may raise anything
            cause = without_secrets(one_line(error)) or type(error).__name__
            _log("%s: determinism not measured: %s", visible(member.name), visible(cause))


def _live_runs(folder: SweepFolder, key: str) -> dict[RunFolder, RunSummary]:
    """Return the model's runs with calls that went to a server; return none if a run of the model is not complete."""
    conditions = {
        number for number, condition in enumerate(folder.sweep.conditions) if sent_key(condition.config["model"]) == key
    }
    runs = {run: run.summary() for run in folder.runs() if run.run.condition in conditions}
    complete = {run: summary for run, summary in runs.items() if summary is not None and summary.status == "complete"}
    if len(complete) < len(runs):
        return {}
    return {run: summary for run, summary in complete.items() if summary.counts.calls > summary.counts.cached}


def _measured(
    runs: Sequence[RunFolder], member: Model, of: str, budget: Budget, stopping: Callable[[], bool]
) -> Repeats | None:
    """Repeat calls of a model and return the results; None if there are no calls, or if the sweep must stop."""
    together = budget.again + budget.beside
    drawn = _draw(runs, member, together, most_runs=budget.again)
    calls, others = drawn[: budget.again], drawn[budget.again : together]
    if not calls:
        return None
    line = "%s: repeating %d recorded calls alone, then together with %d others (determinism=0 leaves this out)"
    _log(line, visible(member.name), len(calls), len(others))
    replies = asyncio.run(_unless_stopped(_asked(member, calls, others), stopping))
    if replies is None:
        return None
    scenarios: dict[str, Scenario] = {}
    repeats = [
        Repeat(
            run=call.run.id,
            step=call.call.step,
            agent=call.call.agent,
            kind=call.call.kind,
            alone=_again(call, scenarios, alone),
            loaded=_again(call, scenarios, loaded),
        )
        for call, alone, loaded in zip(calls, *replies, strict=True)
    ]
    return Repeats(
        model=member.name,
        of=of,
        parameters=calls[0].call.parameters,
        measured=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        at_once=len(calls) + len(others),
        calls=tuple(repeats),
    )


def _log(text: str, *values: object) -> None:
    logging.getLogger("foundry").warning(text, *values)


async def _asked(
    member: Model, calls: Sequence[Repeatable], others: Sequence[Repeatable]
) -> tuple[list[Reply], list[Reply]]:
    model = RetriedModel(member, serving_of(member).retry)
    try:
        await model.warm_up()
        alone = await one_by_one(model, [call.request for call in calls])
        loaded = await at_once(model, [call.request for call in (*calls, *others)])
    finally:
        await model.close()
    return [timed.reply for timed in alone], [timed.reply for timed in loaded[: len(calls)]]


async def _unless_stopped(work: Coroutine[Any, Any, T], stopping: Callable[[], bool]) -> T | None:
    """Return the result of a coroutine, or None if the sweep must stop before it ends."""
    task = asyncio.ensure_future(work)
    while not task.done():
        await asyncio.wait({task}, timeout=LOOK_EVERY_S)
        if stopping():
            task.cancel()
    return None if task.cancelled() else task.result()


def _draw(runs: Sequence[RunFolder], model: Model, count: int, *, most_runs: int) -> list[Repeatable]:
    """Draw calls that a model's server answered: in turn one of each run, and in turn one of each kind of question."""
    order = seeding.stream(runs[0].run.seed, STREAM).permutation(len(runs))[:most_runs]
    parameters = msgspec.json.decode(msgspec.json.encode(model.parameters()))
    return _in_turn([_of_run(runs[place], model, parameters, count, turn) for turn, place in enumerate(order.tolist())])


def _of_run(run: RunFolder, model: Model, parameters: Mapping[str, Any], count: int, turn: int) -> list[Repeatable]:
    """Draw calls of one run, in turn one of each kind of question; `turn` says which kind comes first."""
    by_kind: dict[str, list[tuple[int, Call]]] = {}
    for number, call in enumerate(run.calls()):
        if not call.cached and call.model == model.name and call.parameters == parameters:
            by_kind.setdefault(call.kind, []).append((number, call))
    rng = seeding.stream(run.run.seed, STREAM)
    drawn = [[mine[place] for place in rng.permutation(len(mine))[:count].tolist()] for mine in by_kind.values()]
    first = turn % max(1, len(drawn))
    calls = _in_turn(drawn[first:] + drawn[:first])
    images = _images(run) if any("images_sha256" in line for _, call in calls for line in call.messages) else {}
    put = [(number, call, _request(call, model, images)) for number, call in calls]
    return [Repeatable(run, number, call, request) for number, call, request in put if request is not None]


def _in_turn(lists: Sequence[Sequence[T]]) -> list[T]:
    rounds = itertools.zip_longest(*([(item,) for item in each] for each in lists), fillvalue=())
    return [item for places in rounds for place in places for item in place]


def _images(run: RunFolder) -> dict[str, bytes]:

    names = [name for name in run.pictures() if name.startswith(f"{IMAGES}/")]
    images = [content for name in names if (content := stored_picture(run.path, name)) is not None]
    return {sha256_of(content): content for content in images}


def _request(call: Call, model: Model, images: Mapping[str, bytes]) -> Request | None:
    """Return the request of a logged call; None if the record is incomplete, for example without its images."""
    messages = tuple(
        ChatMessage(line["role"], line["content"], tuple(images.get(sha, b"") for sha in line.get("images_sha256", ())))
        for line in call.messages
    )
    if RequestKeys(model, call.digest).key(messages, call.seed) != call.key:
        return None
    return Request(messages, call.seed, call.kind, {}, call.step, call.agent, key=call.key)


def _again(repeatable: Repeatable, scenarios: dict[str, Scenario], reply: Reply) -> RepeatResult:
    """Compare the reply to a repeated call with the recorded reply.

    If they differ, the world reads the decision in the new reply: the episode is replayed up to the call, and goes on
    with the new reply. If its questions then differ from the recorded ones, the decision counts as different.
    """
    decision = _decision(repeatable)
    if (reply.text, reply.ending) == (repeatable.call.text, repeatable.call.ending):
        return RepeatResult(alike=None if decision is None else True)
    if decision is None:
        return RepeatResult(text=reply.text)
    world = repeatable.run.config()["world"]
    key = settings_key(world)
    scenarios[key] = scenarios[key] if key in scenarios else build(world)
    recorded, place = decision
    now = next(itertools.islice(_lines_with(repeatable, scenarios[key], reply), place, None), None)
    alike = now is not None and compared_of(scenarios[key].form).acts_alike(recorded, now)
    return RepeatResult(text=reply.text, alike=alike)


def _decision(repeatable: Repeatable) -> tuple[Line, int] | None:
    """Return the recorded line with a call's decision, and the index of this line among all lines of its question.

    The repeats of a probe give several such lines. The result is None if the call decides nothing alone, or if it is
    unknown which line is the call's.
    """
    if repeatable.call.kind not in repeatable.run.declared.actions:
        return None
    lines = [
        line
        for line in lines_of(repeatable.run.steps_bytes(), dict[str, Any], repeatable.run.path)
        if _is_of(line, repeatable.call)
    ]
    numbers = [
        number for number, call in enumerate(repeatable.run.calls()) if place_of(call) == place_of(repeatable.call)
    ]
    place = numbers.index(repeatable.number)
    return (lines[place], place) if len(lines) == len(numbers) else None


def _is_of(line: Line, call: Call) -> bool:
    return (line["step"], line["agent"], line.get("kind", call.kind)) == place_of(call)


def _lines_with(repeatable: Repeatable, scenario: Scenario, reply: Reply) -> Iterator[Line]:
    """Replay a run with a new reply to one call, while its questions stay the same; yield the lines about this call."""
    world, calls, made = scenario.start(repeatable.run.run.seed), list(repeatable.run.calls()), 0
    world.opening()
    while not world.finished and made < len(calls):
        questions = world.pending()
        logged = calls[made : made + len(questions)]
        if [question.asked for question in questions] != list(map(place_of, logged)):
            return
        replies = [reply if made + at == repeatable.number else reply_of(call) for at, call in enumerate(logged)]
        records = world.advance([answer_of(each) for each in replies])
        rows = (msgspec.json.decode(msgspec.json.encode(row)) for row in records if row.stream == "steps")
        yield from (row for row in rows if _is_of(row, repeatable.call))
        made += len(questions)
