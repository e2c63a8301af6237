"""Whole figures of 2D worlds: maps, curves, chains of warnings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from analysis.arrays import FloatArray
from analysis.figures.shown import ShownGroup
from analysis.grid.grid_run import GridRun
from analysis.grid.plots.occupancy import OccupancyMap, draw_occupancy, draw_paths, map_titles
from analysis.plots import style
from analysis.plots.figures import new_figure, stacked
from analysis.plots.labels import LINE_IN, wrapped
from foundry.palette import BASELINE

_NUMBERED = 30
"""Up to this number of agents, each agent's id is written beside it."""


@dataclass(frozen=True)
class CascadeEdge:
    """A first warning, from one agent to another at a step."""

    step: int
    sender: int
    recipient: int


@dataclass(frozen=True)
class CascadeTree:
    """How each agent of a run learnt of a fire.

    Attributes:
        rows: agents from top to bottom, each below the agent that warned it.
        since: step at which each of these agents learnt of a fire; for an agent that warned others before it learnt of
            any, the step of its warning.
        direct: agents that saw a fire before any warning.
        unfounded: agents that warned others before they learnt of any fire.
        informed: number of agents that learnt of a fire.
    """

    shown: ShownGroup
    run: str
    steps: int
    rows: tuple[int, ...]
    since: dict[int, int]
    direct: frozenset[int]
    unfounded: frozenset[int]
    informed: int
    edges: tuple[CascadeEdge, ...]
    agents: int


def draw_cascade(ax: Axes, tree: CascadeTree) -> Axes:
    """Draw a dot for each agent, at the step in which it learnt of a fire.

    A line leads from each agent to the agents that heard of a fire from it first. A filled dot is an agent that saw a
    fire, a hollow dot one that was told of it. A cross is an agent that warned others without having learnt of a fire.
    """
    colour = tree.shown.colour
    place = {agent: -row for row, agent in enumerate(tree.rows)}
    for edge in tree.edges:
        ends = (tree.since[edge.sender], edge.step), (place[edge.sender], place[edge.recipient])
        ax.plot(*ends, color=colour, linewidth=0.8, alpha=0.8, zorder=2)
    for agent in tree.rows:
        face = colour if agent in tree.direct else "white"
        dot = (tree.since[agent], place[agent])
        shape = "x" if agent in tree.unfounded else "o"
        ax.plot(*dot, marker=shape, markersize=3.5, color=colour, markerfacecolor=face, markeredgewidth=0.8)
    informed = f"{tree.informed} of {tree.agents} agents learnt of a fire"
    dark = BASELINE if tree.shown.baseline else style.DARK
    ax.set_title(wrapped(tree.shown.label, 44) + "\n" + informed, size=7, color=dark)
    names = [str(agent) for agent in tree.rows] if len(tree.rows) <= _NUMBERED else [""] * len(tree.rows)
    ax.set_yticks(list(place.values()), names, size=7)
    ax.set_xlim(0, tree.steps + 1)
    ax.set_ylim(-max(len(tree.rows), 1) + 0.4, 0.6)
    return ax


def cascade_height(tree: CascadeTree) -> float:
    """Return the height of a tree's panel, inches."""
    return 0.6 + 0.13 * wrapped(tree.shown.label, 44).count("\n") + max(0.25, 0.125 * len(tree.rows))


@dataclass(frozen=True)
class SurvivalCurve:
    """Share of the agents of a group that are not yet warned, or still present.

    Attributes:
        remaining: mean share over runs after steps 0..T, (T + 1,); the Kaplan-Meier estimate if agents are censored.
        low: lower end of its interval over runs, (T + 1,); NaN where undefined.
        high: upper end of this interval.
    """

    shown: ShownGroup
    remaining: FloatArray
    low: FloatArray
    high: FloatArray
    runs: int

    @property
    def label(self) -> str:
        """Name of the curve in the legend, with line breaks."""
        return wrapped(f"{self.shown.label} (n={self.runs})", 40)


def draw_survival(ax: Axes, curves: Sequence[SurvivalCurve], label: str) -> Axes:
    """Draw one curve per group, which falls over the steps, with a band for its interval over runs."""
    for curve in curves:
        steps = np.arange(len(curve.remaining))
        look = style.line(curve.shown.index, baseline=curve.shown.baseline)
        width = 1.0 if curve.shown.baseline else 1.4
        ax.step(steps, curve.remaining, where="post", linewidth=width, label=curve.label, **look)
        ax.fill_between(steps, curve.low, curve.high, step="post", color=look["color"], alpha=0.15, linewidth=0)
    ax.set(xlabel="Step", ylabel=label, ylim=(-0.03, 1.03))
    ax.grid(True, axis="both")
    ax.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.22), borderaxespad=0, handlelength=2.2)
    return ax


_MAPS_A_ROW = 3
_SCALED = 0.95
"""The colour scale of the maps ends at this quantile of the visited cells."""


def _maps(labels: Sequence[str], extra: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with a square panel for each label, three in a row."""
    rows, columns = math.ceil(len(labels) / _MAPS_A_ROW), min(len(labels), _MAPS_A_ROW)
    side = 0.95 * style.width() / max(columns, 2)
    figure = new_figure(rows * (side + map_titles(labels) * LINE_IN) + extra)
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for ax in panels[len(labels) :]:
        ax.axis("off")
    return figure, panels[: len(labels)]


def occupancy_figure(maps: Sequence[OccupancyMap]) -> Figure:
    """Return a figure with a map of each group's positions, all on one colour scale."""
    figure, panels = _maps([shown_map.shown.label for shown_map in maps], extra=0.45)
    models = [shown_map.share for shown_map in maps if not shown_map.shown.baseline] or [
        shown_map.share for shown_map in maps
    ]
    visited = np.concatenate([share[share > 0] for share in models])
    # A scale that ends at the most crowded cell would make all others pale.
    most = float(np.quantile(visited, _SCALED)) if len(visited) else 1.0
    for ax, occupancy in zip(panels, maps, strict=True):
        image = draw_occupancy(ax, occupancy, most)
    bar = figure.colorbar(
        image,
        ax=figure.axes,
        orientation="horizontal",
        aspect=40,
        pad=0.02,
        fraction=0.06,
        extend="max" if max(float(shown_map.share.max()) for shown_map in maps) > most else "neither",
    )
    bar.locator = MaxNLocator(4)
    bar.set_label("Share of agent-steps in the cell (square-root scale)")
    bar.outline.set_linewidth(0.4)
    return figure


def paths_figure(runs: Sequence[tuple[ShownGroup, GridRun]]) -> Figure:
    """Return a figure of the agents' paths in one run of each group."""
    figure, panels = _maps([shown.label for shown, _ in runs], extra=0.05)
    for ax, (shown, run) in zip(panels, runs, strict=True):
        draw_paths(ax, shown, run)
    return figure


def survival_figure(curves: Sequence[SurvivalCurve], label: str = "Not yet warned (share)") -> Figure:
    """Return a figure with one falling line per group; `label` is the title of the vertical axis."""
    below = sum(curve.label.count("\n") + 1 for curve in curves)
    figure = new_figure(2.2 + 0.15 * below)
    draw_survival(figure.add_subplot(), curves, label)
    return figure


def cascade_figure(trees: Sequence[CascadeTree]) -> Figure:
    """Return a figure of the chains of warnings in one run of each group."""
    figure, panels = stacked([cascade_height(tree) for tree in trees])
    for ax, tree in zip(panels, trees, strict=True):
        draw_cascade(ax, tree)
    panels[-1].set_xlabel("Step")
    figure.supylabel("Agent", size=7.5)
    return figure
