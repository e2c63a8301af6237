"""The ground of a 2D world: walls, exits, paths, simultaneous moves, spreading fires and food."""

from collections import Counter, defaultdict, deque
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from foundry import seeding
from foundry.leaving import FAR, soonest_departures
from foundry.worlds.base import Computed
from foundry.worlds.grid.parts.parts_settings import Corners, Exit, Food
from foundry.worlds.grid.space import OFFSETS, Cell, Fire

WALL, HIDDEN, FREE = "#", "?", "."


def cells_of(corners: Corners) -> Iterator[Cell]:
    """Yield the cells of a rectangle between two opposite corners, both included."""
    (x, y), (other_x, other_y) = corners
    for column in range(min(x, other_x), max(x, other_x) + 1):
        for row in range(min(y, other_y), max(y, other_y) + 1):
            yield column, row


def is_within(cell: Cell, corners: Corners) -> bool:
    """Return whether a cell is in the rectangle between two opposite corners."""
    (x, y), (other_x, other_y) = corners
    return min(x, other_x) <= cell[0] <= max(x, other_x) and min(y, other_y) <= cell[1] <= max(y, other_y)


def next_to(cell: Cell) -> list[Cell]:
    """Return the cells up, down, left and right of a cell."""
    return [(cell[0] + dx, cell[1] + dy) for dx, dy in OFFSETS.values()]


@dataclass(frozen=True, slots=True)
class Sight:
    """The cells that an agent sees from its cell.

    Attributes:
        rows: the cells around it, the uppermost row first; a cell that is hidden or off the grid is a text instead.
        cells: the visible cells.
    """

    rows: tuple[tuple[Cell | str, ...], ...]
    cells: frozenset[Cell]

    def window(self, marks: Mapping[Cell, str], own: Cell) -> list[str]:
        """Return the rows as texts with one character per cell: the agent's own cell, a wall, food, and so on."""
        get = marks.get
        return [
            "".join([mark if isinstance(mark, str) else "@" if mark == own else get(mark, FREE) for mark in row])
            for row in self.rows
        ]


class Ground:
    """The walls and exits of a world, which never change; it computes the view from each cell only once.

    Attributes:
        half_size: both axes run from -half_size to +half_size.
        walls: cells that nobody can enter.
        exits: the exit of each cell that leads out.
    """

    def __init__(self, half_size: int, walls: Iterable[Corners], exits: Iterable[Exit]) -> None:
        self.half_size = half_size
        self.walls = frozenset(cell for wall in walls for cell in cells_of(wall))
        self.exits = {cell: exit_zone for exit_zone in exits for cell in exit_zone.cells}
        self._seen: dict[Cell, Sight] = {}

    def __contains__(self, cell: Cell) -> bool:
        """Return whether the cell is on the grid."""
        return abs(cell[0]) <= self.half_size and abs(cell[1]) <= self.half_size

    def stops(self, cell: Cell) -> str | None:
        """Return the word for the obstacle that keeps agents out of a cell; None if agents can enter the cell."""
        if cell not in self:
            return "edge"
        return "wall" if cell in self.walls else None

    def is_clear(self, first: Cell, other: Cell) -> bool:
        """Return whether no wall is between two cells; the order of the two does not matter."""
        return not self.walls or self.walls.isdisjoint(_between(*sorted((first, other))))

    def ways(self, cell: Cell) -> list[str]:
        """Return the directions from a cell without a wall or edge."""
        return [way for way, (dx, dy) in OFFSETS.items() if self.stops((cell[0] + dx, cell[1] + dy)) is None]

    def sight(self, cell: Cell, reach: int | None, *, barred: bool) -> Sight:
        """Return the cells that an agent sees from its cell.

        Args:
            cell: the viewer's cell.
            reach: number of visible columns and rows to each side, always the same; None for the whole grid.
            barred: whether walls hide the cells behind them.
        """
        if cell not in self._seen:
            half = self.half_size
            (x, y), side = (cell, reach) if reach is not None else ((0, 0), half)
            rows = tuple(
                tuple(self._glance(cell, (column, row), barred=barred) for column in range(x - side, x + side + 1))
                for row in range(y + side, y - side - 1, -1)
            )
            self._seen[cell] = Sight(rows, frozenset(mark for row in rows for mark in row if not isinstance(mark, str)))
        return self._seen[cell]

    def _glance(self, cell: Cell, other: Cell, *, barred: bool) -> Cell | str:
        if other not in self:
            return WALL
        return HIDDEN if barred and not self.is_clear(cell, other) else other

    def steps_to(self, goals: Collection[Cell], closed: Collection[Cell] = ()) -> dict[Cell, int]:
        """Return the smallest number of moves from each cell to a goal; cells without a path to a goal are left out.

        Args:
            goals: cells where paths end.
            closed: cells that no path may cross, in addition to walls and to exits that are no goal.
        """
        ends = set(goals)
        steps = dict.fromkeys(ends, 0)
        front = deque(ends)
        while front:
            cell = front.popleft()
            for neighbour in next_to(cell):
                if neighbour in steps or self.stops(neighbour) or neighbour in closed or neighbour in self.exits:
                    continue
                steps[neighbour] = steps[cell] + 1
                front.append(neighbour)
        return steps


def _between(first: Cell, other: Cell) -> Iterator[Cell]:
    """Yield the cells on the straight line between two cells, without these two (Bresenham 1965)."""
    (x, y), (end_x, end_y) = first, other
    wide, high = abs(end_x - x), -abs(end_y - y)
    right, up = (1 if end_x > x else -1), (1 if end_y > y else -1)
    error = wide + high
    while True:
        doubled = 2 * error
        if doubled >= high:
            error += high
            x += right
        if doubled <= wide:
            error += wide
            y += up
        if (x, y) == (end_x, end_y) or first == other:
            return
        yield x, y


@dataclass(frozen=True, slots=True)
class MoveResult:
    """The result of an agent's attempt to move.

    Attributes:
        cell: the agent's cell afterwards; the exit's cell if the agent left.
        left: name of the exit by which the agent left, or None.
        blocked: what prevented the move: `edge`, `wall`, `agents` (the cell is full), `exit` (its capacity is used up),
            or None.
    """

    cell: Cell
    left: str | None = None
    blocked: str | None = None


def moves_of(
    ground: Ground, capacity: int | None, cells: Mapping[int, Cell], wanted: Mapping[int, Cell], order: Sequence[int]
) -> dict[int, MoveResult]:
    """Carry out the moves of one step; return the result for each agent, by the agent's id.

    If a cell has not enough room for all agents that want to enter it, the first agents in the order get in. An agent
    that moves away makes room for another in the same step. Two agents cannot swap cells that are both full.

    Args:
        ground: walls and exits.
        capacity: number of agents that fit in a cell; None for any number.
        cells: cell of each agent, by id.
        wanted: target cell of each agent that wants to move, by id.
        order: ids of the agents that want to move; earlier agents go first.
    """
    held, out = Counter(cells.values()), Counter[str]()

    def move(agent: int) -> MoveResult:
        cell, target = cells[agent], wanted[agent]
        if (stop := ground.stops(target)) is not None:
            return MoveResult(cell, blocked=stop)
        way_out = ground.exits.get(target)
        if way_out is not None:
            if way_out.capacity is not None and out[way_out.name] >= way_out.capacity:
                return MoveResult(cell, blocked="exit")
            out[way_out.name] += 1
        elif capacity is not None and held[target] >= capacity:
            return MoveResult(cell, blocked="agents")
        else:
            held[target] += 1
        held[cell] -= 1
        return MoveResult(target, left=None if way_out is None else way_out.name)

    moved = {agent: MoveResult(cell) for agent, cell in cells.items()}
    waiting: defaultdict[Cell, list[int]] = defaultdict(list)
    for agent in order:
        mover: int | None = agent
        while mover is not None:
            moved[mover] = move(mover)
            if moved[mover].blocked == "agents":
                waiting[wanted[mover]].append(mover)
            freed = None if moved[mover].blocked else cells[mover]
            mover = waiting[freed].pop(0) if freed is not None and waiting[freed] else None
    return moved


class WayOut:
    """The plan of the fastest evacuation from the start cells: an exit for each agent."""

    def __init__(self, ground: Ground, exits: Sequence[Exit], bodies: Mapping[int, Cell]) -> None:
        self._ground = ground
        self._exits = exits
        self._start = dict(bodies)
        self._fields: dict[tuple[int, frozenset[Cell]], dict[Cell, int]] = {}

    def _field(self, index: int, closed: frozenset[Cell]) -> dict[Cell, int]:
        key = (index, closed)
        if key not in self._fields:
            self._fields[key] = self._ground.steps_to(self._exits[index].cells, closed)
        return self._fields[key]

    @cached_property
    def _plan(self) -> dict[int, int]:
        """For each agent's id, the index of the exit that the planned evacuation gives it."""
        fields = [self._field(index, frozenset()) for index in range(len(self._exits))]
        distances = [[field.get(cell, FAR) for field in fields] for cell in self._start.values()]
        departures = soonest_departures(distances, [exit_zone.capacity for exit_zone in self._exits])
        return {
            agent: departure.exit
            for agent, departure in zip(self._start, departures, strict=True)
            if departure is not None
        }

    def ways(self, agent: int, cell: Cell, burning: frozenset[Cell]) -> list[str]:
        """Return the directions that lie on a shortest way to the agent's exit; the way avoids burning cells if it can.

        An agent that was born during the run has no planned exit, so it goes to the nearest one.
        """
        planned = self._plan.get(agent)
        mine = [] if planned is None else [planned]
        return self._to(mine, cell, burning) or self.ways_to(
            {exit_zone.name for exit_zone in self._exits}, cell, burning
        )

    def ways_to(self, names: Collection[str], cell: Cell, burning: frozenset[Cell]) -> list[str]:
        """Return the directions on a shortest way to the nearest exit with one of these names."""
        return self._to([index for index, way_out in enumerate(self._exits) if way_out.name in names], cell, burning)

    def _to(self, indices: Sequence[int], cell: Cell, burning: frozenset[Cell]) -> list[str]:
        for closed in (burning - {cell}, frozenset[Cell]()):
            fields = [field for field in (self._field(index, closed) for index in indices) if cell in field]
            if fields:
                field = min(fields, key=lambda steps_by_cell: steps_by_cell[cell])
                ends = {way: (cell[0] + dx, cell[1] + dy) for way, (dx, dy) in OFFSETS.items()}
                return [way for way, end in ends.items() if field.get(end, FAR) < field[cell]]
        return []

    def secret(self, agent: int, cell: Cell, *, known: Collection[str], burning: frozenset[Cell]) -> Computed:
        """Return data for scripted policies, computed only when a policy reads them; models never get these data.

        `ways_out`: the directions on a shortest way to the agent's exit in the fastest evacuation. `ways_known`: the
        directions on a shortest way to the nearest exit that the agent knows.
        """
        return Computed(
            {
                "ways_out": lambda: self.ways(agent, cell, burning),
                "ways_known": lambda: self.ways_to(known, cell, burning),
            }
        )


class SpreadingFires:
    """The burning cells. A fire first burns its own cell; it spreads to neighbouring cells if no wall is in between.

    Attributes:
        cells: the fire of each burning cell, in the order of ignition.
    """

    def __init__(self, fires: Sequence[Fire], ground: Ground, seed: int) -> None:
        self._fires = fires
        self._ground = ground
        self._rng = seeding.stream(seed, "spreading")
        self.cells: dict[Cell, Fire] = {}

    def go_on(self, step: int) -> dict[Cell, Fire]:
        """Return the cells that catch fire before the questions of a step, and let them burn; call it once per step.

        Each burning cell ignites each of its four neighbours with its fire's probability.
        """
        caught: dict[Cell, Fire] = {}
        for cell, fire in self.cells.items():
            if fire.spread:
                for neighbour in next_to(cell):
                    burnable = self._ground.stops(neighbour) is None and neighbour not in self.cells
                    if burnable and self._rng.random() < fire.spread:
                        caught.setdefault(neighbour, fire)
        for fire in self._fires:
            if fire.start == step and fire.position not in self.cells:
                caught[fire.position] = fire
        self.cells |= caught
        return caught


class FoodSupply:
    """The food in the cells.

    Attributes:
        food: units of food by cell, without empty cells.
    """

    def __init__(self, settings: Food, ground: Ground, seed: int) -> None:
        self._settings = settings
        half = ground.half_size
        rng = seeding.stream(seed, "food")
        cells = [(x, y) for x in range(-half, half + 1) for y in range(-half, half + 1)]
        draws = rng.random(len(cells)).tolist()
        self._bearing = tuple(
            cell for cell, draw in zip(cells, draws, strict=True) if draw < settings.share and not ground.stops(cell)
        )
        self.food = dict.fromkeys(self._bearing, settings.amount)

    def take(self, cell: Cell, most: int) -> int:
        """Take food from a cell and return the amount: at most a bite, the food in the cell, and the limit `most`."""
        there = self.food.get(cell, 0)
        taken = max(0, min(there, most, there if self._settings.bite is None else self._settings.bite))
        self._set(cell, there - taken)
        return taken

    def grow(self, step: int) -> None:
        """At regular steps (`regrow_every`), add one unit to each cell that bears food, up to the cell's maximum."""
        if self._settings.regrow_every is not None and step % self._settings.regrow_every == 0:
            for cell in self._bearing:
                self._set(cell, min(self.food.get(cell, 0) + 1, self._settings.amount))

    def _set(self, cell: Cell, amount: int) -> None:
        if amount:
            self.food[cell] = amount
        else:
            self.food.pop(cell, None)
