"""How decisions depend on the view, where it is known."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from analysis.camera.signatures import viewpoint
from analysis.camera.signatures.viewpoint import chance_information, information


def still(run, yaw):
    """Return the run as if it had stood where it began, with these headings."""
    foot = np.repeat(run.foot[:1], run.decisions + 1, axis=0)
    headings = np.append(np.asarray(yaw, dtype=np.float64), 0.0)
    return dataclasses.replace(run, foot=foot, yaw=headings, pitch=np.zeros(run.decisions + 1))


def turns(run, angles):
    """Return the run as if these turns alone had been asked for."""
    nothing = np.zeros(run.decisions)
    return dataclasses.replace(
        run, turn=np.asarray(angles, dtype=np.float64), asked=nothing, gaze=nothing, bearing=nothing * math.nan,
        outcome=np.zeros(run.decisions, dtype=np.int64),
    )  # fmt: skip


def test_a_decision_that_goes_by_the_heading_alone_depends_on_the_view_alone(camera):
    run = turns(still(camera(0, 6).run, [0, 90, 0, 90, 0, 90]), [30, -30, 30, -30, 30, -30])
    found = viewpoint.measure(run)
    assert (found["view_change"], found["same_view_change"]) == (1, 0)
    assert (found["n_other_pairs"], found["n_same_pairs"]) == (9, 6)
    # What was still to come of the first decision's kind, at the second, third, ... decision.
    by_chance = np.mean([2 / 5, 1 / 2, 1 / 3, 1 / 2, 0]), np.mean([1 / 2, 1 / 3, 1 / 2, 0])
    assert found["view_effect"] == pytest.approx(sum(by_chance))
    long = turns(still(camera(0, 200).run, [0, 90] * 100), [30, -30] * 100)
    assert viewpoint.measure(long)["view_effect"] == pytest.approx(1, abs=0.02)


def test_the_clock_alone_does_not_depend_on_the_view_and_headings_around_north_are_near(camera):
    run = turns(still(camera(0, 200).run, [0, 0, 90, 90] * 50), [30, -30] * 100)
    found = viewpoint.measure(run)
    assert found["view_effect"] == pytest.approx(0, abs=0.03)
    found = viewpoint.measure(turns(still(camera(0, 2).run, [359.8, 0.3]), [30, 30]))
    assert (found["n_same_pairs"], found["n_other_pairs"]) == (1, 0)
    assert math.isnan(found["view_effect"])


def test_what_the_target_in_view_tells_is_at_most_a_bit(camera):
    run = camera(0, 200).run
    visible = np.arange(200) % 2 == 0
    told = turns(dataclasses.replace(run, target_px=np.where(visible, 400, 0)), np.where(visible, 30, -30))
    found = viewpoint.measure(told)
    assert found["visible_information"] == pytest.approx(
        1 - chance_information(np.array([100, 100]), np.array([100, 100]))
    )
    always = viewpoint.measure(dataclasses.replace(told, target_px=np.full(200, 400)))
    assert math.isnan(always["visible_information"])
    assert math.isnan(always["approach_contrast"])


def test_chance_information_is_the_mean_over_all_orders_and_independent_choices_share_none():
    kinds, views = [0, 0, 0, 1, 1, 2], [0, 0, 1, 1, 1, 1]
    orders = [information(np.array(order), np.array(views)) for order in itertools.permutations(kinds)]
    assert np.mean(orders) == pytest.approx(0, abs=1e-12)
    rng = np.random.default_rng(0)
    found = [information(rng.integers(0, 5, 200), rng.integers(0, 4, 200)) for _ in range(200)]
    assert abs(np.mean(found)) < 0.01


def test_an_agent_that_approaches_what_it_sees_has_a_contrast_of_one(camera):
    run = camera(0, 4).run
    run = dataclasses.replace(run, distance=np.array([5.0, 4, 4, 3, 3.5]), target_px=np.array([400, 0, 400, 0]))
    found = viewpoint.measure(run)
    assert (found["approach_visible"], found["approach_hidden"], found["approach_contrast"]) == (1, 0, 1)
    assert (found["n_visible"], found["n_hidden"]) == (2, 2)


def test_decisions_that_could_not_be_read_are_left_out_everywhere(camera):
    run = camera(1, 40).run
    assert not run.readable.all()
    found = viewpoint.measure(run.only_readable())
    assert found["n_decisions"] == run.readable.sum()
    assert found["n_visible"] + found["n_hidden"] <= run.readable.sum()
