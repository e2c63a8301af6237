"""The 2D world: agents on a bounded grid send messages to neighbours, then all move at once."""

import itertools
import json
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, ClassVar

import msgspec

from foundry import seeding
from foundry.declared import Actions
from foundry.records import Agent, GridStep, Message, Record
from foundry.worlds.base import Ahead, Answer, Question, Reading, Recorded, Redrawing, Scenario, World, filler
from foundry.worlds.grid.dependence import AgentMemory, GridAhead, is_known
from foundry.worlds.grid.grid_drawing import GridFrame, draw, make_frame
from foundry.worlds.grid.grid_observation import ACTION, MESSAGE, Perception, deliveries, heard, question
from foundry.worlds.grid.grid_settings import GridSettings, read_grid_settings
from foundry.worlds.grid.parsing import ActionReading, MessageReading, read_action, read_message
from foundry.worlds.grid.parts.actions import read_furnished_action
from foundry.worlds.grid.parts.frames import recorded_frames
from foundry.worlds.grid.parts.living import with_roles
from foundry.worlds.grid.parts.parts_records import Fixture, FurnishedStep, fixtures_of, records_of
from foundry.worlds.grid.parts.parts_world import FurnishedWorld
from foundry.worlds.grid.space import OFFSETS, OUTSIDE, Cell
from foundry.worlds.personas import draw_personas


class GridScenario(Scenario):
    """A 2D world of places and fires.

    Description:
        A bounded integer grid with places (rectangles with a capacity) and fires. Agents start outside all places,
        unless the layout lists their cells. Several agents may share a cell, and none blocks another. Only the edge
        limits a move; fires and capacities appear only in the observation. The settings or the seed determine the
        positions of places and fires. A YAML can add further parts (`foundry.worlds.grid.parts`): walls, exits, crowded
        cells, sight, spreading fires, energy and food. With such parts, agents may leave, die or be born.

    Observation:
        See `foundry.worlds.grid.grid_observation`, and for further parts also `foundry.worlds.grid.parts.senses`.

    Questions:
        Each step asks every agent for a message and delivers the messages to its neighbours before the move (same area,
        Euclidean distance within `communication_distance`). Then each step asks every agent for an action.

    Actions:
        Stay, or move by one cell up, down, left or right; all moves happen at once. A move over the edge is recorded
        but has no effect. A reply without a readable decision leaves the agent in place. With energy: gather, share,
        attack, reproduce, as the settings allow.

    Termination:
        After `steps` steps, or when no agent is left.

    Source:
        SD-AgentFoundry-2D, in "Minimal local simulation foundations".
    """

    form: ClassVar[str] = "grid"
    kinds: ClassVar[tuple[str, ...]] = (MESSAGE, ACTION)
    records: ClassVar[tuple[type[Record], ...]] = (GridStep, Message, Agent)

    def __init__(self, **settings: Any) -> None:
        self.settings: GridSettings = read_grid_settings(settings)
        self.name = self.settings.name
        self.grows = self.settings.most_agents > self.settings.agents
        self._ground = self.settings.ground
        if self.settings.furnished:
            self.records = records_of(self.settings)  # type: ignore[misc]  # the settings determine the records
        elif self.settings.draw_positions:
            self.records = (*type(self).records, Fixture)  # type: ignore[misc]

    def start(self, seed: int) -> "GridWorld | FurnishedWorld":
        """Return a fresh episode for this seed."""
        if self.settings.furnished:
            return FurnishedWorld(self.settings, seed, self.personas(seed), self._ground)
        rng = seeding.stream(seed, "layout")
        settings = self.settings.for_seed(seed)
        cells = settings.layout.draw(rng, settings.field, settings.agents)
        return GridWorld(settings, [(x, y) for x, y in cells.tolist()], self.personas(seed))

    def null_arm(self) -> dict[str, Any]:
        """Return the setting that hides fires from agents; {} if no measure needs runs with hidden fires."""
        settings = self.settings
        needed = settings.fires and settings.tell_fires and not settings.draw_positions
        return {"tell_fires": False} if needed and not any(fire.spread for fire in settings.fires) else {}

    def notes(self) -> list[str]:
        """Return a note for each fire that starts after the last step."""
        world, steps = f"world '{self.name}'", self.settings.steps
        late = [fire for fire in self.settings.fires if fire.start > steps]
        return [
            f"{world}: fire '{fire.name}' starts at step {fire.start}, but the run ends at step {steps}"
            for fire in late
        ]

    def read(self, question: Question, answer: Answer) -> Reading:
        """Return the decision in an answer: a message, to stay, or the direction of a move."""
        if question.kind == MESSAGE:
            said = read_message(answer)
            return Reading(said.outcome, message=said.text)
        decided = (
            read_furnished_action(answer, self.settings.further_actions)
            if self.settings.furnished
            else read_action(answer)
        )
        return Reading(decided.outcome, (decided.direction or decided.action) if decided.is_read else None)

    def strata(self, question: Question) -> dict[str, bool]:
        """Return whether the agent perceives a fire, has received a message, and is at a wall or the edge.

        For each of these properties, probes draw as many moments with it as without it.
        """
        seen, edge = question.observation, self.settings.half_size
        at_edge = edge in (abs(seen["x"]), abs(seen["y"]))
        at_wall = at_edge or len(seen.get("open", OFFSETS)) < len(OFFSETS)
        return {"fire": bool(seen["fires"]), "message": bool(seen["received"]), "wall": at_wall}

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer with a long message or memory, whose move leads the agent to the middle of the grid."""
        text = filler(max(characters - 120, 1))
        if question.kind == MESSAGE:
            return json.dumps({"message": text, "reasoning": ""})
        x, y = question.observation["x"], question.observation["y"]
        way = ("left" if x > 0 else "right") if x else ("down" if y > 0 else "up")
        action = {"action": "move", "direction": way} if x or y else {"action": "stay"}
        return json.dumps({**action, "memory": text, "reasoning": ""})

    def actions(self) -> dict[str, Actions]:
        """Return the possible actions: staying, moving in a direction and, for example, gathering food."""
        return {ACTION: Actions(labels=("stay", *OFFSETS, *self.settings.further_actions), idle="stay")}

    def count_calls(self) -> int:
        """Return the maximum number of calls in an episode: two per agent and step."""
        return 2 * self.settings.most_agents * self.settings.steps

    def personas(self, seed: int) -> list[dict[str, str]]:
        """Return the persona of each agent in the run with this seed, including agents that may be born."""
        rng = seeding.stream(seed, "personas")
        return with_roles(self.settings, draw_personas(self.settings.personas, self.settings.most_agents, rng))

    def redraw(self, recorded: Recorded) -> "GridRedrawing":
        """Return the pictures of a run."""
        kind = next(record for record in self.records if issubclass(record, GridStep))
        frames = list(self.frames(recorded.seed, msgspec.json.Decoder(kind).decode_lines(recorded.steps)))
        return GridRedrawing(frames or [self.start(recorded.seed).frame()])

    def frames(self, seed: int, records: Iterable[GridStep]) -> Iterator[GridFrame]:
        """Yield the frames of a run, rebuilt from its records: the initial state, then one per step."""
        personas = self.personas(seed)
        if self.settings.furnished:
            lines = [record for record in records if isinstance(record, FurnishedStep)]
            yield from recorded_frames(self.settings, self._ground, personas, seed, lines)
            return
        settings = self.settings.for_seed(seed)
        for step, group in itertools.groupby(records, key=lambda record: record.step):
            rows = list(group)
            if step == 1:
                yield make_frame(settings, personas, 0, [(row.x, row.y) for row in rows])
            yield make_frame(settings, personas, step, [(row.x_next, row.y_next) for row in rows])


class GridRedrawing(Redrawing):
    """The pictures of a run, drawn from its frames, the initial state first."""

    def __init__(self, frames: Sequence[GridFrame]) -> None:
        self._frames = frames

    def draw(self, step: int) -> bytes:
        """Return the state after a step as a PNG."""
        return draw(self._frames[step])


class GridWorld(World):
    """The state of one 2D episode."""

    def __init__(self, settings: GridSettings, cells: Sequence[Cell], personas: Sequence[dict[str, str]]) -> None:
        self._settings = settings
        self._field = settings.field
        self._cells = list(cells)
        self._personas = personas
        self._perception = Perception(settings, personas)
        self._memories = [deque[str](maxlen=settings.history.memory) for _ in cells]
        self._received = [deque[dict[str, Any]](maxlen=settings.history.messages) for _ in cells]
        self._completed = 0
        self._said: list[MessageReading] | None = None
        self._scene = self._perception.observe(1, self._cells)

    @property
    def finished(self) -> bool:
        """True if all steps are done."""
        return self._completed >= self._settings.steps

    @property
    def step(self) -> int:
        """Number of completed steps."""
        return self._completed

    def opening(self) -> Sequence[Record]:
        """Return a record per agent that has a persona, and one per place or fire whose position the seed drew."""
        personas = [Agent(agent=agent, persona=persona) for agent, persona in enumerate(self._personas) if persona]
        return [*personas, *fixtures_of(self._settings)]

    def pending(self) -> Sequence[Question]:
        """Return the message question of every agent; after their answers, the action question of every agent."""
        if self.finished:
            return ()
        said: Iterable[MessageReading | None] = self._said or itertools.repeat(None)
        return list(map(question, self._scene.observations, self._memories, self._received, said))

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Return the delivered messages, sorted by sender and recipient; after actions, the step of each agent."""
        if self.finished:
            raise ValueError("the episode is over")
        if len(answers) != len(self._cells):
            raise ValueError(f"advance() got {len(answers)} answers for {len(self._cells)} pending questions")
        if self._said is None:
            self._said = list(map(read_message, answers))
            return self._deliver(self._said)
        said, self._said = self._said, None
        return self._move(said, list(map(read_action, answers)))

    def draw(self) -> bytes:
        """Return the present state as a PNG."""
        return draw(self.frame())

    def ahead(self) -> Ahead | None:
        """Return an object that asks some agents before others have completed the same step.

        Return None in the middle of a step, and if settings or code may break the rule of the module `dependence`.
        """
        if self._said is not None or type(self) is not GridWorld or not is_known(self._settings):
            return None
        inputs = list(map(AgentMemory, self._memories, self._received))
        step = self._completed + 1
        return GridAhead(self._settings, self._perception, self._target, step, self._cells, inputs)

    def frame(self) -> GridFrame:
        """Return the data from which a picture of the present state is drawn."""
        return make_frame(self._settings, self._personas, self._completed, self._cells)

    def _deliver(self, said: Sequence[MessageReading]) -> list[Message]:
        delivered = deliveries(self._completed + 1, enumerate(said), self._scene.neighbours)
        for message in delivered:
            self._received[message.recipient].append(heard(message))
        return delivered

    def _move(self, said: Sequence[MessageReading], actions: Sequence[ActionReading]) -> list[GridStep]:
        records = []
        for agent, (message, action) in enumerate(zip(said, actions, strict=True)):
            records.append(self._record(agent, message, action))
            if action.is_kept:
                self._memories[agent].append(action.memory)
        self._cells = [(record.x_next, record.y_next) for record in records]
        self._completed += 1
        if not self.finished:
            self._scene = self._perception.observe(self._completed + 1, self._cells)
        return records

    def _record(self, agent: int, message: MessageReading, action: ActionReading) -> GridStep:
        cell = self._cells[agent]
        arrived = self._target(cell, action.direction)
        area = self._scene.areas[agent]
        return GridStep(
            step=self._completed + 1,
            agent=agent,
            place=None if area == OUTSIDE else self._settings.places[area].name,
            **self._scene.step_of(agent, cell, arrived, message, action),
        )

    def _target(self, cell: Cell, direction: str | None) -> Cell:
        """Return the cell after a move; a move over the edge ends in the cell where it began."""
        if direction is None:
            return cell
        dx, dy = OFFSETS[direction]
        target = (cell[0] + dx, cell[1] + dy)
        return target if target in self._field else cell
