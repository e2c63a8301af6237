"""An episode of a 2D world in which agents leave, die and are born, fires spread, and food grows."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from foundry import seeding
from foundry.records import Agent, Message, Record
from foundry.worlds.base import Answer, Question, World
from foundry.worlds.grid.grid_drawing import GridFrame, draw
from foundry.worlds.grid.grid_observation import ACTION, IDLE, deliveries, heard, question
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.parsing import MessageReading, read_message
from foundry.worlds.grid.parts.actions import FurnishedAction, read_furnished_action, reply
from foundry.worlds.grid.parts.frames import furnished_frame
from foundry.worlds.grid.parts.living import NOTHING, ActionResult, Body, Living, first_bodies
from foundry.worlds.grid.parts.parts_records import Birth, Burning, FurnishedStep, Growing, LivingStep
from foundry.worlds.grid.parts.senses import Senses
from foundry.worlds.grid.parts.terrain import (
    FoodSupply,
    Ground,
    MoveResult,
    SpreadingFires,
    WayOut,
    is_within,
    moves_of,
)
from foundry.worlds.grid.space import OFFSETS, OUTSIDE, Cell


class FurnishedWorld(World):
    """The state of a 2D episode with arrivals and departures of agents.

    In each step fires spread, and agents write messages and decide on actions. Further actions happen first, then
    moves, both in a random order drawn for the step. Agents lose energy, and die without energy or may die in a
    dangerous cell. Finally, food grows. The episode ends after the last step, or when no agent is left. No question can
    be asked ahead, since every action may change the cells that all agents share.
    """

    def __init__(self, settings: GridSettings, seed: int, personas: Sequence[dict[str, str]], ground: Ground) -> None:
        self._settings = settings
        self._ground = ground
        self._personas = personas
        self._senses = Senses(settings, personas, ground)
        self._turns, self._chance = seeding.stream(seed, "turns"), seeding.stream(seed, "risk")
        self._spreading_fires = SpreadingFires(settings.fires, ground, seed)
        self._food_supply = None if settings.food is None else FoodSupply(settings.food, ground, seed)
        self._bodies: dict[int, Body] = first_bodies(settings, ground, seed)
        self._living = Living(
            settings,
            ground,
            self._bodies,
            food_supply=self._food_supply,
            rng=seeding.stream(seed, "births"),
        )
        self._plan = WayOut(ground, settings.exits, {agent: body.cell for agent, body in self._bodies.items()})
        self._gone: Counter[str] = Counter()
        self._completed = 0
        self._said: dict[int, MessageReading] | None = None
        self._opening = [*self._grown({}), *self._go_on()]

    @property
    def finished(self) -> bool:
        """True if all steps are done or all agents have left or died."""
        return self._completed >= self._settings.steps or not self._bodies

    @property
    def step(self) -> int:
        """Number of completed steps."""
        return self._completed

    def opening(self) -> Sequence[Record]:
        """Return the personas of the agents, the cells with food, and the burning cells."""
        personas = [Agent(agent=agent, persona=self._personas[agent]) for agent in range(self._settings.agents)]
        return [*(persona for persona in personas if persona.persona), *self._opening]

    def pending(self) -> Sequence[Question]:
        """Return the message questions of all present agents; once these are answered, the action questions."""
        if self.finished:
            return ()
        burning = frozenset(self._spreading_fires.cells)
        questions = []
        for agent, perceived in zip(self._bodies, self._scene.observations, strict=True):
            body, said = self._bodies[agent], None if self._said is None else self._said[agent]
            asked = question(perceived, body.memories, body.received, said)
            if said is not None:
                secret = self._plan.secret(agent, body.cell, known=body.known, burning=burning)
                asked = replace(asked, secret=secret, options=self._options(agent, perceived))
            questions.append(asked)
        return questions

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Take the answers. Return the messages, sorted by sender and recipient; after actions, all other records."""
        if self.finished:
            raise ValueError("the episode is over")
        if len(answers) != len(self._bodies):
            raise ValueError(f"advance() got {len(answers)} answers for {len(self._bodies)} pending questions")
        if self._said is None:
            self._said = dict(zip(self._bodies, map(read_message, answers), strict=True))
            return self._deliver(self._said)
        said, self._said = self._said, None
        decisions = [read_furnished_action(answer, self._settings.further_actions) for answer in answers]
        return self._act(said, dict(zip(self._bodies, decisions, strict=True)))

    def draw(self) -> bytes:
        """Return the present state as a PNG."""
        return draw(self.frame())

    def frame(self) -> GridFrame:
        """Return the data from which a picture of the present state is drawn."""
        return furnished_frame(
            self._settings,
            self._ground,
            self._personas,
            self._completed,
            bodies={agent: body.cell for agent, body in self._bodies.items()},
            burning=tuple(self._spreading_fires.cells),
            food={} if self._food_supply is None else dict(self._food_supply.food),
            gone=self._gone,
        )

    def _options(self, agent: int, observation: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the legal replies: to stay, to move in a direction without a wall and, for example, to gather."""
        decisions = self._living.possible(agent, observation["touchable"]) if self._settings.further_actions else ()
        replies = [reply(decision.action, target=decision.target, amount=decision.amount) for decision in decisions]
        return (IDLE[ACTION], *map(reply, observation["open"]), *replies)

    def _go_on(self) -> list[Record]:
        """Begin the next step: let fires spread, and make the observations; return the cells that caught fire."""
        step = self._completed + 1
        caught = self._spreading_fires.go_on(step)
        self._scene = self._senses.look(
            step,
            {agent: body.cell for agent, body in self._bodies.items()},
            spreading_fires=self._spreading_fires,
            known={agent: body.known for agent, body in self._bodies.items()},
            energy={agent: body.energy for agent, body in self._bodies.items()} if self._settings.energy else {},
            food={} if self._food_supply is None else self._food_supply.food,
        )
        return [Burning(step=step, x=x, y=y, fire=fire.name) for (x, y), fire in caught.items()]

    def _grown(self, before: Mapping[Cell, int]) -> list[Record]:
        """Return a record per cell whose amount of food has changed since `before`."""
        now = {} if self._food_supply is None else self._food_supply.food
        changed = [cell for cell in sorted({*before, *now}) if before.get(cell, 0) != now.get(cell, 0)]
        return [Growing(step=self._completed, x=x, y=y, amount=now.get((x, y), 0)) for x, y in changed]

    def _deliver(self, said: Mapping[int, MessageReading]) -> list[Message]:
        delivered = deliveries(self._completed + 1, said.items(), self._scene.neighbours)
        for message in delivered:
            self._bodies[message.recipient].received.append(heard(message))
        return delivered

    def _act(self, said: Mapping[int, MessageReading], decisions: Mapping[int, FurnishedAction]) -> list[Record]:
        before = dict(self._bodies)
        cells = {agent: body.cell for agent, body in before.items()}
        energy = {agent: body.energy for agent, body in before.items()}
        food = {} if self._food_supply is None else dict(self._food_supply.food)
        order = [list(before)[index] for index in self._turns.permutation(len(before)).tolist()]
        done = self._living.do([(agent, decisions[agent]) for agent in order])
        moved = self._move(decisions, order)
        lost = self._lose(before, moved)
        self._gone.update(move.left for move in moved.values() if move.left is not None)
        self._gone.update(lost.values())
        if self._food_supply is not None:
            self._food_supply.grow(self._completed + 1)
        records: list[Record] = [
            self._record(index, agent, message=said[agent], decision=decisions[agent], moved=moved[agent],
                         lost=lost.get(agent), cell=cells[agent], energy=energy[agent], done=done.get(agent, NOTHING),
                         food=food.get(cells[agent], 0))
            for index, agent in enumerate(before)
        ]  # fmt: skip
        self._remember(decisions)
        self._completed += 1
        births = [
            Birth(agent=did.born[0], persona=self._personas[did.born[0]], parent=agent, step=self._completed)
            for agent, did in sorted(done.items())
            if did.born is not None
        ]
        records += [*births, *self._grown(food)]
        return records if self.finished else [*records, *self._go_on()]

    def _move(self, decisions: Mapping[int, FurnishedAction], order: Sequence[int]) -> dict[int, MoveResult]:
        """Carry out all moves, and remove the agents that leave."""
        cells = {agent: body.cell for agent, body in self._bodies.items()}
        wanted: dict[int, Cell] = {}
        for agent, decision in decisions.items():
            if decision.direction is not None:
                dx, dy = OFFSETS[decision.direction]
                wanted[agent] = (cells[agent][0] + dx, cells[agent][1] + dy)
        moving = [agent for agent in order if agent in wanted]
        moved = moves_of(self._ground, self._settings.cell_capacity, cells, wanted, moving)
        for agent, move in moved.items():
            self._bodies[agent].cell = move.cell
            if move.left is not None:
                del self._bodies[agent]
        return moved

    def _lose(self, before: Mapping[int, Body], moved: Mapping[int, MoveResult]) -> dict[int, str]:
        """Take energy from all remaining agents, and remove those that die; return the cause of each death."""
        lost: dict[int, str] = {}
        for agent, body in before.items():
            if moved[agent].left is not None:
                continue
            cause = self._danger(body.cell)
            if self._settings.energy is not None:
                body.energy = max(0, body.energy - self._settings.energy.loss)
                if not body.energy:
                    cause = "attack" if body.robbed else "energy"
            body.robbed = False
            if cause is not None:
                lost[agent] = cause
                del self._bodies[agent]
        return lost

    def _danger(self, cell: Cell) -> str | None:
        """Draw for each danger in this cell whether it kills the agent; return the first one that does, or None."""
        dangers = [(zone.name, zone.risk) for zone in self._settings.zones if is_within(cell, zone.corners)]
        fire = self._spreading_fires.cells.get(cell)
        dangers += [] if fire is None else [(fire.name, fire.risk)]
        struck = [name for name, risk in dangers if risk and self._chance.random() < risk]
        return struck[0] if struck else None

    def _remember(self, decisions: Mapping[int, FurnishedAction]) -> None:
        for agent, body in self._bodies.items():
            decision = decisions.get(agent)
            if decision is not None and decision.is_kept:
                body.memories.append(decision.memory)

    def _record(
        self,
        index: int,
        agent: int,
        *,
        message: MessageReading,
        decision: FurnishedAction,
        moved: MoveResult,
        lost: str | None,
        cell: Cell,
        energy: int,
        done: ActionResult,
        food: int,
    ) -> FurnishedStep:
        area = self._scene.areas[index]
        observation = self._scene.observations[index]
        plain: dict[str, Any] = {
            "step": self._completed + 1,
            "agent": agent,
            "place": None if area == OUTSIDE else self._settings.places[area].name,
            **self._scene.step_of(index, cell, moved.cell, message, decision),
            "exits": tuple(way_out["name"] for way_out in observation["exits"]),
            "blocked": moved.blocked,
            "left": moved.left,
            "lost": lost,
        }
        if self._settings.energy is None:
            return FurnishedStep(**plain)
        body = self._bodies.get(agent)
        left = 0 if body is None else body.energy
        return LivingStep(**plain, energy=energy, energy_next=left, target=decision.target, amount=done.amount,
                          born=done.born, food=food)  # fmt: skip
