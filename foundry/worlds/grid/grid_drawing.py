"""Draws a 2D world as a PNG; equal frames give equal bytes."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from foundry.palette.fonts import families
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.space import Cell, Fire, Place, neighbours

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALL_COLOUR, EXIT_COLOUR, FOOD_COLOUR, BURNING_COLOUR, ZONE_COLOUR = (
    "#444450",
    "#0072B2",
    "#8CC084",
    "#D55E00",
    "#A03050",
)


@dataclass(frozen=True, slots=True)
class Furniture:
    """The walls, exits, zones and food in a picture, with the ids and numbers of agents.

    Attributes:
        ids: ids of the present agents, in the order of the frame's cells.
        walls: cells that nobody can enter.
        exits: name and cells of each exit.
        zones: name and cells of each zone.
        food: cells with food, and how full each is, 0 to 1.
        gone: number of agents that are gone, by exit or cause of death.
    """

    ids: tuple[int, ...]
    walls: tuple[Cell, ...] = ()
    exits: tuple[tuple[str, tuple[Cell, ...]], ...] = ()
    zones: tuple[tuple[str, tuple[Cell, ...]], ...] = ()
    burning: tuple[Cell, ...] = ()
    food: tuple[tuple[Cell, float], ...] = ()
    gone: tuple[tuple[str, int], ...] = ()


def draw_furniture(axes: Axes, furniture: Furniture) -> None:
    """Draw walls, exits with their names, zones, burning cells and food; fires and agents appear above these."""
    _fill(axes, [cell for cell, _ in furniture.food], FOOD_COLOUR, [0.2 + 0.6 * full for _, full in furniture.food])
    for _, cells in furniture.zones:
        _fill(axes, cells, ZONE_COLOUR, 0.2)
    _fill(axes, furniture.walls, WALL_COLOUR, 1.0)
    _fill(axes, furniture.burning, BURNING_COLOUR, 0.55)
    for name, cells in furniture.exits:
        _fill(axes, cells, EXIT_COLOUR, 0.9)
        place: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "zorder": 7, "bbox": _BACKING}
        axes.annotate(name, cells[0], (0, 9), fontsize=9, fontfamily=families(), color=EXIT_COLOUR, **place)
    if furniture.gone:
        text = ", ".join(f"{count} {name}" for name, count in furniture.gone)
        axes.set_title(f"gone: {text}", fontsize=10, loc="right", y=1.0, color="#333344")


def _fill(axes: Axes, cells: Sequence[Cell], colour: str, alpha: float | Sequence[float]) -> None:
    """Fill cells with a colour; `alpha` is the opacity of all cells, or a list with one opacity per cell."""
    from matplotlib.collections import PolyCollection

    if not cells:
        return
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    squares = np.array(cells, dtype=float).reshape(-1, 1, 2) + corners
    axes.add_collection(PolyCollection(squares, facecolor=colour, alpha=alpha, linewidth=0, zorder=1.5))


PERSONA_COLOURS = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#F0E442", "#BBBBBB")
"""Colours that colour-blind people can tell apart (Okabe and Ito); fires have another colour of this palette."""

FIRE_COLOUR = "#D55E00"
PLACE_COLOUR = "#E8E8EE"
_BACKING = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.0}
"""The style of the white box behind a name in the picture."""
MOST_NUMBERED = 60
"""Up to this number of agents, the picture shows the ids of agents; more ids would hide the picture."""


@dataclass(frozen=True, slots=True)
class GridFrame:
    """The data from which a picture of a 2D world is drawn; lists of agents are sorted by id.

    Attributes:
        step: number of completed steps.
        half_size: both axes run from -half_size to +half_size.
        occupancy: number of agents in each place.
        fires: the fires that burned at `step`.
        cells: each agent's cell after the moves of `step`.
        groups: each agent's value of the first persona attribute, or "" without attributes.
        group_names: all values of that attribute, in the order of the colours.
        links: pairs of agents that can talk, the lower id first.
        furniture: walls, exits and other parts, or None; with it, `cells` and `groups` omit absent agents.
    """

    step: int
    half_size: int
    places: tuple[Place, ...]
    occupancy: tuple[int, ...]
    fires: tuple[Fire, ...]
    cells: tuple[Cell, ...]
    groups: tuple[str, ...]
    group_names: tuple[str, ...]
    links: tuple[tuple[int, int], ...]
    furniture: Furniture | None = None


def make_frame(
    settings: GridSettings,
    personas: Sequence[dict[str, str]],
    step: int,
    cells: Sequence[Cell],
    near: Sequence[tuple[int, ...]] | None = None,
) -> GridFrame:
    """Return the frame after `step` steps.

    Args:
        settings: the world.
        personas: persona of each agent.
        step: number of completed steps.
        cells: cell of each agent.
        near: neighbours of each agent; None to compute them.
    """
    grid = np.array(cells, dtype=np.int64).reshape(-1, 2)
    areas = settings.field.areas(grid)
    if near is None:
        near = neighbours(grid, areas, settings.communication_distance)
    attribute = next(iter(settings.personas), "")
    return GridFrame(
        step=step,
        half_size=settings.half_size,
        places=settings.places,
        occupancy=tuple(int((areas == index).sum()) for index in range(len(settings.places))),
        fires=tuple(fire for fire in settings.fires if fire.start <= step),
        cells=tuple(cells),
        groups=tuple(persona.get(attribute, "") for persona in personas),
        group_names=tuple(str(value) for value in settings.personas.get(attribute, {})),
        links=tuple((agent, other) for agent, others in enumerate(near) for other in others if agent < other),
    )


def draw(frame: GridFrame) -> bytes:
    """Return the frame as a PNG of 800 x 800 pixels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 8), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.07, 0.1, 0.88, 0.85))
    _draw_axes(axes, frame)
    _draw_places(axes, frame)
    if frame.furniture is not None:
        draw_furniture(axes, frame.furniture)
    _draw_fires(axes, frame)
    _draw_agents(axes, frame)
    png = io.BytesIO()
    # No software entry: its version would change the bytes.
    figure.savefig(png, format="png", metadata={"Software": None})
    return png.getvalue()


def _draw_axes(axes: Axes, frame: GridFrame) -> None:
    edge = frame.half_size + 1
    axes.set_xlim(-edge, edge)
    axes.set_ylim(-edge, edge)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=9, colors="#555555")
    axes.set_title(f"Step {frame.step}", fontsize=13, loc="left", y=1.0)


def _draw_places(axes: Axes, frame: GridFrame) -> None:
    from matplotlib.patches import Rectangle

    for place, agents in zip(frame.places, frame.occupancy, strict=True):
        corner = (place.x_min - 0.5, place.y_min - 0.5)
        size = (2 * place.extent[0] + 1, 2 * place.extent[1] + 1)
        axes.add_patch(Rectangle(corner, *size, facecolor=PLACE_COLOUR, edgecolor="#555566", linewidth=1.2))
        label = f"{place.name} {agents}/{place.capacity}"
        _write(axes, place.center[0], place.y_max + 0.8, label, colour="#333344", frame=frame)


def _draw_fires(axes: Axes, frame: GridFrame) -> None:
    from matplotlib.patches import Circle

    for fire in frame.fires:
        shade = 0.08 + 0.2 * fire.intensity
        axes.add_patch(Circle(fire.position, fire.radius, facecolor=FIRE_COLOUR, alpha=shade, linewidth=0))
        axes.add_patch(Circle(fire.position, fire.radius, fill=False, edgecolor=FIRE_COLOUR, linewidth=1))
        axes.plot(*fire.position, marker="X", markersize=11, color=FIRE_COLOUR, markeredgecolor="white")
        label = f"{fire.name} ({fire.intensity})"
        _write(axes, fire.position[0], fire.position[1] + 1, label, colour="#8A3B00", frame=frame)


def _write(axes: Axes, x: float, y: float, label: str, *, colour: str, frame: GridFrame) -> None:
    """Write a label above a point; a label near the edge is moved inside the picture."""
    reach = frame.half_size - 1
    x_inside = min(max(x, -0.85 * reach), 0.85 * reach)
    y_inside = min(max(y, -0.97 * reach), 0.93 * reach)
    place: dict[str, Any] = {"ha": "center", "va": "bottom", "zorder": 2.5, "bbox": _BACKING}
    axes.text(x_inside, y_inside, label, color=colour, fontsize=10, fontfamily=families(), **place)


def _draw_agents(axes: Axes, frame: GridFrame) -> None:
    from matplotlib.collections import LineCollection

    points = _spread(frame.cells)
    lines = [(points[first], points[second]) for first, second in frame.links]
    axes.add_collection(LineCollection(lines, colors="#888888", linewidths=0.9, alpha=0.7, zorder=3))
    numbered = len(frame.cells) <= MOST_NUMBERED
    for index, group in enumerate(frame.group_names or ("",)):
        members = [point for point, own in zip(points, frame.groups, strict=True) if own == group]
        if members:
            x, y = np.array(members).T
            colour = PERSONA_COLOURS[index % len(PERSONA_COLOURS)]
            size = 130 if numbered else 14
            axes.scatter(x, y, s=size, c=colour, edgecolors="white", linewidths=0.7, label=group, zorder=4)
    if numbered:
        ids = range(len(points)) if frame.furniture is None else frame.furniture.ids
        for agent, (x, y) in zip(ids, points, strict=True):
            axes.text(x, y, str(agent), fontsize=7, color="black", ha="center", va="center_baseline", zorder=6)
    if any(frame.group_names):
        letters = {"family": families(), "size": 10}
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.04), ncols=6, frameon=False, prop=letters)


def _spread(cells: Sequence[Cell]) -> list[tuple[float, float]]:
    """Return the point where each agent is drawn; agents in one cell form a small circle."""
    sharing: dict[Cell, list[int]] = {}
    for agent, cell in enumerate(cells):
        sharing.setdefault(cell, []).append(agent)
    points: list[tuple[float, float]] = [(float(x), float(y)) for x, y in cells]
    for (x, y), agents in sharing.items():
        if len(agents) > 1:
            for turn, agent in enumerate(agents):
                angle = 2 * np.pi * turn / len(agents)
                points[agent] = (x + 0.45 * float(np.cos(angle)), y + 0.45 * float(np.sin(angle)))
    return points
