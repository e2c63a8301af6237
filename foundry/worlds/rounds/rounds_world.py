"""The base class of worlds in rounds, whose rules are a generator that yields questions and receives decisions."""

from __future__ import annotations

import io
import json
from abc import abstractmethod
from collections.abc import Generator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import msgspec

from foundry import seeding
from foundry.declared import Actions
from foundry.errors import FoundryError
from foundry.palette import label_colour
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.base import Answer, Question, Reading, Recorded, Redrawing, Scenario, World, filler
from foundry.worlds.personas import Attributes, check_attributes, draw_personas
from foundry.worlds.rounds.reading import MESSAGE
from foundry.worlds.rounds.table import Decision, Table, read_reply
from foundry.worlds.validation import check_number

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw


SIZE = (800, 500)
"""Pixels."""
IDLE = "#5F6670"
"""Colour of idle actions."""
UNREAD, TALK, WORDS = "#FFFFFF", "#E4E4EC", "#333344"
LOW, HIGH = (239, 243, 255), (8, 81, 156)
"""Colours of the smallest and of the largest decision in the picture, RGB; decisions between them get a mixture."""
_LEFT, _TOP, _RIGHT, _BOTTOM = 56, 40, 784, 440
MOST_NUMBERED = 30
"""Largest number of agents with which the picture shows their ids; more ids would overlap."""
LONGEST = 24
"""Maximum number of characters that the picture's legend shows of a label."""


def draw(lines: Sequence[RoundStep], step: int, *, agents: int, steps: int, actions: Mapping[str, Actions]) -> bytes:
    """Return a PNG with a row per agent and a column per round; several decisions in a round stand side by side."""
    from PIL import Image, ImageDraw

    image = Image.new("RGB", SIZE, "white")
    canvas = ImageDraw.Draw(image)
    width, height = (_RIGHT - _LEFT) / max(steps, step, 1), (_BOTTOM - _TOP) / agents
    ranges = {kind: _with_ends(known, kind, lines) for kind, known in actions.items()}
    canvas.text((_LEFT, 12), f"Round {step}", fill=WORDS)
    canvas.rectangle((_LEFT - 1, _TOP - 1, _RIGHT, _BOTTOM), outline="#AAAAB4")
    for agent in range(agents) if agents <= MOST_NUMBERED else ():
        _, top, _, bottom = _box(width, height, agent, 1)
        canvas.text((_LEFT - 28, (top + bottom) // 2 - 6), str(agent), fill=WORDS)
    for (when, agent), group in groupby(sorted(lines, key=_place), key=_place):
        own = list(group)
        for part, line in enumerate(own):
            box = _box(width, height, agent, when, part, len(own))
            canvas.rectangle(box, fill=_colour(line, ranges), outline="#C8C8D0" if line.action is None else None)
    _legend(canvas, ranges)
    png = io.BytesIO()
    image.save(png, format="PNG")
    return png.getvalue()


def _box(
    width: float, height: float, agent: int, step: int, part: int = 0, parts: int = 1
) -> tuple[int, int, int, int]:
    """Return the first and the last pixel (x, y, x, y) of an agent's decision in a round."""
    gap = 2 if min(width / parts, height) > 4 else 1
    left, right = (_LEFT + (step - 1 + edge / parts) * width for edge in (part, part + 1))
    x, y = round(left), round(_TOP + agent * height)
    return (x, y, max(round(right) - gap, x), max(round(_TOP + (agent + 1) * height) - gap, y))


def _with_ends(known: Actions, kind: str, lines: Sequence[RoundStep]) -> Actions:
    """Return actions with both bounds; the smallest or largest recorded decision replaces a missing bound."""
    numbers = [line.action for line in lines if line.kind == kind and isinstance(line.action, int | float)]
    low = min(numbers, default=0) if known.low is None else known.low
    high = max(numbers, default=1) if known.high is None else known.high
    return msgspec.structs.replace(known, low=low, high=high)


def _place(line: RoundStep) -> tuple[int, int]:
    return (line.step, line.agent)


def _colour(line: RoundStep, actions: Mapping[str, Actions]) -> str:
    known = actions.get(line.kind)
    if known is None:
        return TALK
    if line.action is None:
        return UNREAD
    if line.action in known.labels:
        return _tone(str(line.action), known)
    return _shade(float(line.action), known) if isinstance(line.action, int | float) else TALK


def _tone(label: str, known: Actions) -> str:
    place = known.labels.index(label)
    if label == known.idle:
        return IDLE
    return label_colour(place)


def _shade(number: float, known: Actions) -> str:
    low, high = known.low or 0.0, known.high or 0.0
    share = min(max((number - low) / (high - low), 0.0), 1.0) if high > low else 0.0
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in zip(LOW, HIGH, strict=True))


def _legend(canvas: ImageDraw, actions: Mapping[str, Actions]) -> None:
    x, y = float(_LEFT), float(_BOTTOM + 14)
    for kind, known in actions.items():
        for label in known.labels or (f"{kind}: {known.low:g} to {known.high:g}",):
            colour = _tone(label, known) if known.labels else _shade(known.high or 0.0, known)
            text = label if len(label) <= LONGEST else f"{label[:LONGEST]}..."
            if x + 24 + canvas.textlength(text) > _RIGHT:
                x, y = float(_LEFT), y + 18
            canvas.rectangle((x, y, x + 11, y + 11), fill=colour)
            canvas.text((x + 16, y), text, fill=WORDS)
            x += 34 + canvas.textlength(text)


Play: TypeAlias = Generator[Sequence[Question], list[Decision], None]
"""Generator of an episode: it yields lists of questions that are asked together, and receives their decisions in
order.
"""


class RoundsScenario(Scenario):
    """A world that is played in rounds. Each game is a subclass with its own questions, actions and rules (`play`).

    Description:
        Agents without a position decide in rounds, at once or in turn.

    Observation:
        `agent`, `agents`, `step`, `persona`, `received`, and the keys that the rules add to a question.

    Questions:
        The questions that `play` yields; the questions of one `yield` are asked at once.

    Actions:
        The actions of the question's kind in `actions()`; a kind without an entry asks for talk. An unreadable reply
        counts as the idle action, and its recorded action is null.

    Termination:
        When `play` ends.
    """

    form: ClassVar[str] = "rounds"
    records: ClassVar[tuple[type[Record], ...]] = (RoundStep, Message, Agent)

    def __init__(self, *, name: str, agents: int, steps: int, personas: Attributes | None = None) -> None:
        """Take the settings that every world in rounds has.

        Args:
            name: name of the world.
            agents: number of agents.
            steps: maximum number of rounds.
            personas: attribute -> value -> weight, drawn independently for each agent.
        """
        for key, value in (("agents", agents), ("steps", steps)):
            check_number(f"world.{key}", value, 1, whole=True)
        check_attributes(personas or {})
        self.name, self.agents, self.steps = name, agents, steps
        self._attributes = personas or {}

    @abstractmethod
    def play(self, table: Table) -> Play:
        """Play one episode: yield lists of questions, receive the agents' decisions, and record the results.

        The generator keeps the episode's state in its own variables and draws random numbers from `table.stream`.
        Because of this, the same seed and answers give the same records.
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
        """Return the agent's payoffs of earlier rounds, oldest first, as its prompt shows them; none by default."""
        return ()

    def strata(self, question: Question) -> dict[str, str | bool]:
        """Return whether the agent got a message, and whether its last payoff is above or below its mean payoff."""
        received = question.observation.get("received")
        return {"message": bool(received), "payoff": _beside_mean(self.payoffs(question))}

    def count_calls(self) -> int:
        """Return the number of calls in an episode, if each agent gets one question of each kind per round."""
        return self.agents * len(self.kinds) * self.steps

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer of this length: the last option and a long message, or (in talk) only the message."""
        text = filler(max(characters - 60, 1))
        if question.kind in self.actions() and question.options:
            return json.dumps({**json.loads(question.options[-1]), MESSAGE: text}, ensure_ascii=False)
        return json.dumps({MESSAGE: text})

    def picture(self, lines: Sequence[RoundStep], step: int) -> bytes:
        """Return a PNG of the state after a step, drawn from the recorded lines of all steps so far."""
        return draw(lines, step, agents=self.agents, steps=self.steps, actions=self.actions())

    def redraw(self, recorded: Recorded) -> Redrawing:
        """Return an object that draws the recorded run."""
        return RoundsRedrawing(self, msgspec.json.Decoder(self.line).decode_lines(recorded.steps))

    @property
    def line(self) -> type[RoundStep]:
        """The class of the records in `steps.jsonl` of this world."""
        return next(record for record in self.records if issubclass(record, RoundStep))


def _beside_mean(payoffs: Sequence[float]) -> str:
    if not payoffs:
        return "none"
    mean = sum(payoffs) / len(payoffs)
    return "above" if payoffs[-1] > mean else "below" if payoffs[-1] < mean else "at"


class RoundsRedrawing(Redrawing):
    """Draws the states of a run from the lines of its `steps.jsonl`."""

    def __init__(self, scenario: RoundsScenario, lines: Sequence[RoundStep]) -> None:
        self._scenario = scenario
        self._lines = lines

    @property
    def shows_lanes(self) -> bool:
        """True if the game draws no pictures of its own."""
        return type(self._scenario).picture is RoundsScenario.picture

    def draw(self, step: int) -> bytes:
        """Return the state after a step as a PNG."""
        return self._scenario.picture([line for line in self._lines if line.step <= step], step)


class RoundsWorld(World):
    """One episode of a world in rounds: its state after the rounds played so far."""

    def __init__(self, scenario: RoundsScenario, seed: int) -> None:
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
        """True if the episode is over."""
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
        """Read the decisions in the answers, and hand them to the game's rules (`play`); return the new records."""
        if self._finished:
            raise ValueError("the episode is over")
        if len(answers) != len(self._asked):
            raise ValueError(f"advance() got {len(answers)} answers for {len(self._asked)} pending questions")
        return self._go_on([self._table.read(*pair) for pair in zip(self._asked, answers, strict=True)])

    def draw(self) -> bytes:
        """Return the present state as a PNG."""
        return self._scenario.picture([line for line in self._lines if line.step <= self.step], self.step)

    def _go_on(self, decisions: Any) -> list[Record]:
        try:
            self._asked = tuple(self._play.send(decisions))
            if not self._asked:
                raise FoundryError(f"World '{self._scenario.name}' yielded no question in round {self._table.step}.")
        except StopIteration:
            self._asked, self._finished = (), True
        written = self._table.collect(ended=self._finished)
        self._lines += [record for record in written if isinstance(record, RoundStep)]
        return written
