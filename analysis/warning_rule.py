"""When a message is a warning: a rule over its words, the same for every model.

A text is a warning when a clause of it mentions a fire and nothing takes the mention back. A mention is the name of a
configured fire, or a word for fire, flames, smoke, burning or evacuation, unless it is part of an expression with
another sense ("fire drill"). The text is cut into sentences and these, at commas and conjunctions, into clauses. A
mention is taken back by, in its clause:

1. a denial before it ("no sign of any fire"), or, in languages where it stands there, behind it ("火事はありません");
2. that it is over ("extinguished", "false alarm"), also when said of it in the rest of the sentence or the next one;
3. another time ("yesterday"), a supposition or a tale before it ("if you see a fire", "a book about fires");
4. a question; what is stated in the same sentence before the question stays ("there is a fire, shall we go?").

What is denied of going there or of its end takes nothing back ("do not go near the fire", "not out yet", "until it is
out"). A clause of at most three words shares the fate of the mention before it ("no fire, smoke, or flames").

Case, width (full-width letters) and Unicode composition make no difference. The words, in twelve languages, are those
of `analysis.warning_words`; those of alphabets with blanks between words match whole words, Chinese, Japanese and
Korean ones anywhere (`fire1` is found in both kinds of text). Time is linear in the text, of which the first 20,000
characters are read. The rule sees words, not meaning.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache

from analysis import warning_words as words
from analysis.words import LETTERS, plain, whole_words

RULE_VERSION = 2
"""Raised whenever a text could be labelled otherwise than before."""

_CACHED_LENGTH = 4096
"""Characters of the longest text whose label is kept."""

_READ_LENGTH = 20_000
"""Characters that are read of a text; no message of a model is nearly as long."""

_FAR, _NEAR = 60, 8
"""Characters between a denial and what it denies: at most, and where it stands behind the end of a fire."""

_SHARING_WORDS = 3
"""Words of a clause that shares the fate of the one before it."""

_IN_NAMES = LETTERS + "0-9_"
"""Characters that make up names: `fire1` is not found in `fire12`, though the word `fire` is."""

_NAME = "\ue000"
"""What stands in a text for the name of a fire: a character of private use."""

_DENYING_BEHIND = ("German", "Dutch", "Russian", "Polish")
"""Languages whose denials may stand behind what they deny."""


def _either(spaced: str, unspaced: str = "") -> str:
    guarded = f"|(?=[\u2e80-\uffff])(?:{unspaced})" if unspaced else ""
    return whole_words(spaced) + guarded


def _all(spaced: dict[str, str], unspaced: dict[str, str] | None = None) -> str:
    return _either("|".join(spaced.values()), "|".join((unspaced or {}).values()))


_FIRE = f"{_NAME}|{_all(words.FIRE, words.FIRE_UNSPACED)}"
_DENIED_BEHIND = "|".join(words.NOT[language] for language in _DENYING_BEHIND)
_KINDS = (
    ("sense", _all(words.OTHER_SENSE, words.OTHER_SENSE_UNSPACED)),
    ("forbidden", _all(words.FORBIDDEN, words.FORBIDDEN_UNSPACED)),
    ("over", _all(words.OVER, words.OVER_UNSPACED)),
    ("until", _all(words.UNTIL, words.UNTIL_UNSPACED)),
    ("aside", _all(words.PAST, words.PAST_UNSPACED | words.SUPPOSED_UNSPACED)),
    ("supposed", _all(words.SUPPOSED)),
    ("fire", _FIRE),
    ("denied", _either(_DENIED_BEHIND, "|".join(words.NOT_UNSPACED.values()))),
    ("not", _all(words.NOT)),
    ("go", _all(words.GO)),
)
_CUES = re.compile("|".join(f"(?P<{kind}>{pattern})" for kind, pattern in _KINDS))
_MENTION = re.compile(_FIRE)
_COORDINATES = re.compile(r"\([-+\d\s,.xy=:]{1,24}\)")
_TOPIC = re.compile("(?<=[はもを])、")
_TIME = re.compile(f"({_all(words.PAST, words.PAST_UNSPACED)})[,、]")
_SENTENCES = re.compile(r"(?<=[!?。])|(?<=\.)(?=\s|$)|\n|;|¿|¡")
_CLAUSES = re.compile(f"[,:、]|{whole_words(words.LINKS)}|{words.LINKS_UNSPACED}")
_STATED = re.compile(f"{whole_words(words.STATED)}|[{_NAME}\u2e80-\ud7ff]")
_ASKED = re.compile(words.ASKED_UNSPACED)


@dataclass(frozen=True)
class _Clause:
    """What a clause says: that there is a fire, that it is no mention of one to count, or that it is over."""

    mentions: bool
    taken_back: bool
    over: bool
    words: int


@dataclass(frozen=True)
class _Cue:
    kind: str
    start: int
    end: int


def is_warning(text: str, fires: Iterable[str] = ()) -> bool:
    """Return whether a message is a warning.

    Args:
        text: the message.
        fires: names of the world's fires.
    """
    return (_kept if len(text) <= _CACHED_LENGTH else _warns)(text[:_READ_LENGTH], tuple(fires))


def _warns(text: str, fires: tuple[str, ...]) -> bool:
    named = plain(text).replace(_NAME, " ").replace("\u2019", "'")
    if fires:
        named = _names(fires).sub(_NAME, named)
    if not _MENTION.search(named):
        return False
    warned: int | None = None
    joined = _TIME.sub(r"\1 ", _TOPIC.sub("", _COORDINATES.sub(" ", named)))
    sentences = _SENTENCES.split(joined)
    for number, sentence in enumerate(one for one in sentences if one.strip()):
        if warned is not None and number > warned + 1:
            return True
        warned = _after(sentence, number, warned)
    return warned is not None


_kept = lru_cache(maxsize=4096)(_warns)


def _after(sentence: str, number: int, warned: int | None) -> int | None:
    """Return the number of the sentence that warned last, this one included, or None if what it said is taken back."""
    taken_back = False
    for clause in _statements(sentence):
        read = _read(clause)
        if read.over:
            warned = None
        if read.mentions:
            taken_back = read.taken_back or (taken_back and read.words <= _SHARING_WORDS)
            warned = warned if taken_back else number
    return warned


def _statements(sentence: str) -> Iterator[str]:
    """Yield the clauses of a sentence that are no questions."""
    clauses = [one.strip(" \"'*.!。") for one in _CLAUSES.split(sentence)]
    clauses = [one for one in clauses if one]
    if not sentence.rstrip(" \"'*").endswith("?"):
        yield from (one for one in clauses if not _ASKED.search(one))
        return
    for clause in clauses[:-1]:
        if not _STATED.match(clause) or _ASKED.search(clause):
            return
        yield clause


def _read(clause: str) -> _Clause:
    cues = _effective([_Cue(str(one.lastgroup), one.start(), one.end()) for one in _CUES.finditer(clause)])
    kinds = {cue.kind for cue in cues}
    over = "over" in kinds
    taken_back = over or "aside" in kinds or _is_denied(cues)
    return _Clause("fire" in kinds, taken_back, over, len(clause.split()))


def _effective(cues: list[_Cue]) -> list[_Cue]:
    """Return the cues without denials of going there or of the end, and without ends that are still to come."""
    left: list[_Cue] = []
    awaited = False
    for cue in (one for one in cues if one.kind not in ("sense", "forbidden")):
        before = left[-1] if left else None
        denies = before is not None and before.kind in ("not", "denied") and cue.start - before.end <= _FAR
        awaited = awaited or cue.kind == "until"
        if cue.kind in ("go", "over") and denies:
            left[-1] = _Cue("open", cue.start, cue.end)
        elif cue.kind == "over" and awaited:
            left.append(_Cue("open", cue.start, cue.end))
        elif cue.kind == "denied" and before is not None and _is_open(before, cue):
            left[-1] = _Cue("open", cue.start, cue.end)
        elif cue.kind != "go":
            left.append(cue)
    return left


def _is_open(end: _Cue, denial: _Cue) -> bool:
    """Return whether an end is denied by what stands behind it."""
    return end.kind in ("over", "open") and denial.start - end.end <= _NEAR


def _is_denied(cues: list[_Cue]) -> bool:
    """Return whether every mention of a fire is denied or supposed."""
    denials = [cue for cue in cues if cue.kind in ("not", "denied", "supposed")]
    fires = [cue for cue in cues if cue.kind == "fire"]
    if not denials or not fires:
        return False
    first = fires[0]
    before = any(cue.kind == "supposed" or first.start - cue.end <= _FAR for cue in denials if cue.end <= first.start)
    behind = any(0 <= cue.start - fires[-1].end <= _FAR for cue in denials if cue.kind == "denied")
    return before or behind


@lru_cache(maxsize=64)
def _names(fires: tuple[str, ...]) -> re.Pattern[str]:
    """Return the pattern of the names of fires, the longest first."""
    return re.compile("|".join(_bounded(plain(name)) for name in sorted(fires, key=len, reverse=True)))


def _bounded(name: str) -> str:
    """Return the pattern of a name, held to whole words where the name begins or ends with a letter."""
    before = f"(?<![{_IN_NAMES}])" if re.match(f"[{_IN_NAMES}]", name) else ""
    after = f"(?![{_IN_NAMES}])" if re.search(f"[{_IN_NAMES}]$", name) else ""
    return before + re.escape(name) + after
