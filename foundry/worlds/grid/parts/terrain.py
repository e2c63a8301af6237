"""The ground of a 2D world: where walls stand, what can be seen from where, and the shortest ways out."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from foundry.worlds.grid.parts.parts_settings import Corners, Exit
from foundry.worlds.grid.space import OFFSETS, Cell

WALL, HIDDEN, FREE = "#", "?", "."


def cells_of(corners: Corners) -> Iterator[Cell]:
    """Yield the cells of a rectangle between two opposite corners, both included."""
    (x, y), (other_x, other_y) = corners
    for column in range(min(x, other_x), max(x, other_x) + 1):
        for row in range(min(y, other_y), max(y, other_y) + 1):
            yield column, row


def is_within(cell: Cell, corners: Corners) -> bool:
    """Tell whether a cell lies in the rectangle between two opposite corners."""
    (x, y), (other_x, other_y) = corners
    return min(x, other_x) <= cell[0] <= max(x, other_x) and min(y, other_y) <= cell[1] <= max(y, other_y)


def next_to(cell: Cell) -> list[Cell]:
    """Return the cells up, down, left and right of a cell."""
    return [(cell[0] + dx, cell[1] + dy) for dx, dy in OFFSETS.values()]


@dataclass(frozen=True, slots=True)
class Sight:
    """What can be seen from a cell.

    Attributes:
        rows: the cells around it, the uppermost row first; a text in the place of one that is hidden or off the grid.
        cells: those that can be seen.
    """

    rows: tuple[tuple[Cell | str, ...], ...]
    cells: frozenset[Cell]

    def window(self, marks: Mapping[Cell, str], own: Cell) -> list[str]:
        """Return the rows as texts, a character a cell: its mark, `@` for `own`."""
        get = marks.get
        return [
            "".join([one if isinstance(one, str) else "@" if one == own else get(one, FREE) for one in row])
            for row in self.rows
        ]


class Ground:
    """What of a world never changes; what is seen from a cell is worked out once, for one reach.

    Attributes:
        half_size: both axes run from -half_size to +half_size.
        walls: cells that nobody can enter.
        exits: the exit that each of their cells leads out by.
    """

    def __init__(self, half_size: int, walls: Iterable[Corners], exits: Iterable[Exit]) -> None:
        self.half_size = half_size
        self.walls = frozenset(cell for wall in walls for cell in cells_of(wall))
        self.exits = {cell: one for one in exits for cell in one.cells}
        self._seen: dict[Cell, Sight] = {}

    def __contains__(self, cell: Cell) -> bool:
        """Whether the cell is on the grid."""
        return abs(cell[0]) <= self.half_size and abs(cell[1]) <= self.half_size

    def stops(self, cell: Cell) -> str | None:
        """Return what keeps everyone out of a cell, `edge` or `wall`, or None."""
        if cell not in self:
            return "edge"
        return "wall" if cell in self.walls else None

    def is_clear(self, one: Cell, other: Cell) -> bool:
        """Tell whether no wall stands between two cells; the same both ways."""
        return not self.walls or self.walls.isdisjoint(_between(*sorted((one, other))))

    def ways(self, cell: Cell) -> list[str]:
        """Return the directions in which neither wall nor edge stands."""
        return [way for way, (dx, dy) in OFFSETS.items() if self.stops((cell[0] + dx, cell[1] + dy)) is None]

    def sight(self, cell: Cell, reach: int | None, *, barred: bool) -> Sight:
        """Return what can be seen from a cell.

        Args:
            cell: where it is looked from.
            reach: columns and rows to each side; None for the whole grid.
            barred: whether walls hide what is behind them.
        """
        if cell not in self._seen:
            half = self.half_size
            (x, y), side = (cell, reach) if reach is not None else ((0, 0), half)
            rows = tuple(
                tuple(self._glance(cell, (column, row), barred=barred) for column in range(x - side, x + side + 1))
                for row in range(y + side, y - side - 1, -1)
            )
            self._seen[cell] = Sight(rows, frozenset(one for row in rows for one in row if not isinstance(one, str)))
        return self._seen[cell]

    def _glance(self, cell: Cell, other: Cell, *, barred: bool) -> Cell | str:
        if other not in self:
            return WALL
        return HIDDEN if barred and not self.is_clear(cell, other) else other

    def steps_to(self, goals: Collection[Cell], closed: Collection[Cell] = ()) -> dict[Cell, int]:
        """Return the fewest moves to one of the goals from every cell with a way there.

        Args:
            goals: where ways end.
            closed: cells that no way may lead through, beside walls; nor through an exit that is no goal.
        """
        ends = set(goals)
        steps = dict.fromkeys(ends, 0)
        front = deque(ends)
        while front:
            cell = front.popleft()
            for one in next_to(cell):
                if one in steps or self.stops(one) or one in closed or one in self.exits:
                    continue
                steps[one] = steps[cell] + 1
                front.append(one)
        return steps


def _between(one: Cell, other: Cell) -> Iterator[Cell]:
    """Yield the cells that a straight line between the middles of two cells comes nearest to, without the two.

    Source: Bresenham 1965.
    """
    (x, y), (end_x, end_y) = one, other
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
        if (x, y) == (end_x, end_y) or one == other:
            return
        yield x, y
