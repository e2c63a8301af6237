"""What a world's records must hold: they are what it declares, load back, and pictures are made from them again."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from foundry.conformance.finding import Skipped, require
from foundry.conformance.playing import WorldCase
from foundry.declared import Actions
from foundry.records import Agent, Outcome, Record
from foundry.worlds.base import Recorded

STEPS = "steps"
COMMON = ("step", "agent", "outcome")
"""Keys of every step of every form."""
READABLE = (Outcome.CHOSEN, Outcome.REPAIRED)
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


def declares_its_records(case: WorldCase) -> None:
    """The scenario says its form, the classes of its records with the common keys, and what can be decided."""
    scenario = case.scenario
    form = getattr(scenario, "form", None)
    require(
        isinstance(form, str) and _NAME.fullmatch(form) is not None,
        f"form is {form!r}: name what the records are, such as form = 'rounds'",
    )
    for one in scenario.records:
        require(
            isinstance(one, type) and issubclass(one, Record) and bool(one.stream),
            f"records names {one!r}: give classes below foundry.records.Record with a `stream`",
        )
    steps = [one for one in scenario.records if one.stream == STEPS]
    require(len(steps) == 1, f"{len(steps)} classes of records have the stream 'steps': one has to")
    missing = [key for key in COMMON if key not in steps[0].__struct_fields__]
    require(not missing, f"{steps[0].__name__} has no {', '.join(missing)}: every step says them; see RoundStep")
    for kind, actions in scenario.actions().items():
        _check_actions(kind, actions, scenario.kinds)
    scenario.declared()


def _check_actions(kind: str, actions: Actions, kinds: tuple[str, ...]) -> None:
    require(kind in kinds, f"actions() names '{kind}', which is not asked: its kinds are {', '.join(kinds)}")
    low, high = _ends(actions)
    require(
        low <= high and not (actions.labels and math.isfinite(low - high)),
        f"actions()['{kind}'] is {actions}: give the labels of a closed set, or the low and high of a number",
    )
    if actions.idle is not None:
        require(
            _is_among(actions, actions.idle), f"the idle action of '{kind}', {actions.idle!r}, is none of its actions"
        )


def writes_what_it_declares(case: WorldCase) -> None:
    """Every record is of a declared class; steps are numbered by the step that was asked, agents from 0."""
    agents = range(len(case.scenario.personas(case.seed)))
    declared = case.scenario.records
    for record in case.usual.opening:
        require(type(record) in declared, _undeclared(record))
    for turn in case.usual.turns:
        for record in turn.records:
            require(type(record) in declared, _undeclared(record))
            if record.stream == STEPS:
                step, agent = getattr(record, "step", None), getattr(record, "agent", None)
                asked = turn.questions[0].step
                require(step == asked, f"a record of step {asked} says step {step}: steps count from 1")
                require(agent in agents, f"a step is of agent {agent!r}: the agents are 0 to {len(agents) - 1}")


def _undeclared(record: Record) -> str:
    return f"it writes a {type(record).__name__} (stream '{record.stream}'): add the class to `records` of the scenario"


def records_every_step(case: WorldCase) -> None:
    """Every completed step has a record of each agent that was asked in it, each kind only as often as it was asked."""
    asked: dict[int, set[int]] = {}
    for question in case.usual.questions:
        asked.setdefault(question.step, set()).add(question.agent)
    put = Counter((one.step, one.agent, one.kind) for one in case.usual.questions)
    rows = Counter((row.step, row.agent, getattr(row, "kind", None)) for row in _steps(case.usual.records))
    for (step, agent, kind), times in rows.items():
        most = max(put[step, agent, str(kind)], 1)
        require(times <= most, f"agent {agent} has {times} records of kind {kind} in step {step}: write {most}")
    recorded = {(step, agent) for step, agent, _ in rows}
    for step, agents in asked.items():
        missing = sorted(agent for agent in agents if (step, agent) not in recorded)
        require(not missing, f"step {step} has no record of agent {', '.join(map(str, missing))}, who was asked in it")


def decides_as_declared(case: WorldCase) -> None:
    """Outcomes are of `Outcome`; an action is among the declared ones, and null where nothing could be read."""
    actions = case.scenario.actions()
    for row in (*_steps(case.usual.records), *_steps(case.silent.records)):
        require(isinstance(row.outcome, Outcome), f"an outcome is {row.outcome!r}: use foundry.records.Outcome")
        declared = declared_for(row, actions)
        if declared is None:
            continue
        decision = row.decision
        if row.outcome in READABLE:
            require(
                decision is not None and _is_among(declared, decision),
                f"agent {row.agent} decided {decision!r} in step {row.step}, which is not declared: {declared}",
            )
        else:
            require(
                decision is None,
                f"agent {row.agent} has the action {decision!r} in step {row.step}, where its reply was {row.outcome}: "
                "nothing becomes an action that no model said; write null",
            )


def declared_for(row: Record, actions: Mapping[str, Actions]) -> Actions | None:
    """Return what the decision of a step can be; None where nothing is declared for it."""
    kind = getattr(row, "kind", None)
    if kind is None and len(actions) == 1:
        return next(iter(actions.values()))
    return actions.get(str(kind))


def _is_among(actions: Actions, decision: object) -> bool:
    if actions.labels:
        return decision in actions.labels
    if not isinstance(decision, int | float) or isinstance(decision, bool):
        return False
    low, high = _ends(actions)
    return (not actions.whole or float(decision).is_integer()) and low <= decision <= high


def _ends(actions: Actions) -> tuple[float, float]:
    low, high = actions.low, actions.high
    return (-math.inf if low is None else low, math.inf if high is None else high)


def loads_its_records_back(case: WorldCase) -> None:
    """What is written is read back as it was, by the declared types."""
    for record in case.usual.records:
        content = msgspec.json.encode(record)
        try:
            back = msgspec.json.decode(content, type=type(record))
        except msgspec.DecodeError as error:
            require(False, f"a {type(record).__name__} cannot be read again: {error}; its line is {content[:200]!r}")
            return
        require(back == record, f"a {type(record).__name__} is read back as another one; its line is {content[:200]!r}")


def opens_with_its_personas(case: WorldCase) -> None:
    """Where agents have personas, `opening()` records them as `Agent`, the same as `personas(seed)`.

    Those of agents that come into the world later are recorded then.
    """
    personas = [dict(one) for one in case.scenario.personas(case.seed)]
    recorded = {one.agent: one.persona for one in case.usual.opening if isinstance(one, Agent)}
    if not any(personas) and not recorded:
        raise Skipped("has no personas")
    if case.scenario.grows:
        personas = personas[: len(case.usual.turns[0].questions)]
    expected = {agent: persona for agent, persona in enumerate(personas) if persona}
    require(recorded == expected, f"opening() records the personas {recorded}, personas({case.seed}) says {expected}")


def redraws_what_it_drew(case: WorldCase) -> None:
    """`redraw` makes every picture again from the records alone, byte for byte."""
    played = case.drawn
    kept = {one.path: one.content for one in played.records if hasattr(one, "path") and hasattr(one, "content")}
    recorded = Recorded(case.seed, played.lines(STEPS), played.lines("episode"), kept.get)
    again = case.make().redraw(recorded)
    for step, picture in played.pictures.items():
        require(picture.startswith(b"\x89PNG"), f"draw() gives no PNG after step {step}")
        require(
            again.draw(step) == picture,
            f"the picture of step {step} differs from the one that draw() made: draw from what the records say alone",
        )


def _steps(records: tuple[Record, ...]) -> Iterator[Any]:
    return (record for record in records if record.stream == STEPS)


CHECKS = (
    declares_its_records,
    writes_what_it_declares,
    records_every_step,
    decides_as_declared,
    loads_its_records_back,
    opens_with_its_personas,
    redraws_what_it_drew,
)
