"""Events of runs of 3D worlds: arrivals at the goal, collisions, and steps to the edge of the scene."""

from collections.abc import Iterator

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.measuring.events import Event, beginnings

_ENDS = {"bounds": "the bounds of the scene", "edge": "the edge of the floor"}
"""Words for boundaries that stop an agent although they are no obstacles."""


def events(run: CameraRun) -> Iterator[Event]:
    """Yield the events of a run."""
    if run.has_target and run.success.any():
        yield Event(int(run.success.argmax()) + 1, 0, "arrived", f"arrives at {run.episode.target}")
    ended = np.array([name in _ENDS for name in run.boundary], dtype=np.bool_)
    for event, flags in (("collided", run.collided & ~ended), ("scene_ended", run.collided & ended)):
        for step in beginnings(flags):
            name = run.boundary[step]
            yield Event(step + 1, 0, event, f"is stopped by {_ENDS.get(name, name)}")
