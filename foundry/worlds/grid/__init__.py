"""The 2D worlds: a bounded grid with places and fires, where agents talk to those near them and move."""

from foundry.worlds.grid.world import GridScenario, GridWorld

__all__ = ["GridScenario", "GridWorld"]
