"""Leaves out of a text what it quotes of earlier steps, and what it lists to choose from."""

from __future__ import annotations

import re

_OPEN, _CLOSE = '"“„«「『', '"”“»」』'
_SAID = r"said|replied|answered|wrote|responded|chose|was|were|did|executed|tried|attempted|had|to saying"
_SAID_CJK = r"(?:说了?|回答了?|回复了?|选择了|答|写了?|是说)"
_FOLLOWING = (
    r"(?:was|were|did|didn't|had|has|got|led|brought|caused|ended|resulted|failed|worked|moved)\b|->|=>|"
    r"と(?:言|答|指示|返|回答|述|書|いう|して)|という|，?(?:被|但|没|失败|之后|后)"
)
_QUOTED = re.compile(rf"[{_OPEN}]([^{_OPEN}{_CLOSE}\n{{}}]{{1,200}})[{_CLOSE}]")
_BEFORE = re.compile(rf"(?:\b(?:{_SAID})|{_SAID_CJK})[ ,:，：]{{0,3}}\Z", re.IGNORECASE)
_AFTER = re.compile(rf"\s{{0,2}}(?:{_FOLLOWING})", re.IGNORECASE)
_REACH = 24
"""Characters before a quotation in which the word stands that makes it one."""

_ECHO = re.compile(
    r"(?:^|(?<=[.:\n]))[ *-]{0,4}(?:step|ステップ|第) ?\d{1,4}"
    r"[^\n.]{0,200}?(?:\.(?=\d)[^\n.]{0,60}?)?"
    r"(?:->|=>|→)[^\n.]{0,200}",
    re.IGNORECASE | re.MULTILINE,
)
_HEADING = re.compile(
    r"\b(?:options|possible (?:next )?(?:movements|actions|moves|steps|commands)|alternatives|choices|possibilities|"
    r"candidates|history|previous (?:steps|movements|actions|moves|commands)|(?:past|last|recent|earlier) "
    r"(?:steps|movements|actions|moves|commands|decisions)|so far)\b|"
    r"选项|可选|可能的|历史|候选|選択肢|候補|履歴|これまで",
    re.IGNORECASE,
)
_ITEM = re.compile(r"\s*(?:[-*•+–]|\(?(?:\d{1,3}|[a-zA-Z])[.):]|[①-⑳])\s*\S")
_LONGEST_HEADING = 120


def without_quotations(text: str) -> str:
    """Return the text without quotations of earlier steps and without lists of options; linear in its length."""
    if any(mark in text for mark in _CLOSE):
        text = _QUOTED.sub(_kept, text)
    if "->" in text or "=>" in text or "→" in text:
        text = _ECHO.sub(" ", text)
    return _without_lists(text) if "\n" in text else text


def _kept(quoted: re.Match[str]) -> str:
    """Return what is left of a quotation: nothing of a line's start if it is the past."""
    text, start, end = quoted.string, quoted.start(), quoted.end()
    line_starts = not text[max(0, start - _REACH) : start].strip()
    follows = _AFTER.match(text, end)
    if _BEFORE.search(text, max(0, start - _REACH), start) or (follows and not (line_starts and ">" in follows[0])):
        return " "
    return quoted[0]


def _without_lists(text: str) -> str:
    """Drop the lines of lists below a heading such as "Options:"."""
    kept: list[str] = []
    listing = False
    for line in text.split("\n"):
        listing = (listing and (not line.strip() or bool(_ITEM.match(line)))) or _is_heading(line)
        if not listing or not _ITEM.match(line):
            kept.append(line)
    return "\n".join(kept)


def _is_heading(line: str) -> bool:
    bare = line.strip(" *#_`")
    return len(line) <= _LONGEST_HEADING and bare.endswith((":", "：")) and bool(_HEADING.search(bare))
