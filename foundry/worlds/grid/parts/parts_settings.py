"""The settings of the optional parts of a 2D world."""

from typing import Annotated, Literal, TypeAlias

import msgspec

from foundry.worlds.grid.space import Cell, Count, Name, Share, Size

Corners: TypeAlias = tuple[Cell, Cell]
"""Two opposite corners of a rectangle of cells; the rectangle may be a line or a single cell."""

GATHER, SHARE, ATTACK, REPRODUCE = "gather", "share", "attack", "reproduce"
FURTHER_ACTIONS = (GATHER, SHARE, ATTACK, REPRODUCE)
"""Actions other than staying and moving, one per optional part."""

Barred: TypeAlias = Literal["sight", "talk"]
Shape: TypeAlias = Literal["circle", "square"]


class Exit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A way out; an agent that moves onto one of its cells leaves the world.

    Attributes:
        name: unique name.
        cells: the cells that lead out.
        capacity: number of agents that it lets out per step, over all its cells; null for any number.
        known: share of the agents that know the exit from the start; the others learn of it when they see it. `true` is
            1.
    """

    name: Name
    cells: Annotated[tuple[Cell, ...], msgspec.Meta(min_length=1)]
    capacity: Count | None = None
    known: bool | Share = True


class Leaders(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The agents with the lowest ids, which know all exits from the start.

    Attributes:
        number: number of leaders.
        announced: whether all agents know the leaders: each persona then has a `role`, leader or visitor.
    """

    number: Count
    announced: bool = True


class Zone(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A rectangle where agents may die.

    Attributes:
        name: unique name.
        corners: two opposite corners.
        risk: probability that an agent dies at the end of a step in the zone.
    """

    name: Name
    corners: Corners
    risk: Share


class Order(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An instruction to all agents, without force.

    Attributes:
        text: the instruction.
        target: two opposite corners of the rectangle that agents should go to.
        start: first step in which agents are told the instruction.
    """

    text: Name
    target: Corners
    start: Count = 1


class Energy(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Energy of agents; an agent without energy dies.

    Attributes:
        start: energy of each agent at the start.
        loss: energy that each agent loses per step.
        most: maximum energy of an agent; null for any amount.
    """

    start: Count
    loss: Size = 1
    most: Count | None = None


class Food(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Food in cells, which agents gather for energy.

    Attributes:
        share: share of the cells without walls that bear food, drawn by the seed.
        amount: initial and maximum units in a cell.
        regrow_every: number of steps in which a unit grows again; null for never.
        bite: units that an agent can gather per step; null for all units in the cell.
    """

    share: Share = 1
    amount: Count
    regrow_every: Count | None = None
    bite: Count | None = None


class Attack(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The effect of an attack on an agent within touch.

    Attributes:
        takes: energy that goes from the attacked agent to the attacker, at most all that the attacked agent has.
        cost: energy that the attacker loses.
    """

    takes: Count
    cost: Size = 0


class Reproduction(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The conditions of a birth.

    Attributes:
        needs: energy that the parent must have.
        gives: energy that goes from the parent to the newborn.
        most: maximum number of agents ever, including those at the start.
    """

    needs: Count
    gives: Count
    most: Count
