"""Recorded calls that can be made again: which are drawn, how they are put, and whether another reply decides alike."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import msgspec

from foundry import seeding
from foundry.episode import answer_of
from foundry.models.base import ChatMessage, Model, Reply, Request, RequestKeys
from foundry.records import Call, Record
from foundry.running.replayed import reply_of
from foundry.storing.matching import place_of
from foundry.storing.store import IMAGES, RunFolder, kept_file, lines_of
from foundry.trust.forms import Line, compared_of
from foundry.worlds.base import Scenario

STREAM = "determinism"
"""The named stream of a run's seed that its calls are drawn from."""
T = TypeVar("T")


@dataclass(frozen=True)
class Decided:
    """What a call decided.

    Attributes:
        line: of the steps.
        place: among the lines of the same step, agent and kind of question, as a probe with repeats has them.
    """

    line: Line
    place: int


@dataclass(frozen=True)
class Repeatable:
    """A recorded call that can be made again.

    Attributes:
        run: its run.
        number: its place in the log of calls, from 0.
        call: as it was logged.
        request: what puts it again: the same messages, seed and parameters.
    """

    run: RunFolder
    number: int
    call: Call
    request: Request


def draw(runs: Sequence[RunFolder], model: Model, count: int, *, most_runs: int) -> list[Repeatable]:
    """Return calls of a model in an order whose first ones are spread over runs and kinds of question.

    Only answers that the server gave in these runs count, none that came from the cache.

    Args:
        runs: complete runs, one at least.
        model: the bare model.
        count: how many calls are wanted at most, of each run and kind.
        most_runs: how many runs are read at most.
    """
    order = seeding.stream(runs[0].run.seed, STREAM).permutation(len(runs))[:most_runs]
    parameters = msgspec.json.decode(msgspec.json.encode(model.parameters()))
    return _in_turn([_of_run(runs[place], model, parameters, count, turn) for turn, place in enumerate(order.tolist())])


def _of_run(run: RunFolder, model: Model, parameters: Mapping[str, Any], count: int, turn: int) -> list[Repeatable]:
    """Return calls of one run, its kinds of question in turn, beginning with another kind in each run."""
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
    """Return the first of each list, then the second of each, and so on."""
    rounds = itertools.zip_longest(*([(one,) for one in each] for each in lists), fillvalue=())
    return [one for places in rounds for place in places for one in place]


def _images(run: RunFolder) -> dict[str, bytes]:
    """Return the kept images that a run's model saw, by their SHA-256."""
    names = [name for name in run.pictures() if name.startswith(f"{IMAGES}/")]
    kept = [content for name in names if (content := kept_file(run.path, name)) is not None]
    return {hashlib.sha256(content).hexdigest(): content for content in kept}


def _request(call: Call, model: Model, images: Mapping[str, bytes]) -> Request | None:
    """Return what puts a logged call again; None where not all of it was kept."""
    messages = tuple(
        ChatMessage(line["role"], line["content"], tuple(images.get(sha, b"") for sha in line.get("images_sha256", ())))
        for line in call.messages
    )
    if RequestKeys(model, call.digest).key(messages, call.seed) != call.key:
        return None
    return Request(messages, call.seed, call.kind, {}, call.step, call.agent, key=call.key)


def decision_of(one: Repeatable) -> Decided | None:
    """Return what a call decided; None where it decides nothing by itself, or the records do not tell."""
    if one.call.kind not in one.run.declared.actions:
        return None
    lines = lines_of(one.run.steps_bytes(), dict[str, Any], one.run.path)
    found = [line for line in lines if _is_of(line, one.call)]
    asked = [number for number, call in enumerate(one.run.calls()) if place_of(call) == place_of(one.call)]
    place = asked.index(one.number)
    return Decided(found[place], place) if len(found) == len(asked) else None


def decides_alike(one: Repeatable, recorded: Decided, scenario: Scenario, reply: Reply) -> bool:
    """Return whether another reply to a call decides what is recorded, as its world reads it.

    The episode is played from its recorded answers up to what the reply decides; where that is never recorded, since
    others are asked then, it is another decision.
    """
    now = next(itertools.islice(_lines_with(one, scenario, reply), recorded.place, None), None)
    return now is not None and compared_of(scenario.form).acts_alike(recorded.line, now)


def _is_of(line: Line, call: Call) -> bool:
    return (line["step"], line["agent"], line.get("kind", call.kind)) == place_of(call)


def _lines_with(one: Repeatable, scenario: Scenario, reply: Reply) -> Iterator[Line]:
    """Play on with another reply to a call while the same is asked; yield what is decided at its place."""
    world, calls, made = scenario.start(one.run.run.seed), list(one.run.calls()), 0
    world.opening()
    while not world.finished and made < len(calls):
        questions = world.pending()
        logged = calls[made : made + len(questions)]
        if [question.asked for question in questions] != list(map(place_of, logged)):
            return
        replies = [reply if made + at == one.number else reply_of(call) for at, call in enumerate(logged)]
        yield from _decisions(world.advance([answer_of(each) for each in replies]), one.call)
        made += len(questions)


def _decisions(records: Sequence[Record], call: Call) -> Iterator[Line]:
    for record in records:
        if record.stream == "steps":
            line = msgspec.json.decode(msgspec.json.encode(record))
            if _is_of(line, call):
                yield line
