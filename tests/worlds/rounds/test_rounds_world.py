"""Worlds of rounds: the rules as a generator, what is asked, read, recorded, told and drawn."""

import asyncio
import io
import json
from collections import Counter
from dataclasses import replace
from typing import Any, ClassVar

import pytest
from PIL import Image, ImageColor

from foundry.composing.preflight import first_questions
from foundry.conformance.playing import request_of
from foundry.declared import Actions
from foundry.errors import FoundryError, InputError
from foundry.models.base import ScriptedModel
from foundry.records import Agent, Message, Outcome, Record, RoundStep
from foundry.worlds.any.any_policies import First, Random, Stay
from foundry.worlds.base import Answer, Question, World
from foundry.worlds.rounds import rounds_world
from foundry.worlds.rounds.reading import deciding
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
from foundry.worlds.rounds.table import Table
from scripted_rounds import records


class Bar(RoundsScenario):
    """All decide at once whether to go."""

    kinds: ClassVar[tuple[str, ...]] = ("evening",)

    def __init__(self, *, crowded: float = 0.6, **settings: Any) -> None:
        super().__init__(**settings)
        self.crowded = crowded

    def actions(self) -> dict[str, Actions]:
        return {"evening": Actions(labels=("go", "stay"), idle="stay")}

    def play(self, table: Table) -> Play:
        went = None
        for _ in table.rounds(self.steps):
            decisions = yield [table.ask(agent, "evening", went=went) for agent in table.agents]
            went = sum(one.taken == "go" for one in decisions)
            fun = 10 if went <= self.crowded * self.agents else 0
            for one in decisions:
                table.record(one, utility=5 if one.taken == "stay" else fun)


class Catch(RoundStep, frozen=True, kw_only=True):
    """A catch knows what was left."""

    stock: int | None = None


class Stock(Record, frozen=True, kw_only=True):
    """The fish after a month."""

    stream: ClassVar[str] = "stock"

    step: int
    fish: int


class Fishery(RoundsScenario):
    """All catch at once, then talk one after another in drawn order; the end comes with the last fish."""

    kinds: ClassVar[tuple[str, ...]] = ("catch", "talk")
    records: ClassVar[tuple[type[Record], ...]] = (Catch, Message, Agent, Stock)

    def __init__(self, *, stock: int = 100, **settings: Any) -> None:
        super().__init__(**settings)
        self.stock = stock

    def actions(self) -> dict[str, Actions]:
        return {"catch": Actions(low=0, high=self.stock, idle=0)}

    def play(self, table: Table) -> Play:
        fish = self.stock
        for month in table.rounds(self.steps):
            legal = Actions(low=0, high=fish, idle=0)
            catches = yield [table.ask(agent, "catch", legal=legal, fish=fish) for agent in table.agents]
            caught = sum(one.taken for one in catches)
            for one in catches:
                table.record(one, utility=one.taken, stock=fish)
            for agent in table.stream(f"order {month}").permutation(self.agents).tolist():
                (said,) = yield [table.ask(agent, "talk", caught=caught)]
                table.tell(agent, [other for other in table.agents if other != agent], said.message)
            fish = min(2 * max(fish - caught, 0), self.stock)
            table.write(Stock(step=month, fish=fish))
            if fish < 5:
                return


class Silent(Bar):
    """A game that says neither what is legal nor what does nothing."""

    def actions(self) -> dict[str, Actions]:
        return {"evening": Actions(low=0)}


GO, STAY = deciding("go"), deciding("stay")


def bar(**changes: Any) -> Bar:
    return Bar(**({"name": "bar", "agents": 3, "steps": 2} | changes))


def fishery(**changes: Any) -> Fishery:
    return Fishery(**({"name": "fishery", "agents": 3, "steps": 2} | changes))


def answered(world: World, *texts: str) -> list[Record]:
    return list(world.advance([Answer(text) for text in texts]))


def test_what_one_yield_holds_is_asked_at_once_and_recorded_with_what_it_brought():
    world = bar().start(0)
    assert [(one.step, one.agent, one.kind) for one in world.pending()] == [(1, agent, "evening") for agent in range(3)]
    records = answered(world, GO, STAY, STAY)
    assert [(one.agent, one.action, one.utility) for one in records] == [(0, "go", 10), (1, "stay", 5), (2, "stay", 5)]
    assert (world.step, world.finished) == (1, False)
    records = answered(world, GO, GO, STAY)
    assert [one.utility for one in records] == [0, 0, 5]
    assert (world.step, world.finished, world.pending()) == (2, True, ())


def test_a_question_shows_who_is_asked_what_was_told_and_what_the_rules_show():
    world = bar(personas={"mood": {"calm": 1}}).start(0)
    assert world.pending()[1].observation == {
        "step": 1, "agent": 1, "agents": 3, "persona": {"mood": "calm"}, "received": [], "went": None,
    }  # fmt: skip
    assert world.opening() == [Agent(agent=agent, persona={"mood": "calm"}) for agent in range(3)]


def test_an_unreadable_decision_counts_as_idle_and_is_recorded_as_none():
    (first, *_) = answered(bar().start(0), "I will not go", STAY, STAY)
    assert (first.action, first.outcome, first.utility) == (None, Outcome.UNREADABLE, 5)


def test_talk_goes_one_after_another_in_drawn_order_and_is_heard_by_the_others_before_they_speak():
    world = fishery(agents=3).start(3)
    assert [one.action for one in answered(world, "5", "6", "7")] == [5, 6, 7]
    order, heard = [], []
    for _ in range(3):
        (question,) = world.pending()
        order.append(question.agent)
        heard.append([said["sender"] for said in question.observation["received"]])
        records = answered(world, f'{{"message": "I am {question.agent}"}}')
        delivered = [one for one in records if isinstance(one, Message)]
        assert {(one.sender, one.text) for one in delivered} == {(question.agent, f"I am {question.agent}")}
    assert sorted(order) == [0, 1, 2] and heard == [[], order[:1], order[:2]]


class Echoing(Bar):
    """All are asked the same twice an evening."""

    def play(self, table: Table) -> Play:
        for _ in table.rounds(self.steps):
            for _ in range(2):
                yield [table.ask(agent, "evening", went=None) for agent in table.agents]


def test_who_is_asked_the_same_again_in_a_round_answers_with_another_seed():
    world = Echoing(name="echoing", agents=2, steps=2).start(0)
    asked: list[Question] = []
    while not world.finished:
        asked += world.pending()
        answered(world, GO, STAY)
    expected = [(step, agent, again) for step in (1, 2) for again in (0, 1) for agent in (0, 1)]
    assert [(one.step, one.agent, one.again) for one in asked] == expected
    assert len({one.sampling_seed(0) for one in asked}) == 8


def test_an_episode_ends_where_its_rules_do_and_writes_what_they_leave_as_the_round_ends():
    world = fishery(agents=2, steps=1).start(0)
    answered(world, "1", "1")
    answered(world, "Hello!")
    spoken = [one for one in answered(world, "") if isinstance(one, RoundStep)]
    assert [(one.kind, one.action, one.message, one.outcome) for one in spoken] == [
        ("talk", None, "Hello!", Outcome.CHOSEN),
        ("talk", None, None, Outcome.EMPTY),
    ]
    world = fishery(agents=2, steps=9).start(0)
    answered(world, "60", "40")
    answered(world, "sorry")
    records = answered(world, "too late")
    assert world.finished and world.step == 1
    assert Stock(step=1, fish=0) in records


def test_own_keys_and_own_files_are_written_and_declared():
    scenario = fishery(agents=1, steps=1)
    written = records(scenario, Stay("s"), 0)
    assert [one for one in written if not isinstance(one, Message)] == [
        Catch(step=1, agent=0, kind="catch", action=0, outcome=Outcome.CHOSEN, utility=0, stock=100),
        Stock(step=1, fish=100),
        Catch(step=1, agent=0, kind="talk", action=None, outcome=Outcome.CHOSEN),
    ]
    declared = scenario.declared()
    assert declared.form == "rounds"
    assert declared.streams["steps"]["stock"] == "integer?" and declared.streams["stock"]["fish"] == "integer"


def test_what_is_legal_may_be_less_than_the_world_declares():
    world = fishery(agents=2).start(0)
    answered(world, "50", "40")
    for _ in range(2):
        answered(world, "hm")
    assert len(world.pending()[0].options) == 21
    assert [one.action for one in answered(world, "21", "20")] == [None, 20]


def test_random_draws_uniformly_among_what_is_legal_and_first_takes_the_first():
    drawn = Counter(one.action for one in records(bar(agents=30, steps=30), Random("r"), 0))
    assert abs(drawn["go"] - 450) < 3 * 15
    drawn = Counter(one.action for one in records(bar(agents=30, steps=30), Random("r", stay_probability=0.1), 0))
    assert abs(drawn["stay"] - 90) < 3 * 9
    assert {one.action for one in records(bar(agents=3), First("f"), 0)} == {"go"}
    question = replace(bar(agents=1).start(0).pending()[0], options=(), idle="I stay.")
    assert asyncio.run(First("f").ask(request_of(question, 0))).text == "I stay."


@pytest.mark.parametrize(("model", "what"), [(Random("r"), "options"), (First("f"), "options"), (Stay("s"), "idle")])
def test_a_world_that_declares_nothing_is_refused_in_one_line(model: ScriptedModel, what: str):
    (question,) = Silent(name="silent", agents=1, steps=1).start(0).pending()
    with pytest.raises(InputError, match=f"cannot act in this world.*Question.{what}"):
        model.check(question)


def test_every_label_has_a_colour_of_its_own_and_agents_are_numbered_as_long_as_there_is_room():
    known = Actions(labels=("nobody", *(f"agent {agent}" for agent in range(30))), idle="nobody")
    tones = {ImageColor.getrgb(rounds_world._tone(label, known)) for label in known.labels}
    assert len(tones) == 31 and ImageColor.getrgb(rounds_world.IDLE) in tones

    def is_numbered(agents: int) -> bool:
        picture = Image.open(io.BytesIO(rounds_world.draw([], 0, agents=agents, steps=1, actions={})))
        return len(picture.crop((0, 40, 55, 440)).getcolors()) > 1

    assert [is_numbered(agents) for agents in (30, 31)] == [True, False]


def test_a_number_without_a_greatest_one_is_drawn_by_the_greatest_so_far():
    known = {"give": Actions(low=0)}
    lines = [RoundStep(step=1, agent=agent, kind="give", action=action, outcome=Outcome.CHOSEN)
             for agent, action in enumerate((5, 40, 20))]  # fmt: skip
    lines.append(RoundStep(step=2, agent=0, kind="take", action=400, outcome=Outcome.CHOSEN))
    picture = Image.open(io.BytesIO(rounds_world.draw(lines, 1, agents=3, steps=1, actions=known)))
    assert [picture.getpixel((400, y)) for y in (110, 240, 370)] == [
        ImageColor.getrgb(rounds_world._shade(share, Actions(low=0, high=1))) for share in (0.125, 1, 0.5)
    ]
    assert rounds_world._shade(15, Actions(low=10, high=20)) == rounds_world._shade(0.5, Actions(low=0, high=1))


def test_calls_are_counted_at_most_and_a_wordy_answer_decides_and_fills_what_is_heard():
    assert (bar().count_calls(), fishery().count_calls()) == (6, 12)
    scenario = fishery(agents=1)
    world = scenario.start(0)
    (one,) = answered(world, scenario.wordy_answer(world.pending()[0], 500))
    assert one.action == 100
    said = json.loads(scenario.wordy_answer(world.pending()[0], 500))
    assert world.pending()[0].kind == "talk" and len(said["message"]) > 400


@pytest.mark.parametrize("changes", [{"agents": 0}, {"steps": 1.5}, {"agents": True}])
def test_numbers_of_agents_and_steps_are_whole_and_positive(changes: dict[str, Any]):
    with pytest.raises(InputError, match=f"world.{next(iter(changes))} must be a whole number from 1"):
        bar(**changes)


class Wrong(Bar):
    """Asks before its first round, records twice, or asks nobody."""

    def __init__(self, fault: str) -> None:
        super().__init__(name="wrong", agents=1, steps=2)
        self.fault = fault

    def play(self, table: Table) -> Play:
        if self.fault == "early":
            yield [table.ask(0, "evening")]
        for _ in table.rounds(2):
            if self.fault == "nobody":
                yield []
            (one,) = yield [table.ask(0, "evening")]
            table.record(one)
            table.record(one)


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
    council = Council(name="council", agents=9, steps=2)
    assert [question.kind for question in first_questions(council, 0)] == ["talk", "catch"]
