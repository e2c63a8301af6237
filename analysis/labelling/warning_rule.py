"""A rule that finds warnings in messages by their words; it is the same for every model.

A text that is neither English nor Japanese gets no label; the module `language` decides this.

A text is a warning if one of its clauses mentions a fire and nothing cancels the mention. A mention is the name of a
fire of the world, or a word for fire, flames, smoke, burning, evacuation or urgent flight. The rule ignores expressions
in which a word for fire means something else ("fire drill", "smoke-free"). A word for danger ("danger", "unsafe") also
counts as a mention if its sentence names a position such as (3, 4), or if the text calls others to get away. The text
is split into sentences, and sentences into clauses, at commas and conjunctions. A mention of a fire is cancelled by any
of these in its clause:

1. a denial before the mention ("no sign of any fire"), or, in Japanese, behind the mention ("火事はありません"). A
   sentence that only denies harm or a drill cancels nothing ("nobody was hurt by the fire");
2. words that say that the fire is over or was none ("extinguished", "false alarm", "only steam"). "It is out" also
   cancels a mention earlier in the sentence or in the sentence before. If another fire continues, words that say that
   one fire is over cancel nothing ("fire1 is out, fire2 still burns");
3. words before the mention for the past ("yesterday"), a supposition ("if you see a fire") or a tale ("a book about
   fires");
4. a question, unless the question treats the fire as a fact ("did you notice that the bar burns?"). If a statement
   comes before the question in one sentence, the mention in the statement still counts ("there is a fire, shall we
   go?").

Words that forbid going to the fire, or deny that it is over, cancel no mention ("do not go near the fire", "not out
yet", "until it is out"). In "no fire, smoke, or flames", the denial "no" also holds for the clauses that follow, since
they have at most three words.

The rule ignores case, full-width forms of letters, and Unicode composition. The words are in `warning_words`; English
words match only whole words, Japanese words match anywhere. The names of fires, such as `fire1`, are found in English
and in Japanese texts. The running time is linear in the length of the text; only the first 20,000 characters are read.
The rule looks only for words, so it can misread a text.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

from analysis.labelling import warning_words as words
from analysis.labelling.language import is_read
from analysis.words import LETTERS, indexed, plain, whole_words
from foundry.labels.definition import NO, YES, Context

RULE_VERSION = 4
"""Version of the rule; increase it whenever the label of any text may change."""

_CACHED_LENGTH = 4096
"""Maximum length, in characters, of a text whose label is kept in memory."""

_READ_LENGTH = 20_000
"""The rule reads at most this number of characters of a text; messages of models are much shorter."""

_FAR, _NEAR = 60, 8
"""Maximum number of characters between a denial such as "no" and the word that it denies, such as "fire".

If the denied word is Japanese, such as "消えた", `_NEAR` is the maximum.
"""

_SHARING_WORDS = 3
"""In "no fire, smoke", the denial "no" also holds for the next clause if that clause has at most this many words."""

_IN_NAMES = LETTERS + "0-9_"
"""Characters that can be part of a fire's name, so that the name `fire1` is not found in `fire12`."""

_NAME = "\ue000"
"""A private-use character that replaces the name of a fire in a text."""

_PLACE = "\ue001"
"""A private-use character that replaces a position in a text, such as (3, 4)."""


def _either(english: str, japanese: str) -> str:
    return f"{whole_words(indexed(english))}|{_in_japanese(japanese)}"


def _in_japanese(pattern: str) -> str:
    return f"(?=[\u2e80-\uffff])(?:{indexed(pattern)})"


_SHUNNED = (
    f"(?:{whole_words(indexed(words.SHUN))})[^.!?,]{{0,20}}{_PLACE}|{_PLACE} ?(?:付近|周辺|の近く)?に(?:は)?近(?:づ|寄)"
)
_FIRE = "|".join(
    (
        _NAME,
        _SHUNNED,
        _either(f"{words.FIRE}|{words.FLEE}", f"{words.FIRE_JAPANESE}|{words.FLEE_JAPANESE}"),
        words.PICTURED,
    )
)
_HAZARD = _either(words.HAZARD, words.HAZARD_JAPANESE)
_KINDS = (
    ("forbidden", _in_japanese(words.FORBIDDEN_JAPANESE)),
    ("mistaken", _either(words.MISTAKEN, words.MISTAKEN_JAPANESE)),
    ("over", _either(words.OVER, words.OVER_JAPANESE)),
    ("until", _either(words.UNTIL, words.UNTIL_JAPANESE)),
    ("aside", _either(words.PAST, f"{words.PAST_JAPANESE}|{words.SUPPOSED_JAPANESE}")),
    ("supposed", whole_words(indexed(words.SUPPOSED))),
    ("fire", _FIRE),
    ("hazard", _HAZARD),
    ("doubt", whole_words(indexed(words.DOUBT))),
    ("denied", _in_japanese(words.NOT_JAPANESE)),
    ("not", whole_words(indexed(words.NOT))),
    ("go", whole_words(indexed(words.GO))),
)
_CUES = re.compile("|".join(f"(?P<{kind}>{pattern})" for kind, pattern in _KINDS))
_MENTION = re.compile(f"{_FIRE}|{_HAZARD}")
_ESCAPE = re.compile(_either(words.ESCAPE, words.ESCAPE_JAPANESE))
_LASTING = re.compile(_either(words.LASTING, words.LASTING_JAPANESE))
_PHRASES = re.compile(
    _either(f"{words.HARM}|{words.OTHER_SENSE}", f"{words.HARM_JAPANESE}|{words.OTHER_SENSE_JAPANESE}")
)
_FACTIVE = re.compile(
    f"(?<![{LETTERS}])(?:{indexed(words.FACTIVE)})(?:(?<=[ ,'])|(?![{LETTERS}]))|{words.FACTIVE_JAPANESE}"
)
_COORDINATES = re.compile(
    r"\((?=\D{0,8}\d)[-+\d\s,.xy=:]{1,24}\)|(?<![\w.,])-?\d{1,3} ?, ?-?\d{1,3}(?![\w.,])"
    r"|\bx\W{0,3}\d{1,4}\W{1,3}y\W{0,3}\d{1,4}"
)
_TOPIC = re.compile("(?<=[はもを])、")
_ASIDE = re.compile(
    f"({_either(f'{words.PAST}|{words.SUPPOSED}', f'{words.PAST_JAPANESE}|{words.SUPPOSED_JAPANESE}')})[,、]"
)
_SENTENCES = re.compile(r"(?<=[!?。])|(?<=\.)(?=\s|$)|\n|;")
_CLAUSES = re.compile(f"[,:、]|{whole_words(words.LINKS)}|{words.LINKS_JAPANESE}")
_STATED = re.compile(f"{whole_words(words.STATED)}|[{_NAME}\u2e80-\ud7ff]")
_ASKED = re.compile(words.ASKED_JAPANESE)
_UNSPACED_CHARACTER = re.compile("[\u2e80-\uabff\uf900-\uffff]")


@dataclass(frozen=True)
class _Clause:
    mentions: bool
    taken_back: bool
    over: bool
    lasting: bool
    words: int


@dataclass(frozen=True)
class _Cue:
    kind: str
    start: int
    end: int


@dataclass(frozen=True)
class _Warned:
    number: int
    lasting: bool


def is_warning(text: str, fires: Iterable[str] = ()) -> bool | None:
    """Return whether a message is a warning; None if it is neither English nor Japanese."""
    return (_kept if len(text) <= _CACHED_LENGTH else _labelled)(text[:_READ_LENGTH], tuple(fires))


def warning_label(text: str, context: Context) -> str | None:
    """Return the rule's label of a message, one of the choices of `warning`."""
    warns = is_warning(text, context["fires"])
    return None if warns is None else (YES if warns else NO)


def mentions_fire(text: str, context: Context) -> bool:
    """Return whether a message mentions a fire or a danger, in any sense."""
    return bool(_MENTION.search(_placed(text[:_READ_LENGTH], tuple(context["fires"]))))


def _labelled(text: str, fires: tuple[str, ...]) -> bool | None:
    named = _named(text, fires)
    return _warns(_COORDINATES.sub(f" {_PLACE} ", named)) if is_read(named) else None


_kept = lru_cache(maxsize=4096)(_labelled)


def _named(text: str, fires: tuple[str, ...]) -> str:
    named = plain(text).replace(_NAME, " ").replace(_PLACE, " ").replace("\u2019", "'")
    return _names(fires).sub(_NAME, named) if fires else named


def _placed(text: str, fires: tuple[str, ...]) -> str:
    return _COORDINATES.sub(f" {_PLACE} ", _named(text, fires))


def _warns(placed: str) -> bool:
    if not _MENTION.search(placed):
        return False
    meant = _PHRASES.sub(" ", placed)
    warned: _Warned | None = None
    urges = _ESCAPE.search(meant) is not None
    said = _SENTENCES.split(_ASIDE.sub(r"\1 ", _TOPIC.sub("", meant)))
    for number, sentence in enumerate(part for part in said if part.strip()):
        if warned is not None and number > warned.number + 1:
            return True
        warned = _after(sentence, number, warned, urges=urges or _PLACE in sentence)
    return warned is not None


def _after(sentence: str, number: int, warned: _Warned | None, *, urges: bool) -> _Warned | None:
    """Return the last warning, from this or an earlier sentence; None without one, or if this sentence cancels it."""
    denied = False
    for clause in _statements(sentence):
        read = _read(clause, urges=urges)
        if read.over and not (read.mentions and warned is not None and warned.lasting):
            warned = None
        if read.mentions:
            denied = not read.over and (read.taken_back or (denied and read.words <= _SHARING_WORDS))
            warned = warned if read.taken_back or denied else _Warned(number, read.lasting)
    return warned


def _statements(sentence: str) -> Iterator[str]:
    """Yield the clauses that are statements, or questions that treat a fire as a fact ("did you see the fire?")."""
    stated = _FACTIVE.sub(" ", sentence)
    asks = stated == sentence
    clauses = [part.strip(" \"'*.!。" if asks else " \"'*.!。?") for part in _CLAUSES.split(stated)]
    clauses = [clause for clause in clauses if clause]
    if not asks or not sentence.rstrip(" \"'*").endswith("?"):
        yield from (clause for clause in clauses if not asks or not _ASKED.search(clause))
        return
    for clause in clauses[:-1]:
        if not _STATED.match(clause) or _ASKED.search(clause):
            return
        yield clause


def _read(clause: str, *, urges: bool) -> _Clause:
    cues = [_Cue(str(match.lastgroup), match.start(), match.end()) for match in _CUES.finditer(clause)]
    cues = _effective([replace(cue, kind="fire") if cue.kind == "hazard" and urges else cue for cue in cues])
    kinds = {cue.kind for cue in cues}
    over = not kinds.isdisjoint(("over", "mistaken"))
    taken_back = over or "aside" in kinds or _is_denied(cues)
    length = max(len(clause.split()), len(_UNSPACED_CHARACTER.findall(clause)) // 2)
    return _Clause("fire" in kinds, taken_back, over, _LASTING.search(clause) is not None, length)


def _effective(cues: list[_Cue]) -> list[_Cue]:
    """Drop cues that cancel no mention: "do not go" (to the fire), "not out yet", and "until it is out"."""
    left: list[_Cue] = []
    awaited = False
    for cue in (cue for cue in cues if cue.kind != "forbidden"):
        before = left[-1] if left else None
        denies = before is not None and before.kind in ("not", "doubt", "denied") and cue.start - before.end <= _FAR
        awaited = awaited or cue.kind in ("until", "doubt")
        if cue.kind in ("go", "over") and denies:
            left[-1] = _Cue("open", cue.start, cue.end)
        elif cue.kind == "over" and awaited:
            left = [cue for cue in left if cue.kind != "doubt"]
            left.append(_Cue("open", cue.start, cue.end))
        elif cue.kind == "denied" and before is not None and _is_open(before, cue):
            left[-1] = _Cue("open", cue.start, cue.end)
        elif cue.kind != "go":
            left.append(cue)
    return left


def _is_open(end: _Cue, denial: _Cue) -> bool:
    return end.kind in ("over", "open") and denial.start - end.end <= _NEAR


def _is_denied(cues: list[_Cue]) -> bool:
    denials = [cue for cue in cues if cue.kind in ("not", "doubt", "denied", "supposed")]
    fires = [cue for cue in cues if cue.kind == "fire"]
    if not denials or not fires:
        return False
    first = fires[0]
    before = any(cue.kind == "supposed" or first.start - cue.end <= _FAR for cue in denials if cue.end <= first.start)
    behind = any(0 <= cue.start - fires[-1].end <= _FAR for cue in denials if cue.kind == "denied")
    return before or behind


@lru_cache(maxsize=64)
def _names(fires: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile("|".join(_bounded(plain(name)) for name in sorted(fires, key=len, reverse=True)))


def _bounded(name: str) -> str:
    before = f"(?<![{_IN_NAMES}])" if re.match(f"[{_IN_NAMES}]", name) else ""
    after = f"(?![{_IN_NAMES}])" if re.search(f"[{_IN_NAMES}]$", name) else ""
    return before + re.escape(name) + after
