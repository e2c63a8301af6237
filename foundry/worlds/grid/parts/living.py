"""The state of the present agents, and the changes that the actions gather, share, attack and reproduce make."""

from collections import Counter, deque
from collections.abc import MutableMapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from numpy.random import Generator

from foundry import seeding
from foundry.records import Outcome
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.parts.actions import FurnishedAction
from foundry.worlds.grid.parts.parts_settings import ATTACK, GATHER, REPRODUCE, SHARE
from foundry.worlds.grid.parts.senses import TOUCH, apart
from foundry.worlds.grid.parts.terrain import FoodSupply, Ground, next_to
from foundry.worlds.grid.space import Cell


@dataclass(slots=True)
class Body:
    """The state of a present agent.

    Attributes:
        energy: the agent's energy; 0 in a world without energy.
        known: names of the exits that the agent knows.
        memories: the agent's memories, oldest first.
        received: messages from others, oldest first.
        robbed: whether the agent was attacked in this step.
    """

    cell: Cell
    energy: int = 0
    known: set[str] = field(default_factory=set)
    memories: deque[str] = field(default_factory=deque)
    received: deque[dict[str, Any]] = field(default_factory=deque)
    robbed: bool = False


@dataclass(frozen=True, slots=True)
class ActionResult:
    """The result of an agent's action gather, share, attack or reproduce.

    Attributes:
        amount: energy that was gathered, shared or taken.
        born: id and cell (x, y) of a newborn, or None.
    """

    amount: int = 0
    born: tuple[int, int, int] | None = None


NOTHING = ActionResult()


class Living:
    """Carries out the actions gather, share, attack and reproduce, one after the other, before any agent moves.

    The sum of all energy changes only by gathering, by the cost of attacks, and if an attacker gets more than it can
    hold.
    """

    def __init__(
        self,
        settings: GridSettings,
        ground: Ground,
        bodies: MutableMapping[int, Body],
        *,
        food_supply: FoodSupply | None,
        rng: Generator,
    ) -> None:
        """Take the state of the episode, which the actions will change.

        Args:
            settings: the world.
            ground: the walls and exits of the world.
            bodies: present agents by id; newborns are added.
            food_supply: the food, if the world has any.
            rng: draws the cells of newborns.
        """
        self._settings = settings
        self._ground = ground
        self._bodies = bodies
        self._food_supply = food_supply
        self._rng = rng
        self._ever = len(bodies)
        self._actions = {GATHER: self._gather, SHARE: self._share, ATTACK: self._attack, REPRODUCE: self._reproduce}

    def do(self, decisions: Sequence[tuple[int, FurnishedAction]]) -> dict[int, ActionResult]:
        """Carry out the agents' actions in the given order; impossible actions have no effect."""
        return {
            agent: self._actions[decision.action](agent, decision)
            for agent, decision in decisions
            if decision.action in self._actions
        }

    def possible(self, agent: int, touchable: Sequence[int]) -> list[FurnishedAction]:
        """Return the actions that an agent can do now, besides staying and moving; sharing is listed with amount 1."""
        body, settings = self._bodies[agent], self._settings
        actions = []
        if self._food_supply is not None and body.cell in self._food_supply.food:
            actions.append(FurnishedAction(Outcome.CHOSEN, GATHER))
        if settings.sharing and body.energy > 1:
            actions += [FurnishedAction(Outcome.CHOSEN, SHARE, target=other, amount=1) for other in touchable]
        if settings.attack is not None:
            actions += [FurnishedAction(Outcome.CHOSEN, ATTACK, target=other) for other in touchable]
        if self._may_reproduce(body):
            actions.append(FurnishedAction(Outcome.CHOSEN, REPRODUCE))
        return actions

    def _gather(self, agent: int, _: FurnishedAction) -> ActionResult:
        body = self._bodies[agent]
        taken = 0 if self._food_supply is None else self._food_supply.take(body.cell, self._room(body))
        body.energy += taken
        return ActionResult(taken)

    def _share(self, agent: int, decision: FurnishedAction) -> ActionResult:
        giver, taker = self._bodies[agent], self._other(agent, decision)
        if taker is None or decision.amount is None:
            return NOTHING
        given = min(decision.amount, giver.energy, self._room(taker))
        giver.energy -= given
        taker.energy += given
        return ActionResult(given)

    def _attack(self, agent: int, decision: FurnishedAction) -> ActionResult:
        attacker, attacked = self._bodies[agent], self._other(agent, decision)
        if attacked is None or self._settings.attack is None:
            return NOTHING
        taken = min(self._settings.attack.takes, attacked.energy)
        attacked.energy -= taken
        attacked.robbed = True
        paid = min(self._settings.attack.cost, attacker.energy + taken)
        attacker.energy -= paid
        attacker.energy += min(taken, self._room(attacker))
        return ActionResult(taken)

    def _reproduce(self, agent: int, _: FurnishedAction) -> ActionResult:
        parent = self._bodies[agent]
        if not self._may_reproduce(parent) or self._settings.reproduction is None:
            return NOTHING
        places = [cell for cell in (parent.cell, *next_to(parent.cell)) if self._has_room(cell)]
        if not places:
            return NOTHING
        cell = places[int(self._rng.integers(len(places)))]
        given = min(self._settings.reproduction.gives, parent.energy)
        parent.energy -= given
        child, self._ever = self._ever, self._ever + 1
        self._bodies[child] = new_body(self._settings, cell, given)
        return ActionResult(born=(child, *cell))

    def _may_reproduce(self, body: Body) -> bool:
        rule = self._settings.reproduction
        return rule is not None and body.energy >= rule.needs and self._ever < rule.most

    def _other(self, agent: int, decision: FurnishedAction) -> Body | None:
        """Return the agent at which an action aims; None if it is the acting agent itself, absent or out of reach."""
        other = self._bodies.get(-1 if decision.target is None else decision.target)
        near = other is not None and apart(other.cell, self._bodies[agent].cell) <= TOUCH
        return other if near and decision.target != agent else None

    def _room(self, body: Body) -> int:
        most = None if self._settings.energy is None else self._settings.energy.most
        return max(0, most - body.energy) if most is not None else 10**9

    def _has_room(self, cell: Cell) -> bool:
        if self._ground.stops(cell) is not None or cell in self._ground.exits:
            return False
        held = sum(body.cell == cell for body in self._bodies.values())
        return self._settings.cell_capacity is None or held < self._settings.cell_capacity


ROLES = ("leader", "visitor")


def new_body(settings: GridSettings, cell: Cell, energy: int) -> Body:
    """Return the state of an agent that has no memories yet."""
    history = settings.history
    return Body(cell, energy, memories=deque(maxlen=history.memory), received=deque(maxlen=history.messages))


def first_bodies(settings: GridSettings, ground: Ground, seed: int) -> dict[int, Body]:
    """Return the agents' states at the start, by id; an agent whose cell is full starts in the nearest free cell."""
    drawn = settings.layout.draw(seeding.stream(seed, "layout"), settings.field, settings.agents)
    cells = _with_room([(x, y) for x, y in drawn.tolist()], settings, ground)
    start = 0 if settings.energy is None else settings.energy.start
    bodies = {agent: new_body(settings, cell, start) for agent, cell in enumerate(cells)}
    rng, leaders = seeding.stream(seed, "known exits"), 0 if settings.leaders is None else settings.leaders.number
    for exit_zone in settings.exits:
        draws = rng.random(settings.agents).tolist()
        for agent, draw in enumerate(draws):
            if agent < leaders or draw < exit_zone.known:
                bodies[agent].known.add(exit_zone.name)
    return bodies


def with_roles(settings: GridSettings, personas: Sequence[dict[str, str]]) -> list[dict[str, str]]:
    """Return the personas; if the leaders are announced, each persona also contains the agent's role."""
    leaders = settings.leaders
    if leaders is None or not leaders.announced:
        return list(personas)
    roles = (ROLES[agent >= leaders.number] for agent in range(len(personas)))
    return [{**persona, "role": role} for persona, role in zip(personas, roles, strict=True)]


def _with_room(cells: Sequence[Cell], settings: GridSettings, ground: Ground) -> list[Cell]:
    """Return the agents' cells; instead of a cell that is full, take the nearest cell with room."""
    if settings.cell_capacity is None:
        return list(cells)
    held: Counter[Cell] = Counter()
    roomy = []
    for cell in cells:
        if held[cell] >= settings.cell_capacity:
            away = ground.steps_to([cell])
            cell = min(
                (place for place in away if held[place] < settings.cell_capacity),
                key=lambda place: (away[place], place),
            )
        held[cell] += 1
        roomy.append(cell)
    return roomy
