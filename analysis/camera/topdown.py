"""Draws the paths through a 3D world, seen from above."""

from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from analysis.arrays import FloatArray
from analysis.figures.shown import Shown
from analysis.plots import style
from analysis.plots.figures import new_figure
from analysis.plots.labels import wrapped
from foundry.palette import COLOURS

_HOLLOW: Any = {"linestyle": "", "markeredgecolor": "black", "markerfacecolor": "none", "zorder": 6}
"""Hollow marks that do not hide the ends of paths."""


@dataclass(frozen=True)
class CameraPath:
    """The path of one run.

    Attributes:
        foot: place of the agent by state, seen from above, metres, (T + 1, 2).
        reached: whether the agent is at the goal at the end.
    """

    shown: Shown
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


def draw_topdown(ax: Axes, found: TopDown) -> Axes:
    """Draw the paths on one axis: a star at the goal, a square at the start, a dot at the end of each path."""
    from matplotlib.patches import Circle

    if len(found.shortest):
        ax.plot(*found.shortest.T, color=style.DARK, linestyle=":", linewidth=1, label="shortest way", zorder=1.5)
        goal = found.shortest[-1]
        ax.add_patch(Circle((goal[0], goal[1]), found.radius, color=COLOURS[4], alpha=0.25, linewidth=0))
        ax.plot(*goal, marker="*", markersize=12, label="goal", **_HOLLOW)
    ax.plot(*found.start, marker="s", markersize=9, label="start", **_HOLLOW)
    for path in found.paths:
        _draw_path(ax, path)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x (m)", ylabel="y (m)", title=wrapped(found.title, 48))
    ax.grid(True, axis="both")
    ax.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.2), borderaxespad=0, ncols=1, handlelength=1.8)
    return ax


def _draw_path(ax: Axes, path: CameraPath) -> None:
    colour = path.shown.colour
    label = wrapped(path.shown.label + (" (reached)" if path.reached else ""), 44)
    ax.plot(*path.foot.T, color=colour, linewidth=1.2, alpha=0.85, marker=".", markersize=2.5, label=label)
    shape = style.marker(path.shown.index, baseline=path.shown.baseline)
    ax.plot(*path.foot[-1], marker=shape, markersize=5, color=colour, markeredgecolor="white", zorder=5)


def topdown_figure(found: TopDown) -> Figure:
    """Return the figure of the paths through a 3D world."""
    below = sum(wrapped(path.shown.label, 44).count("\n") + 1 for path in found.paths) + 2
    figure = new_figure(3.0 + 0.15 * below)
    draw_topdown(figure.add_subplot(), found)
    return figure
