"""Plots of 3D worlds: the paths of runs, seen from above."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from analysis.arrays import FloatArray
from analysis.camera.camera_run import CameraRun
from analysis.figures.shown import ShownGroup, example_caption
from analysis.form import RunTable
from analysis.plots import Picture, style
from analysis.plots.figures import new_figure
from analysis.plots.labels import wrapped
from foundry.palette import COLOURS

_HOLLOW: Any = {"linestyle": "", "markeredgecolor": "black", "markerfacecolor": "none", "zorder": 6}
"""The style of marks without a filling, which do not hide the end of a path below them."""


@dataclass(frozen=True)
class CameraPath:
    """The path of one run.

    Attributes:
        foot: place of the agent by state, seen from above, metres, (T + 1, 2).
        reached: whether the agent is at the goal at the end of the run.
    """

    shown: ShownGroup
    foot: FloatArray
    reached: bool


@dataclass(frozen=True)
class TopDown:
    """The paths from one start to one goal.

    Attributes:
        start: common start, metres, (2,).
        shortest: shortest path, metres, (k, 2); empty if none exists.
        radius: maximum distance from the end of the shortest path that counts as reached, metres.
    """

    title: str
    start: FloatArray
    shortest: FloatArray
    radius: float
    paths: tuple[CameraPath, ...]


def draw_topdown(ax: Axes, top_down: TopDown) -> Axes:
    """Draw the paths: a square at the start, a star at the goal, and a large mark at the end of each path."""
    from matplotlib.patches import Circle

    if len(top_down.shortest):
        ax.plot(*top_down.shortest.T, color=style.DARK, linestyle=":", linewidth=1, label="shortest way", zorder=1.5)
        goal = top_down.shortest[-1]
        ax.add_patch(Circle((goal[0], goal[1]), top_down.radius, color=COLOURS[4], alpha=0.25, linewidth=0))
        ax.plot(*goal, marker="*", markersize=12, label="goal", **_HOLLOW)
    ax.plot(*top_down.start, marker="s", markersize=9, label="start", **_HOLLOW)
    for path in top_down.paths:
        _draw_path(ax, path)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x (m)", ylabel="y (m)", title=wrapped(top_down.title, 48))
    ax.grid(True, axis="both")
    ax.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.2), borderaxespad=0, ncols=1, handlelength=1.8)
    return ax


def _draw_path(ax: Axes, path: CameraPath) -> None:
    colour = path.shown.colour
    label = wrapped(path.shown.label + (" (reached)" if path.reached else ""), 44)
    ax.plot(*path.foot.T, color=colour, linewidth=1.2, alpha=0.85, marker=".", markersize=2.5, label=label)
    shape = style.marker(path.shown.index, baseline=path.shown.baseline)
    ax.plot(*path.foot[-1], marker=shape, markersize=5, color=colour, markeredgecolor="white", zorder=5)


def topdown_figure(top_down: TopDown) -> Figure:
    """Return the figure of the paths through a 3D world."""
    below = sum(wrapped(path.shown.label, 44).count("\n") + 1 for path in top_down.paths) + 2
    figure = new_figure(3.0 + 0.15 * below)
    draw_topdown(figure.add_subplot(), top_down)
    return figure


class CameraFigures:
    """Collects the paths of the example runs, one for each group."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._runs: dict[ShownGroup, CameraRun] = {}

    def add(self, shown: ShownGroup, run: CameraRun, seed: int) -> None:
        """Keep a group's run for the figure if the run has the seed that the figure shows."""
        if seed == self._seed:
            self._runs.setdefault(shown, run)

    def pictures(self, order: Sequence[ShownGroup]) -> list[Picture]:
        """Return the pictures, one for each scene, target and start."""
        tasks = top_downs([(condition, self._runs[condition]) for condition in order if condition in self._runs])
        caption = (
            f"{example_caption(self._seed)} Paths from above. Square: start. Star: end of the shortest path to the "
            "goal (dotted). Shaded: area that counts as near. A large mark ends each path."
        )
        names = ["topdown"] if len(tasks) == 1 else [f"topdown_{number + 1}" for number in range(len(tasks))]
        return [
            Picture(name, "Paths from above", caption, partial(topdown_figure, task), data=task.paths)
            for name, task in zip(names, tasks, strict=True)
        ]

    def tables(self, _: Sequence[ShownGroup]) -> list[RunTable]:
        """Return no tables: the plot shows everything."""
        return []


def top_downs(runs: Sequence[tuple[ShownGroup, CameraRun]]) -> list[TopDown]:
    """Return the paths of the runs, in one drawing for each scene, target and start."""
    tasks: dict[tuple[str, str, float, float], list[tuple[ShownGroup, CameraRun]]] = {}
    for shown, run in runs:
        start = run.episode.start
        tasks.setdefault((run.episode.scene, run.episode.target, start.x, start.y), []).append((shown, run))
    return [_top_down(same) for same in tasks.values()]


def _top_down(runs: Sequence[tuple[ShownGroup, CameraRun]]) -> TopDown:
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


def _path(shown: ShownGroup, run: CameraRun) -> CameraPath:
    reached = bool(run.success[-1]) if run.decisions else False
    return CameraPath(shown, run.foot[:, :2], reached)
