"""Draws a world of rounds as a PNG with one lane per agent; the same lines give the same bytes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import msgspec

from foundry.declared import Actions
from foundry.palette import label_colour
from foundry.records import RoundStep

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

SIZE = (800, 500)
"""Pixels."""
IDLE = "#5F6670"
"""Colour of idle actions."""
UNREAD, TALK, WORDS = "#FFFFFF", "#E4E4EC", "#333344"
LOW, HIGH = (239, 243, 255), (8, 81, 156)
"""Colours of the smallest and the largest number."""
_LEFT, _TOP, _RIGHT, _BOTTOM = 56, 40, 784, 440
MOST_NUMBERED = 30
"""Largest number of agents whose ids are drawn; more would overlap."""
LONGEST = 24
"""Maximal number of characters of a label in the legend."""


@dataclass(frozen=True)
class _Lanes:
    """The positions of lanes and rounds in pixels."""

    agents: int
    steps: int

    def box(self, step: int, agent: int, part: int, parts: int) -> tuple[int, int, int, int]:
        """Return the first and the last pixel of a decision of an agent in a round."""
        width, height = (_RIGHT - _LEFT) / self.steps, (_BOTTOM - _TOP) / self.agents
        gap = 2 if min(width / parts, height) > 4 else 1
        left, right = (_LEFT + (step - 1 + one / parts) * width for one in (part, part + 1))
        x, y = round(left), round(_TOP + agent * height)
        return (x, y, max(round(right) - gap, x), max(round(_TOP + (agent + 1) * height) - gap, y))


def draw(lines: Sequence[RoundStep], step: int, *, agents: int, steps: int, actions: Mapping[str, Actions]) -> bytes:
    """Return the decisions so far as a PNG; later lines of an agent in a round are further right."""
    from PIL import Image, ImageDraw

    image = Image.new("RGB", SIZE, "white")
    canvas = ImageDraw.Draw(image)
    lanes = _Lanes(agents, max(steps, step, 1))
    ranges = {kind: _with_ends(known, kind, lines) for kind, known in actions.items()}
    canvas.text((_LEFT, 12), f"Round {step}", fill=WORDS)
    canvas.rectangle((_LEFT - 1, _TOP - 1, _RIGHT, _BOTTOM), outline="#AAAAB4")
    for agent in range(agents) if agents <= MOST_NUMBERED else ():
        _, top, _, bottom = lanes.box(1, agent, 0, 1)
        canvas.text((_LEFT - 28, (top + bottom) // 2 - 6), str(agent), fill=WORDS)
    for (when, agent), group in groupby(sorted(lines, key=_place), key=_place):
        own = list(group)
        for part, line in enumerate(own):
            box = lanes.box(when, agent, part, len(own))
            canvas.rectangle(box, fill=_colour(line, ranges), outline="#C8C8D0" if line.action is None else None)
    _legend(canvas, ranges)
    png = io.BytesIO()
    image.save(png, format="PNG")
    return png.getvalue()


def _with_ends(known: Actions, kind: str, lines: Sequence[RoundStep]) -> Actions:
    """Return the possible decisions; an unbounded range gets the bounds of the numbers so far."""
    numbers = [one.action for one in lines if one.kind == kind and isinstance(one.action, int | float)]
    low = min(numbers, default=0) if known.low is None else known.low
    high = max(numbers, default=1) if known.high is None else known.high
    return msgspec.structs.replace(known, low=low, high=high)


def _place(line: RoundStep) -> tuple[int, int]:
    return (line.step, line.agent)


def _colour(line: RoundStep, actions: Mapping[str, Actions]) -> str:
    known = actions.get(line.kind)
    if known is None:
        return TALK
    if line.action is None:
        return UNREAD
    if line.action in known.labels:
        return _tone(str(line.action), known)
    return _shade(float(line.action), known) if isinstance(line.action, int | float) else TALK


def _tone(label: str, known: Actions) -> str:
    place = known.labels.index(label)
    if label == known.idle:
        return IDLE
    return label_colour(place)


def _shade(number: float, known: Actions) -> str:
    low, high = known.low or 0.0, known.high or 0.0
    share = min(max((number - low) / (high - low), 0.0), 1.0) if high > low else 0.0
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in zip(LOW, HIGH, strict=True))


def _legend(canvas: ImageDraw, actions: Mapping[str, Actions]) -> None:
    """Draw a legend of the colours, as far as there is room."""
    x, y = float(_LEFT), float(_BOTTOM + 14)
    for kind, known in actions.items():
        for label in known.labels or (f"{kind}: {known.low:g} to {known.high:g}",):
            colour = _tone(label, known) if known.labels else _shade(known.high or 0.0, known)
            text = label if len(label) <= LONGEST else f"{label[:LONGEST]}..."
            if x + 24 + canvas.textlength(text) > _RIGHT:
                x, y = float(_LEFT), y + 18
            canvas.rectangle((x, y, x + 11, y + 11), fill=colour)
            canvas.text((x + 16, y), text, fill=WORDS)
            x += 34 + canvas.textlength(text)
