"""Who warned whom in one run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from analysis.plots import style
from analysis.plots.labels import wrapped
from foundry.palette import BASELINE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NUMBERED = 30
"""Up to this many agents they are named."""


@dataclass(frozen=True)
class CascadeEdge:
    """A first warning: at this step, from one agent to another."""

    step: int
    sender: int
    recipient: int


@dataclass(frozen=True)
class CascadeTree:
    """Who learnt of a fire how, in one run.

    Attributes:
        label: name of the group.
        run: the run's id.
        steps: length of the run.
        rows: agents from top to bottom, those of one chain together; agents with no part in it are left out.
        since: step from which each of them has a part in it, by agent: it learnt, or warned without having learnt.
        direct: those that saw a fire themselves.
        unfounded: those that warned others before they learnt of any fire themselves.
        informed: how many agents learnt of a fire.
        edges: the first warnings.
        agents: number of agents of the run.
        colour: of the group.
        baseline: whether the group is there to be compared with only.
    """

    label: str
    run: str
    steps: int
    rows: tuple[int, ...]
    since: dict[int, int]
    direct: frozenset[int]
    unfounded: frozenset[int]
    informed: int
    edges: tuple[CascadeEdge, ...]
    agents: int
    colour: str
    baseline: bool = False


def draw_cascade(ax: Axes, tree: CascadeTree) -> Axes:
    """Draw agents at the step at which they learnt: a dot if they saw a fire, hollow if told, a cross if neither."""
    place = {agent: -row for row, agent in enumerate(tree.rows)}
    for edge in tree.edges:
        ends = (tree.since[edge.sender], edge.step), (place[edge.sender], place[edge.recipient])
        ax.plot(*ends, color=tree.colour, linewidth=0.8, alpha=0.8, zorder=2)
    for agent in tree.rows:
        face = tree.colour if agent in tree.direct else "white"
        dot = (tree.since[agent], place[agent])
        shape = "x" if agent in tree.unfounded else "o"
        ax.plot(*dot, marker=shape, markersize=3.5, color=tree.colour, markerfacecolor=face, markeredgewidth=0.8)
    informed = f"{tree.informed} of {tree.agents} agents learnt of a fire"
    ax.set_title(wrapped(tree.label, 44) + "\n" + informed, size=7, color=BASELINE if tree.baseline else style.DARK)
    names = [str(agent) for agent in tree.rows] if len(tree.rows) <= _NUMBERED else [""] * len(tree.rows)
    ax.set_yticks(list(place.values()), names, size=7)
    ax.set_xlim(0, tree.steps + 1)
    ax.set_ylim(-max(len(tree.rows), 1) + 0.4, 0.6)
    return ax


def cascade_height(tree: CascadeTree) -> float:
    """Return the height of the picture of a tree, inches."""
    return 0.6 + 0.13 * wrapped(tree.label, 44).count("\n") + max(0.25, 0.125 * len(tree.rows))
