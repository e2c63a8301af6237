"""Draws the texts of a film: the name of the run, the step, and the messages of the step."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from operator import itemgetter
from typing import Any

import msgspec
from PIL import Image, ImageDraw, ImageFont

from foundry.palette.fonts import FALLBACK_FONTS, lacking, letters_by_file
from foundry.records import Message
from foundry.replay.recording import Recording
from foundry.storing.store import lines_of
from foundry.worlds.camera.eye.overview import INK, LINE_PX, MARGIN_PX, PAPER, TEXT_PX

LINES = 6
"""Maximum number of lines of messages below a picture."""
_NAMED = 8
"""Up to this number of recipients are named with a message; if there are more, only their number is given."""


class _Speech(msgspec.Struct):
    step: int
    agent: int
    message: Any = None


@lru_cache(maxsize=64)
def said_by_step(recording: Recording) -> Mapping[int, Sequence[str]]:
    """Return the messages of each step, such as "agent 3 to 4, 7: hello". Messages that nobody received come last."""
    heard: dict[tuple[int, int, str], list[int]] = {}
    for message in lines_of(recording.messages, Message, recording.folder):
        heard.setdefault((message.step, message.sender, message.text), []).append(message.recipient)
    by_step: dict[int, list[tuple[bool, str]]] = {}
    for line in lines_of(recording.steps, _Speech, recording.folder):
        if isinstance(line.message, str):
            to = heard.get((line.step, line.agent, line.message), [])
            said = f"agent {line.agent} to {_to(to)}: {' '.join(line.message.split())}"
            by_step.setdefault(line.step, []).append((not to, said))
    return {step: [said for _, said in sorted(spoken, key=itemgetter(0))] for step, spoken in by_step.items()}


def _to(recipients: Sequence[int]) -> str:
    if len(recipients) > _NAMED:
        return f"{len(recipients)} agents"
    return ", ".join(map(str, recipients)) or "nobody"


def in_lines(said: Sequence[str], width: int, most: int) -> list[str]:
    """Break texts into at most `most` lines, each at most `width` pixels wide.

    If texts are left out, the last line gives their number, as "and 3 more".
    """
    if not most:
        return []
    shown = said if len(said) <= most else said[: most - 1]
    lines: list[str] = []
    for number, text in enumerate(shown):
        room = (most - (len(said) > most) - len(lines)) // (len(shown) - number)
        lines += _cut(list(_wrapped(text, width)), room)
    return [*lines, f"and {len(said) - len(shown)} more"] if len(said) > len(shown) else lines


def _cut(lines: list[str], most: int) -> list[str]:
    return lines if len(lines) <= most else [*lines[: most - 1], f"{lines[most - 1][:-2]} …"]


def _wrapped(text: str, width: float) -> Iterator[str]:
    """Yield the lines of a text. A word that is longer than a line, as in Japanese, is broken."""
    line = ""
    for word in text.split():
        if line and width_of(f"{line} {word}") > width:
            yield line
            line = ""
        line = f"{line} {word}".lstrip()
        while width_of(line) > width:
            fits = max(1, bisect_right(range(len(line)), width, key=lambda size: width_of(line[:size])) - 1)
            yield line[:fits]
            line = line[fits:]
    if line:
        yield line


def width_of(line: str) -> float:
    """Return the width of a line, pixels."""
    return _font_of(line).getlength(line)


def _font_of(text: str) -> ImageFont.FreeTypeFont:
    """Return the first font that has all letters of a text; if none has them, the font that lacks the fewest."""
    return _loaded(min(letters_by_file().items(), key=lambda font: len(lacking(text, font[1])))[0])


@cache
def _loaded(file: str) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(file, TEXT_PX)


def boxes_note(texts: Iterable[str]) -> str:
    """Return a note about the letters that no font of this machine has; "" if there are none."""
    fonts = letters_by_file().values()
    boxes = sorted(set().union(*(min((lacking(text, letters) for letters in fonts), key=len) for text in texts)))
    if not boxes:
        return ""
    some = "".join(boxes[:_NAMED]) + (" …" if len(boxes) > _NAMED else "")
    return f"No font here has {some}, so they are drawn as boxes. Install one of {', '.join(FALLBACK_FONTS)}."


def band(lines: Sequence[str], width: int, room: int) -> Image.Image:
    """Return an image with lines of text, as high as `room` lines need."""
    sheet = Image.new("RGB", (width, band_height(room)), PAPER)
    pen = ImageDraw.Draw(sheet)
    for number, line in enumerate(lines):
        pen.text((MARGIN_PX, MARGIN_PX // 2 + number * LINE_PX), line, fill=INK, font=_font_of(line))
    return sheet


def band_height(room: int) -> int:
    """Return the height of an image with this number of text lines, pixels; 0 for no line."""
    return room * LINE_PX + MARGIN_PX if room else 0
