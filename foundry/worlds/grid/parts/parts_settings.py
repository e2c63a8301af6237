"""The settings of the optional parts of a 2D world."""

from typing import Annotated, Literal, TypeAlias

import msgspec

from foundry.worlds.grid.space import Cell, Count, Name, Share, Size

Corners: TypeAlias = tuple[Cell, Cell]
"""Two opposite corners of a rectangle of cells; the rectangle may be a line or a single cell."""

GATHER, SHARE, ATTACK, REPRODUCE = "gather", "share", "attack", "reproduce"
FURTHER_ACTIONS = (GATHER, SHARE, ATTACK, REPRODUCE)
"""Actions other than staying and moving; each exists only if the world has its part, such as food for `gather`."""

Barred: TypeAlias = Literal["sight", "talk"]
Shape: TypeAlias = Literal["circle", "square"]


class Exit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A way out; an agent that moves onto one of its cells leaves the world.

    Attributes:
        name: unique name.
        cells: the cells that lead out.
        capacity: number of agents that all cells of the exit together let out per step; null for any number.
        known: share of the agents that know the exit from the start, where `true` means 1. Other agents know the exit
            once they have seen it.
    """

    name: Name
    cells: Annotated[tuple[Cell, ...], msgspec.Meta(min_length=1)]
    capacity: Count | None = None
    known: bool | Share = True


class Leaders(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The leaders: the agents with the lowest ids, which know all exits from the start.

    Attributes:
        number: number of leaders.
        announced: whether agents can tell leaders apart; each persona then has a `role`, leader or visitor.
    """

    number: Count
    announced: bool = True


class Zone(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A rectangle where agents may die.

    Attributes:
        name: unique name.
        corners: two opposite corners.
        risk: probability that an agent dies if it ends a step in the zone.
    """

    name: Name
    corners: Corners
    risk: Share


class Order(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An instruction to all agents, which they may ignore.

    Attributes:
        text: the instruction.
        target: two opposite corners of the rectangle that agents should go to.
        start: first step in which agents get the instruction.
    """

    text: Name
    target: Corners
    start: Count = 1


class Energy(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Energy of agents; an agent without energy dies.

    Attributes:
        start: energy of each agent at the start.
        loss: energy that each agent loses per step.
        most: maximum energy of an agent; null for no maximum.
    """

    start: Count
    loss: Size = 1
    most: Count | None = None


class Food(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Food in cells, which agents gather for energy.

    Attributes:
        share: probability that a cell without a wall has food; the seed draws these cells.
        amount: units in such a cell at the start, and at most.
        regrow_every: number of steps after which one unit grows in each such cell; null for no growth.
        bite: units that an agent can gather per step; null for all units in the cell.
    """

    share: Share = 1
    amount: Count
    regrow_every: Count | None = None
    bite: Count | None = None


class Attack(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The effects of an attack on the attacked agent and on the attacker.

    Attributes:
        takes: energy that the attacker takes from the attacked agent; if this agent has less, all its energy.
        cost: energy that the attacker loses.
    """

    takes: Count
    cost: Size = 0


class Reproduction(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The rules for births of agents.

    Attributes:
        needs: energy that the parent must have.
        gives: energy that the parent gives to the newborn.
        most: maximum number of agents in the whole run, including the agents at the start and those that die.
    """

    needs: Count
    gives: Count
    most: Count
