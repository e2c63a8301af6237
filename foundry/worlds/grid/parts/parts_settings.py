"""The settings of the parts of a 2D world; each may be left out."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from foundry.worlds.grid.space import Cell, Count, Name, Share, Size

Corners: TypeAlias = tuple[Cell, Cell]
"""Two opposite corners of a rectangle of cells, which may be a line or a single cell."""

GATHER, SHARE, ATTACK, REPRODUCE = "gather", "share", "attack", "reproduce"
FURTHER_ACTIONS = (GATHER, SHARE, ATTACK, REPRODUCE)
"""What agents can do beside staying and moving, each where its part is there."""

Barred: TypeAlias = Literal["sight", "talk"]
Shape: TypeAlias = Literal["circle", "square"]


class Exit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A way out: who moves onto one of its cells is gone.

    Attributes:
        name: its own name.
        cells: the cells that lead out.
        capacity: agents that it lets out in a step, over all its cells; null for any number.
        known: share of the agents that know of it from the start; the others once they see it. `true` is 1.
    """

    name: Name
    cells: Annotated[tuple[Cell, ...], msgspec.Meta(min_length=1)]
    capacity: Count | None = None
    known: bool | Share = True


class Leaders(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Agents that know all exits from the start: those with the lowest ids.

    Attributes:
        number: how many there are.
        announced: whether all are told so: the persona of each agent has a `role`, leader or visitor.
    """

    number: Count
    announced: bool = True


class Zone(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A rectangle in which agents may die.

    Attributes:
        name: its own name.
        corners: two opposite corners.
        risk: chance to die of a step that ends in it.
    """

    name: Name
    corners: Corners
    risk: Share


class Order(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What everyone is told to do; nothing makes them.

    Attributes:
        text: the order, as it is told from `start` on.
        target: two opposite corners of the rectangle that whoever obeys comes into.
        start: first step at which it is told.
    """

    text: Name
    target: Corners
    start: Count = 1


class Energy(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What agents live on; one without any dies.

    Attributes:
        start: what each has at the start.
        loss: what each loses in a step.
        most: what one can have; null for any amount.
    """

    start: Count
    loss: Size = 1
    most: Count | None = None


class Food(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What grows in cells and gives energy to those who gather it.

    Attributes:
        share: share of the cells without walls that bear any, drawn by the seed.
        amount: what a cell bears at the start, and at most.
        regrow_every: steps in which a unit grows again; null for never.
        bite: what can be gathered in a step; null for all that is there.
    """

    share: Share = 1
    amount: Count
    regrow_every: Count | None = None
    bite: Count | None = None


class Attack(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What an attack on an agent that is near enough to touch does.

    Attributes:
        takes: energy that goes from the attacked to the attacker, as far as there is any.
        cost: energy that it costs the attacker.
    """

    takes: Count
    cost: Size = 0


class Reproduction(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What it takes to bring a new agent into the world.

    Attributes:
        needs: energy that the parent must have.
        gives: energy that goes from the parent to the newborn.
        most: agents that there may ever be, those of the start among them.
    """

    needs: Count
    gives: Count
    most: Count
