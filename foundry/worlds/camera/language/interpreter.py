"""Reads the motions that a reply in plain language asks for, and never invents a motion.

Translation, turn of the body and turn of the gaze are read separately. If the text names a kind of motion several
times, the last mention counts. "stay" cancels the motions of earlier sentences. A direction counts only with a verb of
motion, after another command, or in a sentence without other content. Negated, possible or conditional motions are not
carried out, nor are motions in questions, examples, quotations and lists of options. Reported motions of earlier steps
or of other agents, purposes, and postponed motions are not carried out either (see `language.telling`).

A missing amount gets the configured default, and an amount above a limit is clamped; `Command.notes` then has a note.

A reply that is a JSON object is read as JSON. The requested keys are `direction` (a direction such as "forward-left",
or null), `distance` (metres), `turn` (degrees to the left) and `gaze` (degrees upwards). A missing key, null and 0 mean
no motion, and a command without any motion is "stay". foundry ignores other keys, except a key that names the action.
An object that names an action, such as {"action": "turn", "direction": "left", "angle": 45}, is read as a sentence made
of its values.

The outcome is `chosen` if the reply contains a command. The outcome is `repaired` if the command is JSON in a part of
the reply, or plain language although JSON is requested. If the reply contains no command, the outcome is `unreadable`,
and nothing moves.

Reading takes time proportional to the length of the reply.
"""

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from foundry.errors import InputError
from foundry.records import Outcome
from foundry.worlds.camera.language import BEARINGS, Command, Limits, Translation, command_record, limited
from foundry.worlds.camera.language.asking import resolve
from foundry.worlds.camera.language.lexicon import ENGLISH, Kind
from foundry.worlds.camera.language.sentences import LARGEST, LETTER, last_sentence
from foundry.worlds.replies import Conflicting, find_objects, whole_object, without_thinking

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
"""The word that introduces a quotation must be among this number of characters before the quotation."""

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
    """Return a quotation, or a blank if the quotation repeats words or an action of an earlier step."""
    text, start, end = quoted.string, quoted.start(), quoted.end()
    line_starts = not text[max(0, start - _REACH) : start].strip()
    follows = _AFTER.match(text, end)
    if _BEFORE.search(text, max(0, start - _REACH), start) or (follows and not (line_starts and ">" in follows[0])):
        return " "
    return quoted[0]


def _without_lists(text: str) -> str:
    """Return the text without the lines of lists below a heading such as "Options:"."""
    lines: list[str] = []
    listing = False
    for line in text.split("\n"):
        listing = (listing and (not line.strip() or bool(_ITEM.match(line)))) or _is_heading(line)
        if not listing or not _ITEM.match(line):
            lines.append(line)
    return "\n".join(lines)


def _is_heading(line: str) -> bool:
    bare = line.strip(" *#_`")
    return len(line) <= _LONGEST_HEADING and bare.endswith((":", "：")) and bool(_HEADING.search(bare))


_FULL_WIDTH = {0xFEE0 + code: code for code in range(0x21, 0x7F)}
_FRACTIONS = {"½": " 1/2", "⅓": " 1/3", "⅔": " 2/3", "¼": " 1/4", "¾": " 3/4", "⅛": " 1/8"}
_PLAIN = str.maketrans(
    {**{chr(wide): chr(code) for wide, code in _FULL_WIDTH.items()}, **_FRACTIONS}
    | dict.fromkeys("’‘ʼ", "'")
    | dict.fromkeys("–—−", "-")
    | dict.fromkeys("º˚", "°")
    | dict.fromkeys("\t\r\v\f\u00a0\u2009\u202f\u3000\u200b\ufeff", " ")
    | {"～": "~", "〜": "~", "⁄": "/", "㍍": "メートル", "…": ".", "。": "。"}
)
_MARKS = str.maketrans(dict.fromkeys('*_`#>"“”„«»「」『』$\\~', " ") | {"|": ","})
_LATEX = re.compile(r"\^?\{?\\(?:circ|degree)\}?")
_LATEX_COMMAND = re.compile(r"\\[a-z]{1,20}")
_TAG = re.compile(r"</?[a-zA-Z][^<>\n]{0,40}>")
_CAMEL = re.compile(r"[A-Z](?<=[a-z].)(?=[a-z])")
_ABBREVIATION = re.compile(
    r"\.(?:(?:(?<=\bdeg.)|(?<=\bft.)|(?<=\bin.)|(?<=\byd.))(?= [a-z])|(?<=\bapprox.)|(?<=\bca.))", re.IGNORECASE
)
_TILDE_RANGE = re.compile(r"~(?:(?<=\d.)|(?<=\d .))")
_SPACED_RANGE = re.compile(r" -(?<=\d..) ?(?=\d)")
_RANGE = re.compile(r"-(?<=\d.) (?=\d)")
_HYPHEN = re.compile(rf"-(?<=\w.)(?={LETTER})")
_WRAPPED = re.compile(r"\n(?:(?<=,\n)|(?<=[^\n]{60}[a-z]\n)(?=[a-z]))")
_ABOUT = r"(?:by|for|about|around|approximately|roughly)"
_NUMBER_WORDS = "|".join(name for name, word in ENGLISH.items() if word.kind is Kind.NUMBER)
_UNIT = r"(?:m|meters?|metres?|cm|steps?|°|deg|degrees?)"
_AMOUNT_LINE = re.compile(
    rf"(?<=\S)[ \n]{{0,4}}\n *(?=(?:(?:{_ABOUT} ){{1,3}}(?:\d[\d.,/]*|[a-z]{{3,9}})[ °]?[a-z]{{0,12}}"
    rf"|(?:\d[\d.,/]*|{_NUMBER_WORDS}) ?{_UNIT}) *(?:[.,;!\n]|\Z))",
    re.IGNORECASE,
)
_DIRECTION_KEY = re.compile(
    rf"((?:distance|angle) ?[:=] ?\d[\d.]* ?{_UNIT})[,;\n][ \n-]{{0,8}}direction ?[:=] ?", re.IGNORECASE
)
_AMOUNT_KEY = re.compile(
    rf"[,;\n][ \n-]{{0,8}}(?:distance|angle|degrees|amount|magnitude|value) ?[:=] ?(?=(?:{_ABOUT} )?[-+.]?\d)",
    re.IGNORECASE,
)
_AROUND = re.compile(rf"\b(right|go|move) around (?=\d|(?:{_NUMBER_WORDS})\b)", re.IGNORECASE)
_LABEL_LINE = re.compile(r"\b((?:movement|move|action|decision|command|answer) ?:)[ \n]{0,4}\n *", re.IGNORECASE)


def cleaned(text: str) -> str:
    """Return the text in lower case, without markdown, tags, LaTeX, quotations, lists of options and wrapped lines."""
    text = without_quotations(text.translate(_PLAIN))
    if "\\" in text:
        text = _LATEX_COMMAND.sub(" ", _LATEX.sub("°", text))
    if "<" in text:
        text = _TAG.sub("\n", text)
    text = _CAMEL.sub(r" \g<0>", text)
    text = _ABBREVIATION.sub(" ", text.replace("e.g.", "eg ").replace("E.g.", "eg ").replace("i.e.", ", "))
    text = _HYPHEN.sub(" ", _RANGE.sub("-", _SPACED_RANGE.sub("-", _TILDE_RANGE.sub("-", text))))
    text = text.translate(_MARKS)
    while "  " in text:
        text = text.replace("  ", " ")
    if "\n" in text or ":" in text:
        text = _DIRECTION_KEY.sub(r"\1 ", _AMOUNT_KEY.sub(" ", _AMOUNT_LINE.sub(" ", text)))
        text = _LABEL_LINE.sub(r"\1 ", text)
    return _WRAPPED.sub(" ", _AROUND.sub(r"\1 about ", text).replace(" \n", "\n")).lower()


_ACTIONS = re.compile(
    r"action|command|movement|motion|move|type|verb|turn|rotat|look|gaze|stay|"
    r"行動|行动|動作|动作|移動|移动|指令|命令|コマンド|アクション"
)
_DIRECTIONS = re.compile(r"direction|side|^dir$|方向|向き")
_DISTANCES = re.compile(r"distan|^m$|met(?:er|re)s?|^length|距離|距离|メートル|米")
_ANGLES = re.compile(r"angle|degree|^deg$|角度|度")
_AMOUNTS = re.compile(r"^(?:amount|value|magnitude|quantity|by|parameters?|params|args|arguments)$|量|値|值")
_UNITS = re.compile(r"^units?$|単位|单位")
_ELSEWHERE = re.compile(
    r"prev|last|past|history|earlier|result|reason|thought|observ|explan|descri|analysis|goal|task|plan|later|after|"
    r"前回|履歴|理由|上一|原因"
)
_BARE_WAYS = frozenset(("左", "右", "前", "後ろ", "上", "下"))
_DEEPEST = 3
_ACTION, _DIRECTION, _AMOUNT = range(3)
"""The order of the words in a sentence that is made of a JSON object."""


def worded_command(fields: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    """Return the command of a JSON object that names its action; the object is read like a sentence. Else None."""
    if not any(_names(key.lower()) for key in fields):
        return None
    words = [*_words(fields, 0)]
    command = resolve(cleaned(" ".join(words)), limits)
    if command.outcome is Outcome.UNREADABLE:  # in Japanese the action comes last
        command = resolve(cleaned(" ".join(reversed(words))), limits)
    if command.outcome is Outcome.UNREADABLE:
        return None
    worst = Outcome.REPAIRED if Outcome.REPAIRED in (command.outcome, outcome) else outcome
    return replace(command, outcome=worst, notes=("read as JSON", *command.notes))


def _names(key: str) -> bool:
    return bool(_ACTIONS.search(key)) and not _ELSEWHERE.search(key)


def _words(fields: dict[str, Any], depth: int) -> Iterator[str]:
    """Yield the words for a motion in a JSON object: its action, its direction and its amount."""
    unit = next((str(value) for key, value in fields.items() if _UNITS.search(key.lower())), "")
    said = [part for key, value in fields.items() for part in _said(key.lower(), value, unit, depth)]
    yield from (text for _, text in sorted(said, key=lambda part: part[0]) if text)


def _said(key: str, value: Any, unit: str, depth: int) -> Iterator[tuple[int, str]]:
    """Yield the words for one key of a JSON object, each with the number of its place in the sentence."""
    if _ELSEWHERE.search(key) or _UNITS.search(key):
        return
    if isinstance(value, dict | list):
        yield from _nested(key, value, unit, depth)
        return
    number = _number(value)
    measured = _measured(key, unit)
    if measured is not None:
        yield _AMOUNT, f"{number} {measured}" if number else value if isinstance(value, str) else ""
    elif isinstance(value, str) and _DIRECTIONS.search(key):
        yield _DIRECTION, f"{value}に" if value in _BARE_WAYS else value
    elif isinstance(value, str) and _ACTIONS.search(key):
        yield _ACTION, value.replace("_", " ")
    elif number and _ACTIONS.search(key):
        yield _ACTION, key
        yield _AMOUNT, f"{number} {'m' if 'move' in key else 'degrees'}"


def _nested(key: str, value: dict[str, Any] | list[Any], unit: str, depth: int) -> Iterator[tuple[int, str]]:
    if depth >= _DEEPEST:
        return
    if isinstance(value, list):
        for item in value:
            yield from _said(key, item, unit, depth + 1)
    else:
        names = _ACTIONS.search(key) and not _AMOUNTS.search(key)
        yield _ACTION, " ".join((key if names else "", *_words(value, depth + 1)))


def _measured(key: str, unit: str) -> str | None:
    """Return the unit of the number under a JSON key ("degrees" for "angle"); None if the key names no amount."""
    if _ANGLES.search(key):
        return "degrees"
    if _DISTANCES.search(key):
        return "m"
    return unit if _AMOUNTS.search(key) else None


def _number(value: Any) -> str:
    return f"{value:f}" if type(value) in (int, float) and value and abs(value) <= LARGEST else ""


_KEYS = frozenset(("direction", "distance", "turn", "gaze"))
_BEARINGS = {
    "-".join(sorted((way.value for way in ways), reverse=reverse)): bearing
    for ways, bearing in BEARINGS.items()
    for reverse in (False, True)
}
_NONE = frozenset(("", "none", "stay", "null"))
_FENCE = re.compile(r"\A\s*```\w*|```\s*\Z")


def whole_command(reply: str, limits: Limits) -> Command | None:
    """Return the command of a reply that is one JSON object, apart from thinking and code fences, or None."""
    fields = whole_object(reply)
    if fields is not None:
        return _command(fields, limits, Outcome.CHOSEN)
    fields = whole_object(_FENCE.sub("", without_thinking(reply)))
    return None if fields is None else _command(fields, limits, Outcome.REPAIRED)


def embedded_command(reply: str, limits: Limits) -> Command | None:
    """Return the command of the last JSON object in a reply that is a command, or None."""
    objects = reversed(find_objects(without_thinking(reply)))
    commands = (_command(fields, limits, Outcome.REPAIRED) for fields in objects)
    return next((command for command in commands if command is not None), None)


def _command(fields: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    if isinstance(fields, Conflicting):
        return None
    in_numbers = any(type(fields.get(key)) in (int, float) and fields[key] != 0 for key in ("turn", "gaze"))
    is_nested = any(isinstance(value, dict) for value in fields.values())
    if in_numbers or not (fields.keys() - _KEYS or is_nested):
        return _numbers(fields, limits, outcome)
    worded = worded_command(fields, limits, outcome)
    names_action = any(isinstance(fields.get(key), str) for key in ("action", "command", "type"))
    if worded is not None or (names_action and "distance" not in fields):
        return worded
    return _numbers(fields, limits, outcome)


def _numbers(fields: dict[str, Any], limits: Limits, outcome: Outcome) -> Command | None:
    """Return the command of a JSON object with the keys that the prompt requests, or None."""
    if not fields.keys() & _KEYS or not _is_sound(fields):
        return None
    notes: list[str] = []
    translate = None
    bearing = _BEARINGS.get(_direction(fields))
    if bearing is not None and fields.get("distance") != 0:
        asked = fields.get("distance")
        if asked is None:
            notes.append(f"translate: no amount named, {limits.default_distance_m:g} m by default")
            asked = limits.default_distance_m
        translate = Translation(bearing, limited("translate", asked, limits.max_distance_m, "m", notes))
    turn = limited("turn", fields.get("turn") or 0.0, limits.max_turn_deg, "degrees", notes) or None
    gaze = limited("gaze", fields.get("gaze") or 0.0, limits.max_gaze_deg, "degrees", notes) or None
    stay = translate is None and turn is None and gaze is None
    return Command(translate, turn, gaze, stay, outcome, ("read as JSON", *notes))


def _is_sound(fields: dict[str, Any]) -> bool:
    """Return whether all values have the right types, and a direction is given if the distance is above 0."""
    numbers = [fields.get(key) for key in ("distance", "turn", "gaze")]
    if not all(value is None or (type(value) in (int, float) and abs(value) <= LARGEST) for value in numbers):
        return False
    direction = _direction(fields)
    if direction in _NONE:
        return not fields.get("distance")
    return direction in _BEARINGS and (fields.get("distance") or 0) >= 0


def _direction(fields: dict[str, Any]) -> str:
    value = fields.get("direction")
    if value is None:
        return ""
    words = re.findall(r"[a-z]+", value.lower()) if isinstance(value, str) else ["?"]
    return "-".join(words) if len(words) < 3 else "?"


SHIPPED_LIMITS = Limits(max_distance_m=3.0, max_turn_deg=180.0, max_gaze_deg=60.0)
"""The largest motions in one step, with the values of `conf/world/usd.yaml`."""


class Interpreter(ABC):
    """Converts replies to commands; the same reply always gives the same command."""

    @abstractmethod
    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in a reply; without limits, amounts have the defaults of `Limits` and are not clamped."""


class LatestInterpreter(Interpreter):
    """Reads the whole reply; if it names a kind of motion several times, the last mention counts."""

    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in a reply."""
        return interpret(reply, limits)


class LastSentenceInterpreter(Interpreter):
    """Reads only the last sentence."""

    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in the last sentence of a reply."""
        limits = limits or Limits()
        return whole_command(reply, limits) or resolve(last_sentence(cleaned(without_thinking(reply))), limits)


class JsonInterpreter(Interpreter):
    """Reads the JSON command that the prompt `json` requests; a command in plain language counts as `repaired`."""

    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in a reply."""
        limits = limits or Limits()
        command = whole_command(reply, limits) or embedded_command(reply, limits)
        if command is not None:
            return command
        command = interpret(reply, limits)
        if command.outcome is not Outcome.CHOSEN:
            return command
        return replace(command, outcome=Outcome.REPAIRED, notes=("no JSON command: read as text", *command.notes))


def interpret(reply: str, limits: Limits | None = None) -> Command:
    """Return the command in a reply, which may be any text; without limits, no amount is clamped."""
    limits = limits or Limits()
    return whole_command(reply, limits) or resolve(cleaned(without_thinking(reply)), limits)


def read_replies(lines: Iterable[str], *, limited: bool) -> Iterator[str]:
    """Yield, for each line with a reply, the command in it as the text of a JSON object.

    Args:
        lines: the replies, each as a JSON string.
        limited: whether amounts are clamped to the limits of the shipped worlds.

    Raises:
        InputError: a line is not a JSON string.
    """
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            reply = json.loads(line)
        except ValueError:
            reply = None
        if not isinstance(reply, str):
            raise InputError(f'Line {number} is not a JSON string: write "..." with quotes, one reply per line.')
        command = interpret(reply, SHIPPED_LIMITS if limited else None)
        said = {**command_record(command), "outcome": command.outcome, "notes": list(command.notes)}
        yield json.dumps(said, ensure_ascii=False)
