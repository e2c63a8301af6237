"""Events of runs of 3D worlds: the arrival at the goal, and collisions."""

from __future__ import annotations

from collections.abc import Iterator

from analysis.camera.camera_run import CameraRun
from analysis.measuring.events import Event, beginnings

_BOUNDARIES = {"bounds": "the bounds of the scene", "edge": "the edge of the floor"}
"""Boundaries that are no obstacle, in words."""


def events(run: CameraRun) -> Iterator[Event]:
    """Yield the events of a run."""
    if run.has_target and run.success.any():
        yield Event(int(run.success.argmax()) + 1, 0, "arrived", f"arrives at {run.episode.target}")
    for step in beginnings(run.collided):
        name = run.boundary[step]
        yield Event(step + 1, 0, "collided", f"is stopped by {_BOUNDARIES.get(name, name)}")
