"""What plots of 3D worlds show: the ways that were taken, from above."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.camera_run import CameraRun
from analysis.figures.shown import Shown
from analysis.plots.topdown import CameraPath, TopDown


def top_downs(runs: Sequence[tuple[Shown, CameraRun]]) -> list[TopDown]:
    """Return the ways of these runs, those of one scene, target and start on one axis."""
    tasks: dict[tuple[str, str, float, float], list[tuple[Shown, CameraRun]]] = {}
    for shown, run in runs:
        start = run.episode.start
        tasks.setdefault((run.episode.scene, run.episode.target, start.x, start.y), []).append((shown, run))
    return [_top_down(same) for same in tasks.values()]


def _top_down(runs: Sequence[tuple[Shown, CameraRun]]) -> TopDown:
    episode = runs[0][1].episode
    target = f": {episode.target}" if episode.target else ""
    shortest = np.array(episode.shortest_path, dtype=np.float64).reshape(-1, 3)[:, :2]
    return TopDown(
        title=f"{episode.scene}{target}",
        start=np.array([episode.start.x, episode.start.y]),
        shortest=shortest,
        radius=episode.radius,
        paths=tuple(_path(shown, run) for shown, run in runs),
    )


def _path(shown: Shown, run: CameraRun) -> CameraPath:
    reached = bool(run.success[-1]) if run.decisions else False
    return CameraPath(shown.label, run.id, run.foot[:, :2], reached, shown.index, shown.baseline)
