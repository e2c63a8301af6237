"""Survival on arrays worked out by hand, and foragers against the closed form of their lives."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from analysis.grid.grid_run import CHOICES, FURTHER_ACTIONS, Energy, GridRun, Order
from analysis.grid.signatures import survival
from grid_runs import grid_run, whole_run

GATHER, SHARE, ATTACK = (len(CHOICES) + FURTHER_ACTIONS.index(name) for name in ("gather", "share", "attack"))


def living(paths: Any, *, start: int = 10, order: Order | None = None, **changes: Any) -> GridRun:
    """Return the run of agents with energy; what is not said of their lives is 0."""
    run = grid_run(paths, **{name: value for name, value in changes.items() if name in ("choice", "present", "lost")})
    names = ("energy", "energy_next", "amount", "target", "born", "food")
    numbers = {name: changes.get(name, np.zeros(run.choice.shape, dtype=np.int64)) for name in names}
    agents = changes.get("agents", run.agents)
    world = msgspec.structs.replace(run.world, energy=Energy(start), order=order, agents=agents)
    return replace(run, world=world, living=numbers)


def test_actions_are_rates_within_reach_and_amounts_by_decision():
    stay = [(0, 0)] * 3
    choice = np.array([[SHARE, ATTACK, ATTACK], [ATTACK, GATHER, SHARE]])
    energy = np.array([[10, 9, 3], [9, 10, 3]])
    measures = survival.measure(living([stay, [(1, 1)] * 3, [(5, 5)] * 3], choice=choice, energy=energy))
    assert measures["n_reach"] == 4, "the third agent is alone"
    assert (measures["sharing_rate"], measures["attack_rate"]) == (1 / 4, 2 / 4)
    assert (measures["attack_rate_scarce"], measures["attack_rate_plenty"]) == (1, 0)
    assert measures["sharing_rate_plenty"] == 1 / 2
    choice = np.array([[GATHER, SHARE], [ATTACK, GATHER]])
    measures = survival.measure(
        living(
            [[(0, 0)] * 3, [(1, 0)] * 3],
            choice=choice,
            amount=np.array([[4, 2], [3, 0]]),
            energy=np.array([[10, 10], [0, 12]]),
            born=np.array([[0, 1], [0, 0]]),
        )
    )
    assert (measures["gathered"], measures["given"], measures["taken"]) == (1, 0.5, 0.75)
    assert measures["inequality"] == pytest.approx((0 + 0.5) / 2)
    assert measures["births"] == 0.5


def test_lives_end_with_death_or_the_end_and_count_from_the_start():
    present = np.array([[True, True], [True, False], [True, False]])
    lost = np.array([[False, True], [False, False], [False, False]])
    measures = survival.measure(living([[(0, 0)] * 4, [(1, 0)] * 4], present=present, lost=lost))
    assert (measures["lifespan"], measures["survived"]) == (2, 0.5)
    assert measures["n_decisions"] == 4
    left = living([[(0, 0)] * 3, [(1, 0)] * 3])
    left = replace(left, world=msgspec.structs.replace(left.world, steps=50))
    measures = survival.measure(left)
    assert (measures["lifespan"], measures["survived"]) == (50, 1), "the run ended when nobody was left"
    present = np.array([[True, False], [True, True]])
    measures = survival.measure(living([[(0, 0)] * 3, [(1, 0)] * 3], present=present, agents=1))
    assert (measures["lifespan"], measures["survived"], measures["n_agents"]) == (2, 1, 1)
    assert measures["n_reach"] == 2


def test_compliance_is_of_those_who_were_outside_and_alive_when_the_order_was_told():
    order = Order(target=((2, -5), (5, 5)), start=2)
    paths = [[(0, 0), (1, 0), (2, 0), (2, 0)], [(0, 0)] * 4, [(2, 2)] * 4]
    measures = survival.measure(living(paths, order=order))
    assert (measures["compliance"], measures["n_ordered"]) == (0.5, 2)
    assert math.isnan(survival.measure(living(paths))["compliance"])


ALONE = ("world.agents=1", "world.reproduction.most=1", "world.half_size=8", "world.steps=60")


@pytest.mark.parametrize(("energy", "loss", "regrow", "steps"), [(7, 1, "null", 14), (9, 4, "1", 3)])
def test_a_forager_alone_on_a_uniform_field_lives_as_long_as_the_closed_form_says(
    tmp_path: Path, energy: int, loss: int, regrow: str, steps: int
):
    # Without growth a unit is gathered in every other step; with it in each.
    field = f"world.food={{share: 1, amount: 1, regrow_every: {regrow}, bite: 1}}"
    setting = (f"world.energy.start={energy}", f"world.energy.loss={loss}", field)
    run = whole_run(tmp_path / "sweep", "survival", "forager", *ALONE, *setting, seed=3)
    assert survival.measure(run)["lifespan"] == steps


def test_foragers_with_plenty_have_children_who_are_asked_too(tmp_path: Path):
    run = whole_run(
        tmp_path / "sweep", "survival", "forager", "world.half_size=4", "world.agents=3", "world.food.share=1",
        "world.reproduction.most=8", "world.steps=20", "world.energy.start=35", seed=0,
    )  # fmt: skip
    assert 3 < run.agents <= 8
    measures = survival.measure(run)
    assert measures["births"] * 3 >= run.agents - 3 and measures["survived"] == 1
    assert not run.there[0, 3:].any() and run.there[-1].sum() == run.agents
