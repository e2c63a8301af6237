"""What changes in a 2D world by itself: fires that spread, food that grows; drawn by the seed, whatever agents do."""

from __future__ import annotations

from collections.abc import Sequence

from foundry import seeding
from foundry.worlds.grid.hazards import Fire
from foundry.worlds.grid.parts.parts_settings import Food
from foundry.worlds.grid.parts.terrain import Ground, next_to
from foundry.worlds.grid.space import Cell


class Blaze:
    """The cells that burn; a fire lights its own cell when it starts, then those beside it, but no wall.

    Attributes:
        cells: the fire that burns in each, in the order in which they caught fire.
    """

    def __init__(self, fires: Sequence[Fire], ground: Ground, seed: int) -> None:
        self._fires = fires
        self._ground = ground
        self._rng = seeding.stream(seed, "spreading")
        self.cells: dict[Cell, Fire] = {}

    def go_on(self, step: int) -> dict[Cell, Fire]:
        """Return the cells that catch fire before the agents are asked in a step; each step is gone through once.

        Each burning cell lights each of the four beside it with the chance that its fire spreads by.
        """
        caught: dict[Cell, Fire] = {}
        for cell, fire in self.cells.items():
            if fire.spread:
                for one in next_to(cell):
                    burnable = self._ground.stops(one) is None and one not in self.cells
                    if burnable and self._rng.random() < fire.spread:
                        caught.setdefault(one, fire)
        for fire in self._fires:
            if fire.start == step and fire.position not in self.cells:
                caught[fire.position] = fire
        self.cells |= caught
        return caught


class Larder:
    """The food that there is.

    Attributes:
        food: units by cell; the cells without any are left out.
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
        """Return how much is gathered from a cell: a bite, what is there, and `most` at most."""
        there = self.food.get(cell, 0)
        taken = max(0, min(there, most, there if self._settings.bite is None else self._settings.bite))
        self._set(cell, there - taken)
        return taken

    def grow(self, step: int) -> None:
        """Let a unit grow at the end of every so many steps, up to what a cell bears at most."""
        if self._settings.regrow_every is not None and step % self._settings.regrow_every == 0:
            for cell in self._bearing:
                self._set(cell, min(self.food.get(cell, 0) + 1, self._settings.amount))

    def _set(self, cell: Cell, amount: int) -> None:
        if amount:
            self.food[cell] = amount
        else:
            self.food.pop(cell, None)
