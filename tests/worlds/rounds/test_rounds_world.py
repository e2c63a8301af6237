"""Worlds of rounds: the rules as a generator, what is asked, read, recorded, told and drawn."""

import asyncio
import json
import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import pytest

import small_worlds as games
from foundry.composing.preflight import first_questions
from foundry.conformance.playing import request_of
from foundry.declared import Actions
from foundry.errors import FoundryError, InputError
from foundry.models.base import ScriptedModel
from foundry.records import Agent, Message, Outcome, Record, RoundStep
from foundry.worlds.any.any_policies import First, Random, Stay
from foundry.worlds.base import Answer, World
from foundry.worlds.rounds.bar import Bar
from foundry.worlds.rounds.fishery import Catch, Fishery, Stock
from foundry.worlds.rounds.reading import deciding
from foundry.worlds.rounds.rounds_policies import Conditional
from foundry.worlds.rounds.rounds_world import Play
from foundry.worlds.rounds.table import Table
from scripted_rounds import records


class Silent(Bar):
    """A game that says neither what is legal nor what does nothing."""

    def actions(self) -> dict[str, Actions]:
        return {"evening": Actions(low=0)}


GO, STAY = deciding("go"), deciding("stay")
SMALL = {"agents": 3, "steps": 2}


def bar(**changes: Any) -> Bar:
    return Bar(**(games.BAR | SMALL | changes))


def fishery(**changes: Any) -> Fishery:
    """Return a fishery in which each agent speaks once a month."""
    return Fishery(**(games.FISHERY | SMALL | {"talk": changes.get("agents", 3)} | changes))


def answered(world: World, *texts: str) -> list[Record]:
    return list(world.advance([Answer(text) for text in texts]))


def decided(written: Sequence[Record]) -> list[RoundStep]:
    return [step_record for step_record in written if isinstance(step_record, RoundStep)]


def test_what_one_yield_holds_is_asked_at_once_and_recorded_with_what_it_brought():
    world = bar().start(0)
    assert [(question.step, question.agent, question.kind) for question in world.pending()] == [
        (1, agent, "evening") for agent in range(3)
    ]
    lines = decided(answered(world, GO, STAY, STAY))
    assert [(line.agent, line.action, line.utility) for line in lines] == [
        (0, "go", 10),
        (1, "stay", 5),
        (2, "stay", 5),
    ]
    assert (world.step, world.finished) == (1, False)
    assert [step_record.utility for step_record in decided(answered(world, GO, GO, STAY))] == [0, 0, 5]
    assert (world.step, world.finished, world.pending()) == (2, True, ())


def test_a_question_shows_who_is_asked_what_was_told_and_what_the_rules_show():
    world = bar(personas={"mood": {"calm": 1}}).start(0)
    told = {"step": 1, "agent": 1, "agents": 3, "persona": {"mood": "calm"}, "received": [], "evenings": []}
    assert world.pending()[1].observation.items() >= told.items()
    assert world.opening() == [Agent(agent=agent, persona={"mood": "calm"}) for agent in range(3)]


def test_an_unreadable_decision_counts_as_idle_and_is_recorded_as_none():
    (first, *_) = answered(bar().start(0), "I will not go", STAY, STAY)
    assert (first.action, first.outcome, first.utility) == (None, Outcome.UNREADABLE, 5)


def test_an_episode_ends_where_its_rules_do_and_writes_what_they_leave_as_the_round_ends():
    world = fishery(agents=2, steps=1).start(0)
    answered(world, "1", "1")
    answered(world, "Hello!")
    spoken = decided(answered(world, ""))
    assert [
        (step_record.kind, step_record.action, step_record.message, step_record.outcome) for step_record in spoken
    ] == [
        ("talk", None, "Hello!", Outcome.CHOSEN),
        ("talk", None, None, Outcome.EMPTY),
    ]
    world = fishery(agents=2, steps=9).start(0)
    answered(world, "60", "40")
    answered(world, "sorry")
    records = answered(world, "too late")
    assert world.finished and world.step == 1
    assert Stock(step=1, before=100, caught=100, outsider=None, after=0, next=None) in records


def test_own_keys_and_own_files_are_written_and_declared():
    scenario = fishery(agents=1, steps=1)
    written = records(scenario, Stay("s"), 0)
    assert [one for one in written if not isinstance(one, Message)] == [
        Catch(step=1, agent=0, kind="catch", action=0, outcome=Outcome.CHOSEN, utility=0, caught=0),
        Stock(step=1, before=100, caught=0, outsider=None, after=100, next=100),
        Catch(step=1, agent=0, kind="talk", action=None, outcome=Outcome.CHOSEN),
    ]
    declared = scenario.declared()
    assert declared.form == "rounds"
    assert declared.streams["steps"]["caught"] == "integer?" and declared.streams["stock"]["after"] == "integer"


def test_what_is_legal_may_be_less_than_the_world_declares():
    world = fishery(agents=2).start(0)
    answered(world, "50", "40")
    for _ in range(2):
        answered(world, "hm")
    assert len(world.pending()[0].options) == 21
    assert [step_record.action for step_record in decided(answered(world, "21", "20"))] == [None, 20]


def test_random_draws_uniformly_among_what_is_legal_and_first_takes_the_first():
    def actions(model: ScriptedModel, **changes: int) -> Counter[Any]:
        return Counter(step_record.action for step_record in decided(records(bar(**changes), model, 0)))

    assert abs(actions(Random("r"), agents=30, steps=30)["go"] - 450) < 3 * 15
    assert abs(actions(Random("r", stay_probability=0.1), agents=30, steps=30)["stay"] - 90) < 3 * 9
    assert set(actions(First("f"))) == {"go"}
    question = replace(bar(agents=1).start(0).pending()[0], options=(), idle="I stay.")
    assert asyncio.run(First("f").ask(request_of(question, 0))).text == "I stay."


@pytest.mark.parametrize(("model", "what"), [(Random("r"), "options"), (First("f"), "options"), (Stay("s"), "idle")])
def test_a_world_that_declares_nothing_is_refused_in_one_line(model: ScriptedModel, what: str):
    (question,) = Silent(**(games.BAR | {"agents": 1, "steps": 1})).start(0).pending()
    with pytest.raises(InputError, match=f"cannot act in this world.*Question.{what}"):
        model.check(question)


def test_calls_are_counted_at_most_and_a_wordy_answer_decides_and_fills_what_is_heard():
    assert (bar().count_calls(), games.punished().count_calls()) == (6, 24)
    scenario = fishery(agents=1)
    world = scenario.start(0)
    (step_record,) = decided(answered(world, scenario.wordy_answer(world.pending()[0], 500)))
    assert step_record.action == 100
    said = json.loads(scenario.wordy_answer(world.pending()[0], 500))
    assert world.pending()[0].kind == "talk" and len(said["message"]) > 400


REFUSED: Sequence[tuple[Callable[..., object], dict[str, Any], str]] = [
    (bar, {"agents": 0}, "world.agents must be a whole number from 1"), (bar, {"steps": 1.5}, "world.steps must"),
    (bar, {"agents": True}, "world.agents must"), (bar, {"capacity": 1.2}, "must be a number from 0 to 1"),
    (bar, {"fun": None}, "world.fun must be a number; got None"), (bar, {"home": math.nan}, "world.home must"),
    (bar, {"reports": "explicite"}, "Did you mean 'explicit'"), (fishery, {"collapse": 101}, "from 0 to 100"),
    (fishery, {"sharing": "stocastic"}, "Did you mean 'stochastic'"), (fishery, {"stock": 2.5}, "from 1 to 10000"),
    (fishery, {"universalisation": "x"}, "must be true or false"),
    (fishery, {"outsider": {"from": 2}}, "a mapping such as {from: 4, catch: 30}"),
    (fishery, {"outsider": {"from": 2, "catch": -1}}, "world.outsider.catch must"),
    (fishery, {"personas": "x"}, "world.personas must be"), (fishery, {"personas": {"a": {"b": "c"}}}, "personas.a "),
    (games.naming, {"protocol": "speakers"}, "Did you mean 'speaker'"), (games.naming, {"agents": 1}, "number from 2"),
    (games.naming, {"until": "agreement"}, "Available: consensus, null"), (games.naming, {"names": "ama"}, "a list"),
    (games.naming, {"names": ["a", "a"]}, "different texts"), (games.naming, {"established": "amo"}, "mean 'ama'"),
    (games.naming, {"names": None}, "null with world.protocol=speaker"),
    (games.naming, {"committed": 0.2}, "needs world.committed_name"),
    (games.naming, {"committed": 0.99, "committed_name": "ama"}, "nobody is asked"),
    (games.punished, {"tokens": 0}, "world.tokens must"), (games.punished, {"cost": math.nan}, "world.cost must"),
    (partial(Conditional, "c"), {"slope": 2, "punishes": False}, "model.slope must"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "changes", "told"), REFUSED)
def test_a_setting_that_cannot_be_is_told_in_one_line(make: Callable[..., object], changes: dict[str, Any], told: str):
    with pytest.raises(InputError) as error:
        make(**changes)
    assert told in str(error.value) and "\n" not in str(error.value)


class Wrong(Bar):
    """Asks before its first round, records twice, or asks nobody."""

    def __init__(self, fault: str) -> None:
        super().__init__(**(games.BAR | {"agents": 1, "steps": 2}))
        self.fault = fault

    def play(self, table: Table) -> Play:
        if self.fault == "early":
            yield [table.ask(0, "evening")]
        for _ in table.rounds(2):
            if self.fault == "nobody":
                yield []
            (decision,) = yield [table.ask(0, "evening")]
            table.record(decision)
            table.record(decision)


@pytest.mark.parametrize(
    ("fault", "told"), [("early", "loop over"), ("nobody", "no question"), ("twice", "is already recorded")]
)
def test_rules_that_break_their_contract_are_told(fault: str, told: str):
    with pytest.raises(FoundryError, match=told):
        answered(Wrong(fault).start(0), GO)


class Council(Fishery):
    """Everyone speaks in turn before anyone decides."""

    def play(self, table: Table) -> Play:
        for _ in table.rounds(self.steps):
            for agent in table.agents:
                yield [table.ask(agent, "talk")]
            yield [table.ask(agent, "catch") for agent in table.agents]


def test_every_kind_is_found_before_a_sweep_however_many_speak_first():
    council = Council(**(games.FISHERY | {"agents": 9, "steps": 2}))
    assert [question.kind for question in first_questions(council, 0)] == ["talk", "catch"]
