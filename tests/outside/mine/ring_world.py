"""A world of a form that foundry does not ship: agents on a ring of places, which they go round either way."""

import io
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import msgspec
from numpy.random import Generator
from PIL import Image

from foundry import (
    Actions,
    Agent,
    Answer,
    Outcome,
    Question,
    Record,
    Recorded,
    Redrawing,
    RoundStep,
    Scenario,
    ScriptedModel,
    World,
    stream,
)
from foundry.worlds.base import unanswered, undecided_outcome

WAYS = {"stay": 0, "on": 1, "back": -1}


class RingStep(RoundStep, frozen=True, kw_only=True):
    """A step on the ring: where it began, where it ended."""

    place: int
    place_next: int


class Lap(Record, frozen=True, kw_only=True):
    """A whole time round the ring (`laps.jsonl`)."""

    stream: ClassVar[str] = "laps"
    step: int
    agent: int


class Ring(World):
    """The state: where each agent is, counted on and on."""

    def __init__(self, scenario: "RingScenario", seed: int) -> None:
        self.scenario, self.seed, self.done = scenario, seed, 0
        self.at = stream(seed, "starts").integers(scenario.places, size=scenario.agents).tolist()

    @property
    def finished(self) -> bool:
        return self.done >= self.scenario.steps

    @property
    def step(self) -> int:
        return self.done

    def opening(self) -> Sequence[Record]:
        return [Agent(agent=agent, persona=one) for agent, one in enumerate(self.scenario.personas(self.seed))]

    def pending(self) -> Sequence[Question]:
        return [] if self.finished else [self._question(agent) for agent in range(self.scenario.agents)]

    def _question(self, agent: int) -> Question:
        told = {"agent": agent, "place": self.at[agent] % self.scenario.places, "step": self.done + 1}
        return Question(self.done + 1, agent, "way", told, options=tuple(WAYS), idle="stay")

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        self.done += 1
        rows = [self._row(agent, answer) for agent, answer in enumerate(answers)]
        laps = [Lap(step=self.done, agent=row.agent) for row in rows if row.place_next == 0 != row.place]
        return [*rows, *laps]

    def _row(self, agent: int, answer: Answer) -> RingStep:
        way = answer.text.strip() if unanswered(answer) is None else ""
        outcome = unanswered(answer) or (Outcome.CHOSEN if way in WAYS else undecided_outcome(answer))
        before = self.at[agent] % self.scenario.places
        self.at[agent] += WAYS.get(way, 0)
        return RingStep(
            step=self.done, agent=agent, kind="way", action=way if way in WAYS else None, outcome=outcome,
            utility=float(WAYS.get(way, 0)), place=before, place_next=self.at[agent] % self.scenario.places,
        )  # fmt: skip

    def draw(self) -> bytes:
        return strip(self.scenario.places, self.at)


def strip(places: int, at: Sequence[int]) -> bytes:
    """Return the places in a row, lit where somebody is."""
    image = Image.new("L", (places, 1))
    image.putdata([255 * (place in [one % places for one in at]) for place in range(places)])
    png = io.BytesIO()
    image.save(png, format="PNG")
    return png.getvalue()


class Strips(Redrawing):
    """The pictures from the records."""

    def __init__(self, scenario: "RingScenario", recorded: Recorded) -> None:
        self.scenario, self.seed = scenario, recorded.seed
        self.rows = msgspec.json.Decoder(RingStep).decode_lines(recorded.steps)

    def draw(self, step: int) -> bytes:
        at = [row.place_next for row in self.rows if row.step == step] or Ring(self.scenario, self.seed).at
        return strip(self.scenario.places, at)


class RingScenario(Scenario):
    """A ring of places."""

    form: ClassVar[str] = "ring"
    kinds: ClassVar[tuple[str, ...]] = ("way",)
    records: ClassVar[tuple[type[Record], ...]] = (RingStep, Agent, Lap)

    def __init__(self, name: str, places: int = 5, agents: int = 4, steps: int = 6) -> None:
        self.name, self.places, self.agents, self.steps = name, places, agents, steps

    def start(self, seed: int) -> World:
        return Ring(self, seed)

    def redraw(self, recorded: Recorded) -> Redrawing:
        return Strips(self, recorded)

    def actions(self) -> Mapping[str, Actions]:
        return {"way": Actions(labels=tuple(WAYS), idle="stay")}

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        return [{"mood": "restless" if agent % 2 else "calm"} for agent in range(self.agents)]

    def count_calls(self) -> int:
        return self.agents * self.steps


class Walker(ScriptedModel):
    """Goes on, or back, or mumbles; who is odd never stays."""

    def way(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return str(rng.choice(["on", "back", "on", "hm"] if observation["agent"] % 2 else ["stay", "on"]))
