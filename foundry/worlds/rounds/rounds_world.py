"""A world of rounds: its rules are a generator that yields questions and receives decisions."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Generator, Sequence
from typing import Any, ClassVar, TypeAlias

import msgspec

from foundry import seeding
from foundry.errors import FoundryError, InputError
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.base import Answer, Question, Reading, Recorded, Redrawing, Scenario, World, filler
from foundry.worlds.personas import Attributes, check_attributes, draw_personas
from foundry.worlds.rounds.reading import MESSAGE
from foundry.worlds.rounds.rounds_drawing import draw
from foundry.worlds.rounds.table import Decision, Table, read_reply

Play: TypeAlias = Generator[Sequence[Question], list[Decision], None]
"""Yields questions that are asked at once, and receives the decisions in the same order."""


class RoundsScenario(Scenario):
    """A world of rounds; a game is this class with `kinds`, `actions` and `play`.

    Description:
        Agents without a position decide in rounds, at once or in turn.

    Observation:
        `agent`, `agents`, `step`, `persona`, `received`, and the keys that the rules add to a question.

    Questions:
        The questions that `play` yields; those of one `yield` are asked at once.

    Actions:
        The actions of the question's kind in `actions()`; a kind without an entry asks for talk. An unreadable reply
        counts as the idle action, and its recorded action is null.

    Termination:
        When `play` ends.
    """

    form: ClassVar[str] = "rounds"
    records: ClassVar[tuple[type[Record], ...]] = (RoundStep, Message, Agent)

    def __init__(self, *, name: str, agents: int, steps: int, personas: Attributes | None = None) -> None:
        """Set the settings of every world of rounds.

        Args:
            name: name of the world.
            agents: number of agents.
            steps: maximal number of rounds.
            personas: attribute -> value -> weight, drawn independently for each agent.
        """
        for key, value in (("agents", agents), ("steps", steps)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise InputError(f"world.{key}={value} is no number of {key}. Give a whole number from 1.")
        check_attributes(personas or {})
        self.name, self.agents, self.steps = name, agents, steps
        self._attributes = personas or {}

    @abstractmethod
    def play(self, table: Table) -> Play:
        """Play one episode: yield questions, receive decisions, record the results.

        The generator keeps the episode's state in its own variables and draws random numbers from `table.stream`. So
        the same seed and answers give the same records.
        """

    def start(self, seed: int) -> RoundsWorld:
        """Return a fresh episode for this seed."""
        return RoundsWorld(self, seed)

    def personas(self, seed: int) -> list[dict[str, str]]:
        """Return the persona of each agent in the run with this seed."""
        return draw_personas(self._attributes, self.agents, seeding.stream(seed, "personas"))

    def read(self, question: Question, answer: Answer) -> Reading:
        """Return the decision of an answer."""
        return read_reply(question, answer)

    def payoffs(self, question: Question) -> Sequence[float]:
        """Return the payoffs of earlier rounds in the agent's prompt, oldest first; none by default."""
        return ()

    def strata(self, question: Question) -> dict[str, str | bool]:
        """Return whether a message was received, and the last payoff against the mean of the payoffs in the prompt."""
        received = question.observation.get("received")
        return {"message": bool(received), "payoff": _beside_mean(self.payoffs(question))}

    def count_calls(self) -> int:
        """Return the number of calls in an episode that asks every agent once per kind and round."""
        return self.agents * len(self.kinds) * self.steps

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer of this length, with the last option if there is a decision."""
        text = filler(max(characters - 60, 1))
        if question.kind in self.actions() and question.options:
            return json.dumps({**json.loads(question.options[-1]), MESSAGE: text}, ensure_ascii=False)
        return json.dumps({MESSAGE: text})

    def picture(self, lines: Sequence[RoundStep], step: int) -> bytes:
        """Return the state after a step as a PNG with a lane per agent, from the lines of `steps.jsonl` so far."""
        return draw(lines, step, agents=self.agents, steps=self.steps, actions=self.actions())

    def redraw(self, recorded: Recorded) -> Redrawing:
        """Return the pictures of a run."""
        return RoundsRedrawing(self, msgspec.json.Decoder(self.line).decode_lines(recorded.steps))

    @property
    def line(self) -> type[RoundStep]:
        """The class of the lines of `steps.jsonl`."""
        return next(one for one in self.records if issubclass(one, RoundStep))


def _beside_mean(payoffs: Sequence[float]) -> str:
    if not payoffs:
        return "none"
    mean = sum(payoffs) / len(payoffs)
    return "above" if payoffs[-1] > mean else "below" if payoffs[-1] < mean else "at"


class RoundsRedrawing(Redrawing):
    """The pictures of a run, drawn from its lines."""

    def __init__(self, scenario: RoundsScenario, lines: Sequence[RoundStep]) -> None:
        self._scenario = scenario
        self._lines = lines

    @property
    def shows_lanes(self) -> bool:
        """True if the game defines no pictures."""
        return type(self._scenario).picture is RoundsScenario.picture

    def draw(self, step: int) -> bytes:
        """Return the state after a step as a PNG."""
        return self._scenario.picture([line for line in self._lines if line.step <= step], step)


class RoundsWorld(World):
    """The state of one episode, as played so far."""

    def __init__(self, scenario: RoundsScenario, seed: int) -> None:
        """Play up to the first questions."""
        self._scenario = scenario
        self._personas = scenario.personas(seed)
        self._table = Table(seed, self._personas, scenario.actions(), scenario.line)
        self._play = scenario.play(self._table)
        self._asked: Sequence[Question] = ()
        self._finished = False
        self._lines: list[RoundStep] = []
        self._opening = self._go_on(None)

    @property
    def finished(self) -> bool:
        """True if the rules have ended."""
        return self._finished

    @property
    def step(self) -> int:
        """Number of completed rounds."""
        return self._table.step if self._finished else max(self._table.step - 1, 0)

    def opening(self) -> Sequence[Record]:
        """Return the agents' personas, if the world has any, and the records before the first question."""
        personas = [Agent(agent=agent, persona=persona) for agent, persona in enumerate(self._personas) if persona]
        return [*personas, *self._opening]

    def pending(self) -> Sequence[Question]:
        """Return the questions that are open now."""
        return self._asked

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Return the records that the rules wrote after these decisions."""
        if self._finished:
            raise ValueError("the episode is over")
        if len(answers) != len(self._asked):
            raise ValueError(f"{len(answers)} answers for {len(self._asked)} pending questions")
        return self._go_on([self._table.read(*pair) for pair in zip(self._asked, answers, strict=True)])

    def draw(self) -> bytes:
        """Return the present state as a PNG."""
        return self._scenario.picture([line for line in self._lines if line.step <= self.step], self.step)

    def _go_on(self, decisions: Any) -> list[Record]:
        """Play on to the next questions, or to the end; return the new records."""
        try:
            self._asked = tuple(self._play.send(decisions))
            if not self._asked:
                raise FoundryError(f"World '{self._scenario.name}' yielded no question in round {self._table.step}.")
        except StopIteration:
            self._asked, self._finished = (), True
        written = self._table.collect(ended=self._finished)
        self._lines += [record for record in written if isinstance(record, RoundStep)]
        return written
