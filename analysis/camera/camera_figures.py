"""Plots of 3D worlds: paths seen from above."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.camera.topdown import CameraPath, TopDown, topdown_figure
from analysis.figures.shown import Shown, example_caption
from analysis.form import RunTable
from analysis.plots import Picture


class CameraFigures:
    """Collects the paths of the example runs, one per group."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._runs: dict[Shown, CameraRun] = {}

    def add(self, shown: Shown, run: CameraRun, seed: int) -> None:
        """Add the path of a group's run."""
        if seed == self._seed:
            self._runs.setdefault(shown, run)

    def pictures(self, order: Sequence[Shown]) -> list[Picture]:
        """Return the pictures, one for each scene, target and start."""
        tasks = top_downs([(one, self._runs[one]) for one in order if one in self._runs])
        caption = (
            f"{example_caption(self._seed)} Paths from above. Square: start. Star: end of the shortest path to the "
            "goal (dotted). Shaded: area that counts as near. A large mark ends each path."
        )
        names = ["topdown"] if len(tasks) == 1 else [f"topdown_{number + 1}" for number in range(len(tasks))]
        return [
            Picture(name, "Paths from above", caption, partial(topdown_figure, task), data=task.paths)
            for name, task in zip(names, tasks, strict=True)
        ]

    def tables(self, _: Sequence[Shown]) -> list[RunTable]:
        """Return no tables: the plot shows everything."""
        return []


def top_downs(runs: Sequence[tuple[Shown, CameraRun]]) -> list[TopDown]:
    """Return the paths of the runs, on one axis per scene, target and start."""
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
    return CameraPath(shown, run.foot[:, :2], reached)
