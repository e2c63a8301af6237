"""Reads what a reply says line by line: `action: move`, `**Direction:** up`, `<action>stay</action>`."""

from __future__ import annotations

import json
import re
from typing import Any

from foundry.worlds.grid.vocabulary import KEYS
from foundry.worlds.grid.words import key_of
from foundry.worlds.replies import merged

_MOST = 32
"""Labels of a text; one with more is no reply to the question."""

_NAMES = "|".join(re.escape(name) for names in KEYS.values() for name in sorted(names, key=len, reverse=True))
_LABEL = re.compile(
    r"(?:^|(?<=[,;|{}])|(?<=[\s\"'”])(?=[\"'“]))"
    r"[ \t>|{*•#\d.)_`\"'“-]{0,12}+(?:(?:my|your|the|final|next|chosen)[ ]){0,2}"
    rf"({_NAMES})[ \t*_`\"'”]{{0,6}}+[:：=](?!=)[ \t*_`]*+",
    re.IGNORECASE | re.MULTILINE,
)
_LABEL_END = re.compile("[:：=]")
_TAG = re.compile(rf"<(/?)\s*+({_NAMES})\s*+>", re.IGNORECASE)
_HEADING = re.compile(
    rf"^[ \t]{{0,8}}+(?:#{{1,6}}+[ \t]{{0,4}}+\**|\*\*)({_NAMES})\**[ \t]{{0,8}}+$", re.IGNORECASE | re.MULTILINE
)
_FENCE = re.compile(r"^[ \t]{0,8}+```\w{0,20}+[ \t]{0,8}+$", re.MULTILINE)
_ESCAPES = re.compile(r'(?:\\u[0-9a-fA-F]{4})+|\\["\\/bfnrt]')
_BLANK_LINE = re.compile(r"\n[ \t]*+\n")
_COMMENT = re.compile(r"""(["'”]|\bnull|\bnone)\s*+,?\s*+(?://|\#|/\*)[^\n]{0,200}+\s*+\Z""", re.IGNORECASE)
_MARKUP = " \t\r\n*_`,"
_QUOTES = (('"', '"'), ("'", "'"), ("“", "”"), ("「", "」"), ("«", "»"))


def labelled_values(text: str, *, cut: bool) -> dict[str, Any]:
    """Return the values that stand after the names of keys.

    Args:
        text: a reply without an object in it.
        cut: whether it ends where it was cut; then its last value may not be all.

    Returns:
        Texts by key, in the names that are asked for; `Conflicting` where one comes with different texts.
    """
    text = _TAG.sub(lambda tag: "\n" if tag[1] else f"\n{tag[2]}: ", _FENCE.sub("", text))
    text = _HEADING.sub(r"\1: ", text)
    labels = list(_LABEL.finditer(text)) if _LABEL_END.search(text) else []
    if not labels or len(labels) > _MOST:
        return {}
    ends = [label.start() for label in labels[1:]] + [len(text)]
    found = [(key_of(label[1]) or "", text[label.end() : end]) for label, end in zip(labels, ends, strict=True)]
    if cut or found[-1][0] == "message" and _BLANK_LINE.search(found[-1][1].strip()):
        found.pop()
    return merged([(key, _value(key, value)) for key, value in found])


def _value(key: str, text: str) -> str:
    """Return a value without its markup and the comment after it; a decision is one line."""
    text = _COMMENT.sub(r"\1", text)
    value = text.strip(_MARKUP).removesuffix("}").strip(_MARKUP)
    if key in ("action", "direction"):
        value = value.split("\n", 1)[0].strip(_MARKUP)
    for opening, closing in _QUOTES:
        if len(value) > 1 and value.startswith(opening) and value.endswith(closing):
            return _ESCAPES.sub(lambda match: str(json.loads(f'"{match[0]}"')), value[1:-1])
    return value
