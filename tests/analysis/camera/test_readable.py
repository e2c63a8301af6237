"""Measures over the readable decisions alone are those of a run in which the others were never made."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from analysis import signatures
from analysis.camera.camera_run import CameraRun

BY_STATE = ("foot", "yaw", "pitch", "distance")
BY_DECISION = (
    "bearing", "asked", "turn", "gaze", "stay", "outcome", "boundary", "travelled", "visited", "target_px", "success",
    "replies",
)  # fmt: skip
MINE = ("collision", "gaze", "path_efficiency", "recognition", "recovery", "turning", "viewpoint")


def with_known_distances(run: CameraRun) -> CameraRun:
    return dataclasses.replace(run, distance=np.linalg.norm(run.foot[:, :2] - np.array([6.0, 5.0]), axis=1))


def without_unreadable(run: CameraRun) -> CameraRun:
    """Return the run without the decisions that could not be read; they move nothing."""
    states = np.concatenate(([True], run.readable))
    return dataclasses.replace(
        run,
        **{name: getattr(run, name)[states] for name in BY_STATE},
        **{name: getattr(run, name)[run.readable] for name in BY_DECISION},
        visible_px=tuple(run.visible_px[index] for index in np.flatnonzero(run.readable)),
    )


@pytest.mark.parametrize("name", MINE)
def test_what_could_not_be_read_is_as_if_it_had_not_been_decided(name, camera):
    run = with_known_distances(camera(7, 60, stop=True).run)
    assert 0 < run.readable.sum() < run.decisions
    signature = next(one for one in signatures.discover() if one.name == name)
    found = signature.measure(run.only_readable())
    assert found == pytest.approx(signature.measure(without_unreadable(run)), nan_ok=True)


def test_of_pairs_in_a_row_both_must_be_readable(camera):
    run = camera(7, 60).run
    stability = next(one for one in signatures.discover() if one.name == "stability")
    found = stability.measure(run.only_readable())
    assert found["n_pairs"] == (run.readable[1:] & run.readable[:-1]).sum()
    assert found["run_length"] * found["n_runs"] == pytest.approx(run.readable.sum())
    alternating = dataclasses.replace(run, outcome=np.where(np.arange(60) % 2, run.outcome.max(), 0))
    assert not alternating.readable.all()
    assert math.isnan(stability.measure(alternating.only_readable())["persistence"])
