"""A rule that finds claims to see the target in a reply by their words; it is the same for every model.

The text is split into sentences, and each sentence into clauses, at commas and conjunctions. Cues are words such as
"see" or "not", from `sight_words`. The cues in the clause that mentions the target decide whether it is a claim to see
the target:

1. If the last cue before the mention, or the first cue behind the mention, is a denial or a doubt, there is no claim.
2. If the clause says behind the mention where the target is ("is on the left", "is in view"), the clause is a claim.
   Another cue of seeing behind the mention also makes a claim, unless a cue of searching comes before the mention.
3. If the last cue before the mention is a cue of seeing, the clause is a claim ("I see a hatch and the JAXA logo"). A
   cue of searching or going makes no claim ("looking for", "towards"). A cue of seeing makes no claim if a denial,
   doubt or search stands at most two words before it ("do not yet see", "if I see", "to see").
4. In a list, the cue of an earlier clause decides ("I see a hatch, a rack and the JAXA logo"). A clause continues a
   list if it has no cue, at most three words before the mention, and no word behind it.

A reply claims to see the target if at least one of its clauses does. A question, or a thought between `<think>` tags,
is never a claim. "I know where the JAXA logo is" claims to know the place of the target, not to see the target.

A mention is the whole name of the target, also in another order ("the logo of JAXA"). In the name `JAXA logo`, "logo"
may be replaced by a synonym ("JAXA emblem"), and "JAXA" may be at most 14 characters away from it. The last word of the
name after an article ("the logo"), or "the target", is also a mention. If the name ends in a number, as in `picture 3`,
this number must follow the word and must not have a unit: "picture 3", not "picture 3 m away". The rule looks only for
words, so it can misread a reply.
"""

import re
from collections.abc import Iterable
from functools import lru_cache
from itertools import accumulate

from analysis.camera import sight_words as words
from analysis.labelling.language import is_read
from analysis.words import LETTERS, plain, whole_words
from foundry.labels.definition import NO, YES, Context

_NEAR_WORDS, _NEAR_CHARACTERS = 2, 20
""""Not" and similar cues cancel a cue of seeing after at most this number of words and of characters."""

_LEADING_WORDS = 3
"""In a list ("I see a hatch, a rack and the logo"), at most this number of words precedes the mention in its clause."""

_THINKING = re.compile(r"<think>.*?(?:</think>|$)", re.DOTALL)
_SENTENCES = re.compile(r"(?<=[!?。！？])|(?<=\.)(?=\s|$)|\n|;")
_TOPIC = re.compile(r"(?<=[はがをも])、\s*")
_RELATIVE = re.compile(r",\s*(?=(?:which|that|who)\b)")
_CONJUNCTIONS = whole_words("and|but|so(?! that)|because|since|while|although|though|however|as|then")
_CLAUSES = re.compile(rf",|，|(?<=[ぁ-ん])、|(?<=[すんいるた])(?:が|けれども?|けど|ので|ため)|{_CONJUNCTIONS}")


def _either_language(english: str, japanese: str) -> str:
    return f"{japanese}|{whole_words(english)}"


_CUES = re.compile(
    "|".join(
        f"(?P<{kind}>{pattern})"
        for kind, pattern in (
            ("unsure", _either_language(words.UNSURE, words.UNSURE_JAPANESE)),
            ("denied", _either_language(words.NOT, words.NOT_JAPANESE)),
            ("placed", whole_words(words.PLACED)),
            ("seen", _either_language(words.SEEN, words.SEEN_JAPANESE)),
            ("searched", _either_language(words.SEARCHED, words.SEARCHED_JAPANESE)),
            ("headed", _either_language(words.HEADED_FOR, words.HEADED_FOR_JAPANESE)),
        )
    )
)
_NO = ("unsure", "denied")
_YES = ("seen", "placed")
_PREPOSITIONS = re.compile(r"\b(?:to|of|in|on|for|with|at|near|by|from)\b")
_NUMBER_WORD = r"[\s#\-_]*(?:(?:number|no|nr|num|n°|№|番号)\.?[\s#]*)?"
_UNIT = r"(?!\d|\.\d|\s*(?:m|cm|mm|km|met[a-z]+|deg[a-z]*|steps?|%|°|メートル|度)(?![a-z]))"
_GAP = r"[^,;:.!?。、，\n]{0,14}?"


@lru_cache(maxsize=4096)
def is_readable(reply: str) -> bool:
    """Return whether a reply is in English or Japanese, the languages that the rule can read."""
    return is_read(_answer_text(reply))


def claims_to_see(reply: str, target: str) -> bool | None:
    """Return whether a reply claims to see the target; None if the rule cannot read its language."""
    if not is_readable(reply):
        return None
    mention = _mention(plain(target))
    return any(_sentence_claims(sentence, mention) for sentence in _statements(reply))


def sight_label(text: str, context: Context) -> str | None:
    """Return the label `sight_claim` that the rule gives a reply; None if the rule cannot read its language."""
    claims = claims_to_see(text, str(context.get("target", "")))
    return None if claims is None else (YES if claims else NO)


def mentions_target(text: str, context: Context) -> bool:
    """Return whether a reply mentions the target, with or without a claim."""
    mention = _mention(plain(str(context.get("target", ""))))
    return any(mention.search(sentence) for sentence in _statements(text))


def things_claimed(reply: str, things: Iterable[str]) -> set[str]:
    """Return the things that a reply claims to see; the reply must be in English or Japanese.

    Rule 4 applies anywhere in a clause without a cue, as in "I see a wall and a door on the left".
    """
    statements = _statements(reply)
    return {
        thing
        for thing in things
        if any(_sentence_claims(statement, _thing(thing), widely=True) for statement in statements)
    }


@lru_cache(maxsize=1024)
def thing_of(label: str) -> str:
    """Return the kind of thing that a label names: `exit door` is a door, `rack JPM1A1` a rack.

    If the last words are a name or a synonym in `sight_words.THINGS`, the kind is the key there; else it is the last
    word. Words after a preposition and words with digits are ignored, since they name one thing of its kind.
    """
    named = _PREPOSITIONS.split(plain(label))[0]
    parts = [part for part in re.findall(r"[^\W_]+", named) if not re.search(r"\d", part)]
    ends = [" ".join(parts[start:]) for start in range(len(parts))]
    known = [end for end in ends if end in words.THINGS]
    called = [thing for end in ends for thing, names in words.THINGS.items() if re.fullmatch(names, end)]
    return next(iter([*known, *called, *ends[-1:], plain(label)]))


def _answer_text(reply: str) -> str:
    return _THINKING.sub(" ", plain(reply)).replace("\u2019", "'")


def _statements(reply: str) -> list[str]:
    text = _TOPIC.sub("", _RELATIVE.sub(" ", _answer_text(reply)))
    return [sentence for sentence in _SENTENCES.split(text) if not sentence.rstrip(" \"'*").endswith(("?", "？"))]


def _sentence_claims(sentence: str, mention: re.Pattern[str], *, widely: bool = False) -> bool:
    if not mention.search(sentence):
        return False
    inherited = ""
    for clause in _clauses(sentence):
        if _clause_claims(mention.split(clause), inherited, widely):
            return True
        inherited = _last_cue(clause) or inherited
    return False


@lru_cache(maxsize=1024)
def _clauses(sentence: str) -> tuple[str, ...]:
    return tuple(_CLAUSES.split(sentence))


def _clause_claims(parts: list[str], inherited: str, widely: bool) -> bool:
    """Return whether a clause claims to see the thing that the clause mentions.

    Args:
        parts: the texts before, between and behind the mentions.
        inherited: kind of the last cue in the clauses before.
        widely: whether `inherited` applies to a clause without a cue, wherever the mention stands in it.
    """
    before = list(accumulate(map(_last_cue, parts[:-1]), _latest))
    after = list(accumulate(map(_first_cue, parts[:0:-1]), _latest))[::-1]
    if any(_claimed(*cues) for cues in zip(before, after, strict=True)):
        return True
    if widely:
        return len(parts) > 1 and not any(before) and not any(after) and inherited in _YES
    listed = len(parts) == 2 and not parts[1].strip(" .\"'*)") and len(parts[0].split()) <= _LEADING_WORDS
    return listed and not before[0] and inherited in _YES


def _latest(cue: str, following: str) -> str:
    return following or cue


def _claimed(before: str, after: str) -> bool:
    """Return whether a mention is a claim, from the kinds of the cues before and behind it; "" stands for no cue."""
    if before in _NO or after in _NO or (before == "searched" and after != "placed"):
        return False
    return (after or before) in _YES


def _first_cue(text: str) -> str:
    cue = _CUES.search(text)
    return str(cue.lastgroup) if cue else ""


@lru_cache(maxsize=1024)
def _last_cue(text: str) -> str:
    """Return the kind of the last cue, or ""; for a cancelled cue of seeing, it is the kind of the cue that cancels."""
    kind, end = "", 0
    for cue in _CUES.finditer(text):
        gap = text[end : cue.start()]
        near = len(gap.split()) <= _NEAR_WORDS and len(gap) <= _NEAR_CHARACTERS
        taken_back = kind and kind not in (*_YES, "headed") and near
        kind, end = (kind if taken_back and cue.lastgroup in _YES else str(cue.lastgroup)), cue.end()
    return kind


@lru_cache(maxsize=256)
def _thing(name: str) -> re.Pattern[str]:
    return re.compile(_either(words.THINGS.get(name, f"{re.escape(name)}s?")))


@lru_cache(maxsize=64)
def _mention(target: str) -> re.Pattern[str]:
    parts = re.findall(r"[^\W_]+", target)
    if not parts:
        return re.compile(_either(words.THE_TARGET))
    number = parts.pop() if len(parts) > 1 and parts[-1].isdigit() else ""
    start = next((i for i in range(len(parts)) if " ".join(parts[i:]) in words.THINGS), max(len(parts) - 1, 0))
    last = " ".join(parts[start:])
    noun = _either(words.THINGS.get(last, f"{re.escape(last)}s?"))
    if number:
        return re.compile(rf"{noun}{_NUMBER_WORD}0*{number}{_UNIT}|(?<!\d)0*{number}\s*[番号](?:目)?の?\s*{noun}")
    if not start:
        return re.compile(f"{noun}|{_either(words.THE_TARGET)}")
    others = _GAP.join(_either(re.escape(part)) for part in parts[:start])
    alone = rf"{whole_words(words.ARTICLES)}\s+{noun}|(?<![の{LETTERS}ァ-ヶー一-龥])(?=[ァ-ヶー一-龥]){noun}"
    return re.compile(f"{others}{_GAP}{noun}|{noun}{_GAP}{others}|{alone}|{_either(words.THE_TARGET)}")


def _either(alternatives: str) -> str:
    """Return a pattern that matches any of the alternatives; an alternative in Latin letters must be a whole word."""
    return (
        f"(?:(?<![{LETTERS}])(?=[{LETTERS}0-9])(?:{alternatives})(?![{LETTERS}])|(?![{LETTERS}0-9])(?:{alternatives}))"
    )
