"""Texts around the pictures of a film: the run, the step and its messages."""

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
"""Maximum number of lines of messages in a step."""
_NAMED = 8
"""Maximum number of recipients that are named; for more recipients, only the number is shown."""


class _Speech(msgspec.Struct):
    """The needed part of a line of `steps.jsonl`."""

    step: int
    agent: int
    message: Any = None


@lru_cache(maxsize=64)
def said_by_step(recording: Recording) -> Mapping[int, Sequence[str]]:
    """Return the messages of each step, as "agent 3 to 4, 7: text"; messages without recipients come last.

    Raises:
        RecordError: the records are damaged.
    """
    heard: dict[tuple[int, int, str], list[int]] = {}
    for one in lines_of(recording.messages, Message, recording.folder):
        heard.setdefault((one.step, one.sender, one.text), []).append(one.recipient)
    found: dict[int, list[tuple[bool, str]]] = {}
    for line in lines_of(recording.steps, _Speech, recording.folder):
        if isinstance(line.message, str):
            to = heard.get((line.step, line.agent, line.message), [])
            said = f"agent {line.agent} to {_to(to)}: {' '.join(line.message.split())}"
            found.setdefault(line.step, []).append((not to, said))
    return {step: [said for _, said in sorted(spoken, key=itemgetter(0))] for step, spoken in found.items()}


def _to(recipients: Sequence[int]) -> str:
    if len(recipients) > _NAMED:
        return f"{len(recipients)} agents"
    return ", ".join(map(str, recipients)) or "nobody"


def in_lines(said: Sequence[str], width: int, most: int) -> list[str]:
    """Return texts as lines of the given width, pixels, as many as fit; the last line counts the omitted texts."""
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


def _wrapped(text: str, width: int) -> Iterator[str]:
    """Yield lines; a word longer than a line, as in languages without blanks, is broken."""
    line = ""
    for word in text.split():
        if line and width_of(f"{line} {word}") > width:
            yield line
            line = ""
        line = f"{line} {word}".lstrip()
        while width_of(line) > width:
            fits = next(size for size in range(len(line) - 1, 0, -1) if size == 1 or width_of(line[:size]) <= width)
            yield line[:fits]
            line = line[fits:]
    if line:
        yield line


def width_of(line: str) -> float:
    """Return the width of a line, pixels."""
    return _font_of(line).getlength(line)


def _font_of(text: str) -> ImageFont.FreeTypeFont:
    """Return the first font with all letters of a text, or else the font that lacks the fewest letters."""
    return _loaded(min(letters_by_file().items(), key=lambda one: len(lacking(text, one[1])))[0])


@cache
def _loaded(file: str) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(file, TEXT_PX)


def boxes_note(texts: Iterable[str]) -> str:
    """Return a remark on letters that no font of this machine has, or ""."""
    fonts = letters_by_file().values()
    boxes = sorted(set().union(*(min((lacking(text, letters) for letters in fonts), key=len) for text in texts)))
    if not boxes:
        return ""
    some = "".join(boxes[:_NAMED]) + (" …" if len(boxes) > _NAMED else "")
    return f"No font here has {some}, so they are drawn as boxes. Install one of {', '.join(FALLBACK_FONTS)}."


def band(lines: Sequence[str], width: int, room: int) -> Image.Image:
    """Return an image of lines of text, with room for `room` lines."""
    sheet = Image.new("RGB", (width, band_height(room)), PAPER)
    pen = ImageDraw.Draw(sheet)
    for number, line in enumerate(lines):
        pen.text((MARGIN_PX, MARGIN_PX // 2 + number * LINE_PX), line, fill=INK, font=_font_of(line))
    return sheet


def band_height(room: int) -> int:
    """Return the height of a band for this number of lines, pixels; 0 for none."""
    return room * LINE_PX + MARGIN_PX if room else 0
