"""Plays episodes for the checks: with usual replies, with idle ones, with one reply that is of no use."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import msgspec

from foundry import seeding
from foundry.composing.baselines import Stage
from foundry.conformance.finding import require
from foundry.models.base import Model, Request
from foundry.prompts.prompt import Prompt
from foundry.records import Record
from foundry.running.build import build
from foundry.worlds.base import Answer, Asked, Question, Scenario, World

Answering: TypeAlias = Callable[[Sequence[Question]], list[Answer]]
"""Answers the pending questions, in their order."""

POLICIES: tuple[Mapping[str, Any], ...] = (
    {"_target_": "foundry.models.scripted.any.Random", "name": "scripted/random"},
    {"_target_": "foundry.models.scripted.camera.Wander", "name": "scripted/wander"},
)
"""Who answers in the checks where the chosen model costs something or cannot act in the world."""
_SPARE = 100
"""Questions beyond twice those that a scenario counts, after which it is said never to end."""


@dataclass(frozen=True)
class Turn:
    """One round of questions and what the world made of the answers; `step` is the number of completed steps then."""

    questions: tuple[Question, ...]
    records: tuple[Record, ...]
    step: int


@dataclass(frozen=True)
class Episode:
    """What an episode did.

    Attributes:
        opening: records before the first question.
        turns: in their order.
        finished: whether it came to an end.
        left: what was pending at the end.
        pictures: the state as a PNG, by step, 0 the initial one; empty where none were asked for.
    """

    opening: tuple[Record, ...]
    turns: tuple[Turn, ...]
    finished: bool
    left: tuple[Question, ...]
    pictures: Mapping[int, bytes]

    @property
    def questions(self) -> Iterator[Question]:
        """Every question."""
        return (question for turn in self.turns for question in turn.questions)

    @property
    def records(self) -> tuple[Record, ...]:
        """Every record."""
        return (*self.opening, *(record for turn in self.turns for record in turn.records))

    @property
    def asked(self) -> int:
        """Number of questions."""
        return sum(len(turn.questions) for turn in self.turns)

    def lines(self, stream: str) -> bytes:
        """Return the lines of a record file."""
        return b"".join(msgspec.json.encode(one) + b"\n" for one in self.records if one.stream == stream)

    def content(self) -> list[bytes]:
        """Return all that two equal episodes have in common, one piece a record or question."""
        return [*map(msgspec.json.encode, self.records), *(repr(seen(one)).encode() for one in self.questions)]


def seen(question: Question) -> tuple[Any, ...]:
    """Return what is seen of a question: all but its secret, which is worked out when it is asked for."""
    return (
        question.step,
        question.agent,
        question.kind,
        question.observation,
        question.images,
        question.options,
        question.idle,
    )


def play(world: World, answering: Answering, *, most: int, looks: int = 1, pictures: bool = False) -> Episode:
    """Play a world until it ends, asks nothing, or has asked more than `most` questions.

    Args:
        world: a fresh episode.
        answering: gives the answers.
        most: questions after which it is left.
        looks: how often the pending questions are asked for in each round.
        pictures: whether to draw every state.
    """
    opening, asked = tuple(world.opening()), 0
    turns: list[Turn] = []
    drawn = {0: world.draw()} if pictures else {}
    while not world.finished and asked <= most:
        before = world.step
        for _ in range(looks - 1):
            world.pending()
        questions = tuple(world.pending())
        if not questions:
            break
        asked += len(questions)
        records = tuple(world.advance(answering(questions)))
        turns.append(Turn(questions, records, world.step))
        if pictures and world.step != before:
            drawn[world.step] = world.draw()
    return Episode(opening, tuple(turns), world.finished, tuple(world.pending()), drawn)


def play_ahead(world: World, answering: Answering, *, most: int, pick: Callable[[int], int]) -> Episode | None:
    """Play a world ahead of its rounds from where it can; None where it never can.

    Args:
        world: a fresh episode.
        answering: gives the answers.
        most: questions after which it is left.
        pick: which of so many open questions is answered next.
    """
    opening = tuple(world.opening())
    turns: list[Turn] = []
    while not world.finished and (ahead := world.ahead()) is None and len(turns) <= most:
        questions = tuple(world.pending())
        turns.append(Turn(questions, tuple(world.advance(answering(questions))), world.step))
    if world.finished or ahead is None:
        return None
    asked: dict[Asked, tuple[Question, Answer]] = {}
    opened: list[Asked] = []
    while not world.finished and len(asked) <= most:
        ready = ahead.ready()
        asked |= {one.asked: (one, answer) for one, answer in zip(ready, answering(ready), strict=True)}
        opened += [one.asked for one in ready]
        require(bool(opened), f"after {world.step} steps nothing is ready, and no answer is awaited: let ready() ask")
        one = opened.pop(pick(len(opened)))
        ahead.take(one, asked[one][1])
        while whole := ahead.next_round():
            missing = [one for one in whole if one not in asked or one in opened]
            require(not missing, f"next_round() says that {missing[:1]} is answered, which it is not")
            questions = tuple(asked[one][0] for one in whole)
            records = world.advance([asked[one][1] for one in whole])
            turns.append(Turn(questions, tuple(records), world.step))
    return Episode(opening, tuple(turns), world.finished, tuple(world.pending()), {})


@dataclass(frozen=True)
class WorldCase:
    """A world to be checked, and its prompt.

    Attributes:
        make: builds its scenario anew.
        make_prompt: builds anew the prompt that it is asked by.
        templates: those of the prompt as they are written, by kind of question.
        policy: a scripted model that answers; without one, replies are drawn from the options of each question.
        schemas: JSON Schema of the reply by kind of question, where replies are held to one.
        seed: the episodes' seed.
    """

    make: Callable[[], Scenario]
    make_prompt: Callable[[], Prompt]
    templates: Mapping[str, Any] = field(default_factory=dict)
    policy: Model | None = None
    schemas: Mapping[str, Any] | None = None
    seed: int = 0

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario that most checks use."""
        return self.make()

    @property
    def most(self) -> int:
        """Questions after which an episode is given up."""
        return 2 * self.scenario.count_calls() + _SPARE

    @cached_property
    def usual(self) -> Episode:
        """An episode with usual replies."""
        return self.played(self.answers)

    @cached_property
    def drawn(self) -> Episode:
        """The same episode, every state drawn."""
        return self.played(self.answers, pictures=True)

    @cached_property
    def idle(self) -> Episode:
        """An episode in which everybody does nothing, or says nothing where there is no idle reply."""
        return self.played(lambda questions: [Answer(one.idle or "") for one in questions])

    @cached_property
    def silent(self) -> Episode:
        """An episode in which no reply holds any text."""
        return self.played(lambda questions: [Answer("") for _ in questions])

    @property
    def put(self) -> Sequence[Question]:
        """The questions that a prompt must put: with usual replies, and with replies that hold no text."""
        return (*self.usual.questions, *self.silent.questions)

    def played(
        self, answering: Answering, *, scenario: Scenario | None = None, looks: int = 1, pictures: bool = False
    ) -> Episode:
        """Return an episode of this or another scenario with the case's seed."""
        world = (scenario or self.scenario).start(self.seed)
        return play(world, answering, most=self.most, looks=looks, pictures=pictures)

    def answers(self, questions: Sequence[Question]) -> list[Answer]:
        """Return the policy's answers, else drawn ones."""
        if self.policy is None:
            return [Answer(self._reply(question)) for question in questions]
        replies = asyncio.run(self.policy.ask_all([request_of(one, self.seed) for one in questions]))
        return [Answer(reply.text, reply.ending) for reply in replies]

    def _reply(self, question: Question) -> str:
        if question.options:
            rng = seeding.stream(self.seed, f"check:{question.step}:{question.agent}:{question.kind}")
            return question.options[int(rng.integers(len(question.options)))]
        return question.idle if question.idle is not None else self.scenario.wordy_answer(question, 300)


def request_of(question: Question, seed: int) -> Request:
    """Return the request that puts a question to a scripted model, which reads no messages."""
    return Request(
        messages=(),
        seed=question.sampling_seed(seed),
        kind=question.kind,
        observation=question.told,
        step=question.step,
        agent=question.agent,
        options=question.options,
        idle=question.idle,
    )


def policy_for(scenario: Scenario, chosen: Mapping[str, Any], seed: int) -> Mapping[str, Any] | None:
    """Return the configuration of the chosen model if it can act here and costs nothing, else of a shipped policy."""
    stage = Stage(scenario, seed)
    return next((one for one in (chosen, *POLICIES) if stage.suits(build(one))), None)
