"""Draws the cells around an agent of a 2D world before a decision, as a small SVG for a page."""

from collections.abc import Iterator
from html import escape

import numpy as np

from analysis.grid.grid_run import GridRun
from analysis.plots.style import FIRE

REACH = 8.5
"""Number of cells that are shown on each side of the agent."""


def crop(run: GridRun, step: int, agent: int) -> str:
    """Return a picture of the cells around an agent before a decision, as HTML in the colours of the page."""
    x, y = run.x[step - 1], run.y[step - 1]
    own = int(x[agent]), int(y[agent])
    near = run.there[step - 1] & (np.maximum(abs(x - own[0]), abs(y - own[1])) <= REACH)
    near[agent] = False
    said = f"Agent {agent} at {own}, {int(near.sum())} others within {int(REACH)} cells."
    corner, side = (own[0] - REACH, -own[1] - REACH), 2 * REACH
    parts = "".join(
        [
            *_world(run, step),
            *(_agent(int(x[agent]), int(y[agent]), str(agent), chosen=False) for agent in np.flatnonzero(near)),
            _agent(*own, str(agent), chosen=True),
        ]
    )
    box = f"{corner[0]:g} {corner[1]:g} {side:g} {side:g}"
    return f'<div class="crop" role="img" aria-label="{escape(said)}"><svg viewBox="{box}">{parts}</svg></div>'


def _world(run: GridRun, step: int) -> Iterator[str]:
    """Yield the walls, the places and the burning fires; y grows upwards in the world and downwards in SVG."""
    for (x, y), (other_x, other_y) in run.world.walls:
        yield _box((min(x, other_x), min(y, other_y)), (max(x, other_x), max(y, other_y)), 'fill-opacity=".5"')
    for place in run.world.places:
        yield _box(place.low, place.high, 'fill-opacity=".1" stroke="currentColor" stroke-width=".12"')
        yield _text(place.center[0], -place.high[1] + 0.6, place.name)
    for fire in (fire for fire in run.world.fires if fire.start <= step):
        x, y = fire.position
        look = f'fill="{FIRE}" fill-opacity=".15" stroke="{FIRE}" stroke-width=".12" stroke-dasharray=".6 .3"'
        yield f'<circle cx="{x}" cy="{-y}" r="{fire.radius:g}" {look}/>'
        yield _text(x, 0.3 - y, f"× {fire.name}")


def _box(low: tuple[int, int], high: tuple[int, int], look: str) -> str:
    width, height = high[0] - low[0] + 1, high[1] - low[1] + 1
    return (
        f'<rect x="{low[0] - 0.5}" y="{-high[1] - 0.5}" width="{width}" height="{height}" fill="currentColor" {look}/>'
    )


def _agent(x: int, y: int, name: str, *, chosen: bool) -> str:
    look = 'r=".85" fill="currentColor"' if chosen else 'r=".7" fill="currentColor" fill-opacity=".25"'
    letters = 'fill="var(--paper)" font-weight="700"' if chosen else 'fill="currentColor"'
    return f'<circle cx="{x}" cy="{-y}" {look}/><text x="{x}" y="{0.32 - y}" font-size=".9" {letters}>{name}</text>'


def _text(x: float, y: float, text: str) -> str:
    return f'<text x="{x:g}" y="{y:g}" font-size="1" fill="currentColor">{escape(text)}</text>'
