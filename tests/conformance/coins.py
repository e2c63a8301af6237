"""A small world that holds all that a world must hold, and worlds that break one rule each."""

import copy
import io
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import msgspec
import numpy as np
from PIL import Image

from foundry import seeding
from foundry.declared import Actions
from foundry.prompts.prompt import Prompt
from foundry.records import Agent, Outcome, Record, RoundStep
from foundry.worlds.base import (
    Ahead,
    Answer,
    Question,
    QuestionKey,
    Recorded,
    Redrawing,
    Scenario,
    World,
    unanswered,
    undecided_outcome,
)

CALLS = ("heads", "tails", "pass")
PROMPT = Prompt("coins", {"call": "You are agent {{ agent }}. It showed {{ shown }}. Heads, tails or pass?"})


class Round(World):
    """Every agent calls the coin; what it showed is told in the next step."""

    def __init__(self, scenario: "Coins", seed: int) -> None:
        self.scenario, self.seed = scenario, seed
        self.completed, self.shown, self.calls = 0, "nothing yet", ()

    @property
    def finished(self) -> bool:
        return self.completed >= self.scenario.steps

    @property
    def step(self) -> int:
        return self.completed

    def coin(self) -> str:
        return CALLS[int(seeding.stream(self.seed, f"coin {self.completed}").integers(2))]

    def opening(self) -> Sequence[Record]:
        return [Agent(agent=agent, persona=one) for agent, one in enumerate(self.scenario.personas(self.seed))]

    def question(self, agent: int) -> Question:
        observation = {"agent": agent, "step": self.completed + 1, "shown": self.shown}
        return Question(
            self.completed + 1, agent, "call", observation, secret={"coin": self.coin()}, options=CALLS, idle="pass"
        )

    def pending(self) -> Sequence[Question]:
        return () if self.finished else [self.question(agent) for agent in range(self.scenario.agents)]

    def row(self, agent: int, answer: Answer) -> RoundStep:
        text = answer.text.strip()
        called = text if text in CALLS and unanswered(answer) is None else None
        outcome = unanswered(answer) or (Outcome.CHOSEN if called else undecided_outcome(answer))
        return RoundStep(
            step=self.completed + 1, agent=agent, kind="call", action=called, outcome=outcome,
            utility=float(called == self.coin()),
        )  # fmt: skip

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        rows = [self.row(agent, answer) for agent, answer in enumerate(answers)]
        self.shown, self.calls = self.coin(), tuple(row.action for row in rows)
        self.completed += 1
        return rows

    def draw(self) -> bytes:
        return drawn(self.completed, self.calls)

    def ahead(self) -> Ahead:
        return Later(self)


class Later(Ahead):
    """What the coin will show depends on nobody, so all that is asked is known from the beginning."""

    def __init__(self, world: Round) -> None:
        self.world = copy.copy(world)
        self.answered: set[QuestionKey] = set()
        self.round = world.completed + 1

    def ready(self) -> Sequence[Question]:
        return [*itertools.chain.from_iterable(self.steps())]

    def steps(self) -> Iterator[Sequence[Question]]:
        while not self.world.finished:
            yield self.world.pending()
            self.world.advance([Answer("")] * self.world.scenario.agents)

    def take(self, asked: QuestionKey, answer: Answer) -> None:
        self.answered.add(asked)

    def next_round(self) -> Sequence[QuestionKey]:
        whole = [(self.round, agent, "call") for agent in range(self.world.scenario.agents)]
        if not self.answered.issuperset(whole):
            return ()
        self.round += 1
        return whole


def drawn(step: int, calls: Sequence[object]) -> bytes:
    pixels = [(step * 20 % 256, CALLS.index(call) if call else 200, 0) for call in calls] or [(step, 0, 0)]
    image = Image.new("RGB", (len(pixels), 1))
    image.putdata(pixels)
    png = io.BytesIO()
    image.save(png, format="PNG")
    return png.getvalue()


class Coins(Scenario):
    """A configured world of coins."""

    form: ClassVar[str] = "rounds"
    kinds: ClassVar[tuple[str, ...]] = ("call",)
    records: ClassVar[tuple[type[Record], ...]] = (RoundStep, Agent)
    world: ClassVar[type[Round]] = Round

    def __init__(self, agents: int = 3, steps: int = 3) -> None:
        self.name, self.agents, self.steps = "coins", agents, steps

    def start(self, seed: int) -> World:
        return self.world(self, seed)

    def actions(self) -> Mapping[str, Actions]:
        return {"call": Actions(labels=CALLS, idle="pass")}

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        moods = seeding.stream(seed, "personas").integers(2, size=self.agents)
        return [{"mood": ("calm", "bold")[mood]} for mood in moods]

    def count_calls(self) -> int:
        return self.agents * self.steps

    def redraw(self, recorded: Recorded) -> Redrawing:
        return Redrawn(msgspec.json.Decoder(RoundStep).decode_lines(recorded.steps))


class Redrawn(Redrawing):
    def __init__(self, rows: Sequence[RoundStep]) -> None:
        self.rows = rows

    def draw(self, step: int) -> bytes:
        return drawn(step, [row.action for row in self.rows if row.step == step])


def with_world(name: str, **members: Any) -> type[Coins]:
    """Return the scenario whose episodes have other members."""
    return type(name, (Coins,), {"world": type(f"{name}Round", (Round,), members)})


def with_scenario(name: str, **members: Any) -> type[Coins]:
    return type(name, (Coins,), members)


def question_with(**changes: Any) -> Any:
    """Return a `question` with other fields, which may be functions of the world and the agent."""

    def question(self: Round, agent: int) -> Question:
        made = {key: value(self, agent) if callable(value) else value for key, value in changes.items()}
        return replace(Round.question(self, agent), **made)

    return question


def row_with(**changes: Any) -> Any:
    """Return a `row` with other keys, which may be functions of the world, the row and the answer."""

    def row(self: Round, agent: int, answer: Answer) -> RoundStep:
        step_record = Round.row(self, agent, answer)
        made = {key: value(self, step_record, answer) if callable(value) else value for key, value in changes.items()}
        return msgspec.structs.replace(step_record, **made)

    return row


def _ever_higher(self: Round) -> Sequence[Question]:
    self.peeked = getattr(self, "peeked", 0) + 1
    return [
        replace(question, observation={**question.observation, "peeked": self.peeked})
        for question in Round.pending(self)
    ]


def _counts_openings(self: Round) -> Sequence[Record]:
    self.opened = getattr(self, "opened", -1) + 1
    return Round.opening(self)[self.opened :]


def _moves_on(self: Round) -> bytes:
    self.shown = "drawn"
    return Round.draw(self)


NUMBERS = itertools.count()


class Forgetful(Coins):
    """Forgets a setting on its way through pickle."""

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "steps": 1}


class Shared(Coins):
    """Keeps what an episode did for the next one."""

    def __init__(self) -> None:
        super().__init__()
        self.started = 0

    def start(self, seed: int) -> World:
        self.started += 1
        world = Round(self, seed)
        world.shown = f"start {self.started}"
        return world


class Stranger(RoundStep, frozen=True, kw_only=True):
    pass


class Bare(Record, frozen=True, kw_only=True):
    stream: ClassVar[str] = "steps"
    step: int


def _raises_on_oddities(self: Round, agent: int, answer: Answer) -> RoundStep:
    answer.text.encode("ascii")
    return Round.row(self, agent, answer)


def _tells_all(self: Round, answers: Sequence[Answer]) -> Sequence[Record]:
    rows = Round.advance(self, answers)
    self.shown = answers[-1].text[:50]
    return rows


def _unsure(self: Round, answers: Sequence[Answer]) -> Sequence[Record]:
    rows = Round.advance(self, answers)
    if any(row.action is None for row in rows):
        self.shown = f"unsure {next(NUMBERS)}"
    return rows


def _half(self: Round, answers: Sequence[Answer]) -> Sequence[Record]:
    return Round.advance(self, answers)[1:]


def _other_class(self: Round, answers: Sequence[Answer]) -> Sequence[Record]:
    return [Stranger(**msgspec.structs.asdict(row)) for row in Round.advance(self, answers)]


class Hasty(Later):
    def ready(self) -> Sequence[Question]:
        return [replace(question, observation={**question.observation, "shown": "?"}) for question in super().ready()]


class Backwards(Later):
    def next_round(self) -> Sequence[QuestionKey]:
        return super().next_round()[::-1]


class Mute(Later):
    def ready(self) -> Sequence[Question]:
        return ()


class Early(Later):
    def take(self, asked: QuestionKey, answer: Answer) -> None:
        self.answered |= {(asked[0], agent, "call") for agent in range(3)}


BROKEN = [
    (with_world("Endless", finished=False), "plays to its end", "let `finished` be true"),
    (with_world("Stuck", pending=lambda self: ()), "plays to its end", "`finished` is false"),
    (with_world("Late", pending=lambda self: [self.question(agent) for agent in range(3)]),
     "plays to its end", "pending after the end"),
    (with_scenario("Modest", count_calls=lambda self: 1), "counts its calls", "asks 9 questions"),
    (with_world("Guess", question=question_with(kind="guess")), "asks what it says", "'guess'"),
    (with_world("Zero", question=question_with(step=lambda self, _: self.step)), "asks what it says", "has step 0"),
    (with_world("Twice", question=question_with(agent=0)), "asks what it says", "3 times"),
    (with_world("Array", question=question_with(observation={"shown": np.float64(1)})),
     "observes plain data", "numpy.float64"),
    (with_world("Peeking", pending=_ever_higher), "asks without side effects", "pending()"),
    (with_world("Opening", opening=_counts_openings), "opens without side effects", "opening()"),
    (with_world("Drawing", draw=_moves_on), "opens without side effects", "draw()"),
    (with_world("Clock", question=question_with(observation=lambda self, agent: {"shown": next(NUMBERS)})),
     "is equal from equal settings", "foundry.seeding.stream"),
    (Forgetful, "is equal from a pickle", "pickle"),
    (Shared, "starts afresh", "beside another"),
    (with_scenario("Lonely", personas=lambda self, seed: [{}]), "has a persona for every agent", "return a persona"),
    (with_scenario("Stratified", strata=lambda self, question: {"shown": question.step}),
     "tells moments apart by texts and flags", "use texts or flags"),
    (with_scenario("Unevenly", strata=lambda self, question: {} if question.agent else {"first": True}),
     "tells moments apart by texts and flags", "lacks first for some 'call' questions"),
    (with_world("Telltale", question=question_with(observation=lambda self, agent: {"coin": self.coin()})),
     "keeps its secrets", "coin"),
    (with_world("Painter", question=question_with(images=(b"\x89PNG",))), "shows images where it says", "1 images"),
    (with_scenario("Formless", form=None), "declares its records", "form is None"),
    (with_scenario("Sparse", records=(Bare, Agent)), "declares its records", "lacks agent, outcome"),
    (with_scenario("Idler", actions=lambda self: {"call": Actions(labels=CALLS, idle="nothing")}),
     "declares its records", "idle action"),
    (with_world("Strangers", advance=_other_class), "writes what it declares", "Stranger"),
    (with_world("Misnumbered", row=row_with(step=0)), "writes what it declares", "has the number 0"),
    (with_world("Halved", advance=_half), "records every step", "agent 0 was asked in step 1"),
    (with_world("Freely", row=row_with(action="edge")), "decides as declared", "actions() has only"),
    (with_world("Inventive", row=row_with(action=lambda self, row, answer: row.action or "pass")),
     "decides as declared", "record null"),
    (with_world("Nameless", row=row_with(outcome="fine")), "decides as declared", "use foundry.records.Outcome"),
    (with_world("Undefined", row=row_with(utility=float("nan"))), "loads its records back", "utility"),
    (with_world("Silent", opening=lambda self: ()), "opens with its personas", "opening() records"),
    (with_world("Blank", draw=lambda self: drawn(0, ())), "redraws what it drew", "step 1"),
    (with_world("Strict", row=_raises_on_oddities), "survives bad replies", "UnicodeEncodeError"),
    (with_world("Lumped", row=row_with(outcome=lambda _, row, __: row.outcome if row.action else Outcome.FAILED)),
     "survives bad replies", "instead of empty"),
    (with_world("Gossip", advance=_tells_all), "takes bad replies for no decision", "other agents observe"),
    (with_world("Fined", row=row_with(utility=lambda self, row, answer: -float(len(answer.text)))),
     "takes bad replies for no decision", "write equal"),
    (with_world("Unsure", advance=_unsure), "gives the same when played again", "differ"),
    (with_world("Doubled", question=question_with(options=("heads", " heads"))),
     "reads the options it offers", "keep one"),
    (with_world("Misleading", question=question_with(options=("edge",))), "reads the options it offers", "the outcome"),
    (with_world("Hasty", ahead=lambda self: Hasty(self)), "asks ahead what it asks later", "early questions differs"),
    (with_world("Backwards", ahead=lambda self: Backwards(self)), "asks ahead what it asks later", "order of pending"),
    (with_world("Mute", ahead=lambda self: Mute(self)), "asks ahead what it asks later", "ready() returns no"),
    (with_world("Early", ahead=lambda self: Early(self)), "asks ahead what it asks later", "no answer yet"),
    (with_world("Busy", question=question_with(idle="heads")), "reads its idle reply", "'heads'"),
]  # fmt: skip
"""A world, the check that must see what is wrong with it, and words of what that says."""
