"""Formats of prompts: they change headings, labels, lists, words and the order of sections, but not the content.

A space of formats lists options for each feature; a format chooses one option per feature (FormatSpread, Sclar et al.
2024, arXiv 2310.11324). Marks in the source of a template enclose the parts that may change, such as headings. foundry
sets the marks before it fills in an observation, so a format never changes the messages of agents, nor the requested
form of the reply.
"""

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from foundry import seeding
from foundry.errors import InputError, not_found
from foundry.naming import format_of

AS_WRITTEN = "as written"
CASES: Mapping[str, Callable[[str], str]] = {
    AS_WRITTEN: str,
    "upper": str.upper,
    "lower": str.lower,
    "title": str.title,
}
ORDERS = (AS_WRITTEN, "reversed", "shuffled")
STRUCTURES = ("lines", "json")
FEATURES: Mapping[str, Any] = {
    "heading": "=== {} ===",
    "case": AS_WRITTEN,
    "separator": ": ",
    "item": "- ",
    "order": AS_WRITTEN,
    "structure": "lines",
    "wording": {},
}
"""The features of a format, with the options that leave a prompt unchanged."""
_MOST = 1_000_000
"""Maximum number of formats in a space."""
_HEADING, _TITLE, _LABEL, _VALUE, _ITEM, _POINT, _END, _REPLY = (chr(0xF8F0 + number) for number in range(8))
"""Characters that mark headings, labels and so on in a template; Unicode reserves them for private use."""
_MARKS = re.compile(f"[{_HEADING}-{_REPLY}]")
_TAG = re.compile(r"(\{\{.*?\}\}|\{%.*?%\}|\{#.*?#\})", re.DOTALL)
_SHAPE = re.compile(r"(^[ \t]*\{[ \t]*\n.*?^[ \t]*\}[ \t]*$)", re.DOTALL | re.MULTILINE)
_ASKS = re.compile(r"(?P<text>[^\W\d_][\w ,']*):$")
_LINES = (
    (re.compile(r"(=== )(?P<text>[^{}\n]+)( ===)$"), f"{_HEADING}{{text}}{_END}"),
    (re.compile(r"(#{1,3} )(?P<text>[^{}\n]+)$"), f"{_HEADING}{{text}}{_END}"),
    (_ASKS, f"{_TITLE}{{text}}{_END}"),
    (re.compile(r"- (?P<text>[^{}\n]+)$"), f"{_POINT}{{text}}{_END}"),
    (re.compile(r"- (?P<text>.+)$"), f"{_ITEM}{{text}}{_END}"),
    (
        re.compile(r"(?P<label>[^\W\d_][\w ]{0,40}|\{\{[^{}]*\}\}): (?P<text>.*\{\{.*)$"),
        f"{_LABEL}{{label}}{_VALUE}{{text}}{_END}",
    ),
)
_MARKED = re.compile(
    f"(?P<mark>[{_HEADING}{_TITLE}{_ITEM}{_POINT}])(?P<text>[^{_END}]*){_END}"
    f"|{_LABEL}(?P<label>[^{_VALUE}]*){_VALUE}(?P<value>[^{_END}]*){_END}"
)


@dataclass(frozen=True)
class Format:
    """A random layout of a prompt, drawn from all layouts of a space.

    Attributes:
        name: name of the format, such as `spread/3`.
        chosen: option of each feature.
        draw: index of the format in its space, which also determines the order of shuffled sections.
    """

    name: str
    chosen: Mapping[str, Any]
    draw: int

    @classmethod
    def of(cls, space: Mapping[str, Any]) -> "Format":
        """Return the format that `draw` chooses from a space.

        Args:
            space: `name`; `options`, a list per feature; and `draw`, an index into all formats in random order.

        Raises:
            InputError: a feature or an option is unknown, or `draw` is too large.
        """
        name, options, draw = space.get("name"), space.get("options"), space.get("draw")
        if not isinstance(options, Mapping) or not options:
            raise InputError(f"Format '{name}': its file needs 'options:' with a list for each feature.")
        for feature, listed in options.items():
            _check(str(name), feature, listed)
        if type(draw) is not int:
            raise InputError(f"format={name} is a space of formats: draw some, for example with -m format={name}/0-9.")
        sizes = [len(listed) for listed in options.values()]
        if (total := math.prod(sizes)) > _MOST:
            raise InputError(
                f"The space of formats '{name}' has {total:,} formats, more than {_MOST:,}: give it fewer options."
            )
        if draw >= total:
            raise InputError(f"format={name}/{draw} does not exist: give a format from {name}/0 to {name}/{total - 1}.")
        place = seeding.stream(0, f"formats:{name}").permutation(total)[draw]
        drawn = np.unravel_index(place, sizes)
        chosen = {feature: options[feature][int(number)] for feature, number in zip(options, drawn, strict=True)}
        return cls(format_of({"format": space}), {**FEATURES, **chosen}, draw)

    def marked(self, source: str) -> str:
        """Replace words in a template as the format says, and mark the parts whose layout the format may change."""
        outside = _SHAPE.split(source)
        changed = [
            _REPLY + part if number % 2 else _lines_marked(self._reworded(part), last=number + 1 == len(outside))
            for number, part in enumerate(outside)
        ]
        return "".join(changed)

    def laid_out(self, text: str) -> str:
        """Format the text of a filled template, and remove the marks."""
        return _MARKS.sub("", self._in_order(text))

    def _reworded(self, part: str) -> str:
        words = _TAG.split(part)
        for phrase, other in self.chosen["wording"].items():
            words[::2] = [literal.replace(phrase, other) for literal in words[::2]]
        return "".join(words)

    def _in_order(self, text: str) -> str:
        """Return a prompt's text in this format, with reordered sections. Text before the first section stays first."""
        first, *sections = re.split(f"(?m)^(?={_HEADING})", text)
        last = next((number for number, section in enumerate(sections) if _REPLY in section), len(sections) - 1)
        free = [number for number in range(len(sections)) if number != last]
        if self.chosen["order"] == AS_WRITTEN or len(free) < 2:
            return self._written(text)
        moved = dict(zip(free, self._moved([sections[number] for number in free]), strict=True))
        ordered = [moved.get(number, section) for number, section in enumerate(sections)]
        return self._written(first) + "\n\n".join(self._written(section.rstrip("\n")) for section in ordered)

    def _moved(self, sections: Sequence[str]) -> list[str]:
        if self.chosen["order"] == "reversed":
            return list(reversed(sections))
        # The order depends on the headings, so that an omitted section does not change the order of others.
        drawn = (seeding.stream(self.draw, f"section:{section.partition(_END)[0]}").random() for section in sections)
        return [section for _, section in sorted(zip(drawn, sections, strict=True))]

    def _written(self, text: str) -> str:
        marked = list(_MARKED.finditer(text))
        pieces, end = [], 0
        for run in _runs(marked, text):
            pieces.append(text[end : run[0].start()])
            pieces.append(self._run(run, text))
            end = run[-1].end()
        return "".join([*pieces, text[end:]])

    def _run(self, run: Sequence[re.Match[str]], text: str) -> str:
        cased = CASES[self.chosen["case"]]
        if run[0]["mark"] in (_HEADING, _TITLE):
            return str(self.chosen["heading"].format(cased(run[0]["text"])))
        if run[0]["mark"] in (_ITEM, _POINT):
            if run[0]["mark"] == _ITEM and self.chosen["structure"] == "json":
                return json.dumps([match["text"] for match in run], ensure_ascii=False)
            marks = (self.chosen["item"].replace("{n}", str(number)) for number in range(1, len(run) + 1))
            return _joined([mark + match["text"] for mark, match in zip(marks, run, strict=True)], run, text)
        if self.chosen["structure"] == "json":
            return json.dumps({cased(match["label"]): match["value"] for match in run}, ensure_ascii=False)
        return _joined([cased(match["label"]) + self.chosen["separator"] + match["value"] for match in run], run, text)


def unmarked(value: Any) -> Any:
    """Remove from a value all characters that mark parts of a template, so that the value is never taken for a mark."""
    return _MARKS.sub("", value) if isinstance(value, str) else value


def _lines_marked(part: str, *, last: bool) -> str:
    head, line_break, asking = ("", "", "") if last else part.rstrip("\n").rpartition("\n")
    if not last and _ASKS.match(asking):  # asks for the reply, and its form follows
        tail = part[len(part.rstrip("\n")) :]
        return _lines_marked(head, last=True) + line_break + asking + tail
    return "\n".join(_line_marked(line) for line in part.split("\n"))


def _line_marked(line: str) -> str:
    text = line.lstrip(" ")
    for pattern, marks in _LINES:
        if marked := pattern.match(text):
            # Jinja drops the line break after a tag, even without the mark.
            tail = "{##}" if text.endswith(("%}", "#}")) else ""
            return line[: len(line) - len(text)] + marks.format(**marked.groupdict()) + tail
    return line


def _runs(matches: Sequence[re.Match[str]], text: str) -> Iterator[list[re.Match[str]]]:
    """Yield groups of labels, or of list items, that only blanks separate; a heading is a group of its own."""
    places: list[tuple[int, re.Match[str]]] = []
    number = 0
    for match in matches:
        before = places[-1][1] if places else None
        follows = (
            before is not None and _kind(before) == _kind(match) and not text[before.end() : match.start()].strip()
        )
        number += not (follows and _kind(match) in (_ITEM, _POINT, _LABEL))
        places.append((number, match))
    for _, run in groupby(places, key=lambda place: place[0]):
        yield [match for _, match in run]


def _kind(match: re.Match[str]) -> str:
    return match["mark"] or _LABEL


def _joined(written: Sequence[str], run: Sequence[re.Match[str]], text: str) -> str:
    between = [text[match.end() : other.start()] for match, other in zip(run, run[1:], strict=False)]
    return "".join(part for pair in zip(written, [*between, ""], strict=True) for part in pair)


def _check(name: str, feature: str, listed: Any) -> None:
    where = f"Format '{name}'"
    if feature not in FEATURES:
        raise not_found(f"{where}: feature", feature, FEATURES)
    if not isinstance(listed, Sequence) or isinstance(listed, str) or not listed:
        raise InputError(f"{where}: {feature} must be a list of options: write {feature}: [...].")
    known = {"case": CASES, "order": ORDERS, "structure": STRUCTURES}.get(feature)
    for option in listed:
        if known is not None and option not in known:
            raise not_found(f"{where}: option of {feature}", str(option), known)
        if feature == "heading" and (not isinstance(option, str) or option.count("{}") != 1 or option.count("{") > 1):
            raise InputError(f"{where}: heading '{option}' must contain {{}} once, for the text of the heading.")
        if feature in ("separator", "item") and not isinstance(option, str):
            raise InputError(f"{where}: {feature} '{option}' must be a text: put it in quotation marks.")
        if feature == "wording" and not _are_phrases(option):
            raise InputError(f"{where}: wording {option} must map phrases to other phrases, without line breaks.")


def _are_phrases(option: Any) -> bool:
    if not isinstance(option, Mapping):
        return False
    return all(isinstance(word, str) and word and "\n" not in word for pair in option.items() for word in pair)
