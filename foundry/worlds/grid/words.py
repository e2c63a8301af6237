"""Reads labelled lines of a reply, and the meaning of its values; every word but remarks must be known."""

import json
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

from foundry.worlds.replies import merged

KEYS = {
    "action": (
        "action", "actions", "my action", "chosen action", "final action", "next action", "decision", "my decision",
        "final decision", "action type", "actiontype", "aktion", "handlung", "entscheidung", "acción", "accion",
        "décision", "azione", "ação",
        "acao", "actie", "akcja", "действие", "行動", "アクション", "動作", "行动", "动作", "행동", "동작",
    ),
    "direction": (
        "direction", "move direction", "dir", "heading", "richtung", "dirección", "direccion", "direzione",
        "direção", "direcao",
        "richting", "kierunek", "направление", "方向", "방향",
    ),
    "message": (
        "message", "my message", "msg", "nachricht", "botschaft", "mensaje", "messaggio", "mensagem", "bericht",
        "wiadomość", "сообщение", "メッセージ", "伝言", "消息", "信息", "讯息", "메시지",
    ),
    "memory": (
        "memory", "memories", "gedächtnis", "erinnerung", "mémoire", "memoria", "memória", "geheugen", "pamięć",
        "память", "記憶", "メモリ", "メモリー", "メモ", "记忆", "기억",
    ),
    "reasoning": (
        "reasoning", "reason", "explanation", "rationale", "thoughts", "thought", "thinking", "begründung",
        "raisonnement", "raison",
        "razonamiento", "razón", "ragionamento", "motivo", "raciocínio", "redenering", "reden", "uzasadnienie",
        "обоснование", "причина", "理由", "推論", "原因", "推理", "解释", "이유", "추론",
    ),
}  # fmt: skip
"""The names of each key; the first one is the requested name."""

UP, DOWN, LEFT, RIGHT, STAY, MOVE = "up", "down", "left", "right", "stay", "move"

MEANINGS = {
    UP: (
        "up", "upward", "upwards", "upper", "north", "northward", "northwards", "above", "↑", "⬆", "🔼", "👆", "⇧",
        "y+1", "+y", "increase y", "increase the y", "positive y", "y increases", "y increase",
        "oben", "hoch", "aufwärts", "hinauf", "rauf", "norden", "haut", "monter", "nord", "arriba", "norte", "subir",
        "su", "in alto", "l'alto", "cima", "acima", "omhoog", "boven", "noorden", "góra", "górę", "górze",
        "północ", "вверх",
        "наверх", "север", "上", "上方", "上方向", "上側", "北", "向上", "往上", "朝上", "上边", "上面", "위",
        "위로", "위쪽", "북쪽",
    ),
    DOWN: (
        "down", "downward", "downwards", "lower", "south", "southward", "southwards", "below", "↓", "⬇", "🔽",
        "👇", "⇩",
        "y-1", "-y", "decrease y", "decrease the y", "negative y", "y decreases", "y decrease",
        "unten", "abwärts", "runter", "hinunter", "herunter", "süden", "bas", "descendre", "sud", "abajo", "sur",
        "bajar", "giù", "basso", "baixo", "abaixo", "omlaag", "beneden", "onder", "zuiden", "dół", "dole", "południe",
        "вниз", "юг", "下", "下方", "下方向", "下側", "南", "向下", "往下", "朝下", "下边", "下面", "아래",
        "아래로", "아래쪽", "남쪽",
    ),
    LEFT: (
        "left", "leftward", "leftwards", "west", "westward", "westwards", "←", "⬅", "👈", "⇦", "◀",
        "x-1", "-x", "decrease x", "decrease the x", "negative x", "x decreases", "x decrease",
        "links", "westen", "linke", "linken", "gauche", "ouest", "izquierda", "oeste", "sinistra", "ovest",
        "esquerda", "lewo", "lewa",
        "zachód", "влево", "налево", "запад", "左", "左側", "左方", "左方向", "西", "向左", "往左", "朝左", "左边",
        "左面",
        "왼쪽", "왼쪽으로", "좌측", "서쪽",
    ),
    RIGHT: (
        "right", "rightward", "rightwards", "east", "eastward", "eastwards", "→", "➡", "👉", "⇨", "▶",
        "x+1", "+x", "increase x", "increase the x", "positive x", "x increases", "x increase",
        "rechts", "osten", "rechte", "rechten", "droite", "derecha", "este", "destra", "direita", "leste",
        "rechtsaf", "oosten", "prawo",
        "prawa", "wschód", "вправо", "направо", "восток", "右", "右側", "右方", "右方向", "東", "东", "向右",
        "往右", "朝右",
        "右边", "右面", "오른쪽", "오른쪽으로", "우측", "동쪽",
    ),
    STAY: (
        "stay", "stays", "staying", "wait", "waits", "waiting", "remain", "remains", "remaining", "stay put",
        "stand still", "keep still", "stay still", "hold position", "hold", "idle", "do nothing",
        "stay where i am", "remain where i am",
        "stationary", "stand", "standing", "rest", "pause", "stop", "keep position", "maintain position", "still",
        "keep my position", "stehenbleiben", "rester sur place", "sur place", "정지", "멈춤", "멈추기", "머물러",
        "静止", "停止",
        "残る", "そのまま", "保持",
        "bleiben", "bleibe", "bleib", "warten", "warte", "stehen bleiben", "rester", "reste", "attendre", "quedarse",
        "quedarme", "permanecer", "esperar", "restare", "rimanere", "aspettare", "ficar", "aguardar", "blijven",
        "blijf", "wachten", "zostać", "zostań", "zostaję", "czekać", "pozostać", "остаться", "остаюсь", "оставаться",
        "стоять", "ждать", "留まる", "とどまる", "止まる", "待つ", "待機", "待機する", "その場に留まる",
        "その場にとどまる", "滞在",
        "停留", "留", "留下", "等待", "不动", "保持不动", "原地不动", "待在原地", "留在原地", "머무르기",
        "머무르다", "머무름", "머물기", "머물다",
        "대기", "유지", "가만히 있기",
    ),
    MOVE: (
        "move", "moves", "moving", "go", "goes", "going", "walk", "walks", "walking", "run", "running", "head",
        "heading", "step", "travel", "proceed", "advance", "continue", "keep moving", "keep going", "flee",
        "escape", "turn", "shift", "evacuate",
        "bewegen", "bewege", "bewegung", "gehen", "gehe", "geh", "laufen", "aller", "bouger", "se déplacer",
        "déplacer", "déplacement", "mouvement", "avancer", "mover", "moverse", "moverme", "mueve", "moverte", "ir",
        "avanzar", "caminar", "muovere", "muoversi", "muoviti", "spostarsi", "andare", "andar", "bewegen", "gaan",
        "lopen", "ruch", "idź", "iść", "ruszać", "przesunąć się", "двигаться", "идти", "иди", "двигайся", "движение",
        "переместиться", "移動", "移動する", "移動します", "動く", "進む", "行く", "移动", "移动到", "走", "移",
        "前进",
        "去", "이동",
        "이동하기", "이동하다", "움직이기", "움직이다", "가기",
    ),
}  # fmt: skip

FILLERS = (
    "i", "i'll", "i'm", "will", "want", "choose", "decide", "decided", "have", "and", "straight", "let's", "let",
    "us", "to", "the", "one", "1", "step", "steps", "cell",
    "unit",
    "by", "space", "side", "in", "direction", "coordinate",
    "nach", "ich", "hier", "zum", "l'", "all'", "d'", "ici", "aquí", "aqui", "qui", "sitio", "lugar", "quieto",
    "fermo", "parado",
    "месте", "здесь", "原地", "原位", "その場", "ここ", "現在地", "제자리", "제자리에", "der", "die", "eine",
    "vers", "le", "la", "à", "en", "a", "hacia", "para", "al", "el", "verso",
    "naar", "w", "na", "в", "на", "に", "へ", "を", "する", "します", "方向", "로", "으로", "하기", "하다",
)  # fmt: skip
"""Words without meaning for the decision."""

REMARKS = (
    "(", "[", ",", ":", ";", ".", "-", "–", "—", "//", "#", "/*",
    "toward", "because", "since", "so ", "as ", "to ",
)  # fmt: skip
STAYING_REMARKS = ("in ", "at ", "here", "inside", "within", "on ", "for ", "until", "where", "there")
"""Beginnings of remarks, which do not change the decision before them; the latter only after a decision to stay."""

DOUBTS = frozenset(
    ("not", "no", "don't", "dont", "never", "or", "unless", "if", "maybe", "perhaps", "possibly", "either", "then",
     "instead", "away", "except", "but", "later", "nicht", "oder", "vielleicht", "ou", "pas", "o", "не", "или",
     "または", "か", "或", "不", "또는")
)  # fmt: skip
"""Words in a remark that cast doubt on the decision before it."""

NOT_MOVING = frozenset(
    ("do not move", "don't move", "dont move", "no move", "no movement", "not move", "not moving", "nicht bewegen",
     "ne pas bouger", "no moverse", "動かない", "移動しない", "不移动", "не двигаться")
)  # fmt: skip
"""Negated motions; they mean staying if no direction is given."""

NO_DIRECTION = frozenset(("", "null", "none", "n/a", "na", "nil", "-", "--", "no direction", "なし", "无", "無"))

SILENCE = frozenset(
    ("null", "none", "n/a", "na", "nil", "undefined", "no message", "no messages", "no message to send",
     "no message needed", "no message is needed", "no message necessary", "no message sent", "no message required",
     "no message at this time", "no message for now", "not sending a message", "no need to send a message",
     "i have no message", "i have no message to send", "i don't want to send a message", "no message this step",
     "no message this time", "no message this turn", "no message to share", "no need for a message",
     "nothing to say", "nothing to share",
     "nothing to send", "none needed", "i choose not to send a message", "silence", "stay silent", "empty",
     "empty string", "blank", "left empty",
     "keine", "keine nachricht", "aucun", "aucun message", "pas de message", "ninguno", "ningún mensaje",
     "sin mensaje", "no hay mensaje", "nessuno", "nessun messaggio", "nenhuma", "nenhuma mensagem", "sem mensagem",
     "geen", "geen bericht", "brak", "brak wiadomości", "нет", "нет сообщения", "нет сообщений",
     "なし", "無し", "メッセージなし", "メッセージはありません", "特になし", "送信なし", "无", "無", "没有",
     "没有消息", "无消息", "不发送消息", "沉默", "없음",
     "메시지 없음")
)  # fmt: skip
"""Whole messages that mean silence."""

PLACEHOLDERS = (
    "message to nearby agents (max 200 words, optional if you don't want to send a message)",
    "what you tell them, 200 words at most; leave it out to say nothing",
    "近くのエージェントへのメッセージ（最大200語、送らない場合は省略可）",
    "what you say",
    "あなたの言葉",
    "your message here",
    "message here",
    "message text",
    "the message",
    "your message to nearby agents",
    "insert message here",
)
"""Placeholders for the message in prompts, and their copies by models."""

BLANKS = frozenset(("message", "text", "string", "content", "your", "insert", "optional", "brief", "short"))
"""Words that make a message in angle brackets a placeholder: "<your message>", but not "<fire near cafe>"."""


_DIRECTIONS = frozenset((UP, DOWN, LEFT, RIGHT))
_LONGEST = 120
"""Maximum number of characters; the meaning of longer texts is not guessed."""

_MOST_PARTS = 4
"""Maximum number of texts in a list or object in place of one text."""

_GENERIC = frozenset(("", "type", "name", "value", "action", "direction", "move", "kind"))
_FILLER = ""
_AXIS = re.compile(r"\s*([+-])\s*(?=1(?!\d)|[xy](?!\w))")
_CHANGE = re.compile(r"\b([xy])\s*=\s*\1\s*([+-])")
_INVISIBLE = re.compile("[\ufe0e\ufe0f\u200b-\u200d\u2060\ufeff]")
_SKIPPED = re.compile(r"(?:[\s\"'`*_.,:;!()\[\]{}/|~“”„«»「」『』。、・]|-(?![xy]\b))+")
_LETTERS = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?")
_AROUND = " \t\r\n.!*_'\"`()[]<>{}-“”「」。（）【】"
_SPACES = re.compile(r"[\W_]+")


@dataclass(frozen=True, slots=True)
class Meaning:
    """An action (`stay` or `move`) and, for a move, its direction."""

    action: str
    direction: str | None


@dataclass(frozen=True, slots=True)
class _Phrase:
    """A known phrase in a text: its meaning and its end."""

    meaning: str
    end: int


_REMEMBERED = 4096
"""Maximum number of normalised texts in the cache; almost every reply repeats the same keys and values."""

_STAYING = Meaning("stay", None)
_MEANINGS = dict.fromkeys(FILLERS, _FILLER) | {word: meaning for meaning, words in MEANINGS.items() for word in words}
_KEYS = {name: key for key, names in KEYS.items() for name in names}


def _bounded(word: str) -> str:
    """Return the pattern of a phrase; in a script with spaces it must match whole words."""
    before, after = ("" if _joins(word[end]) else bound for end, bound in ((0, r"(?<!\w)"), (-1, r"(?!\w)")))
    return before + re.escape(word) + after


def _joins(character: str) -> bool:
    return not unicodedata.name(character, "").startswith(("LATIN", "CYRILLIC", "DIGIT"))


@cache
def _phrase() -> re.Pattern[str]:
    """Return the pattern of all known phrases; compiled on first use, since that takes milliseconds."""
    return re.compile("|".join(_bounded(word) for word in sorted(_MEANINGS, key=len, reverse=True)))


@lru_cache(maxsize=_REMEMBERED)
def key_of(name: str) -> str | None:
    """Return the key that a name means in any of the languages, or None."""
    if len(name) > _LONGEST:
        return None
    return _KEYS.get(_plain(name).strip(_AROUND).replace("_", " "))


def understand(action: object, direction: object) -> Meaning | None:
    """Return the common meaning of the two values of a reply, or None if it is uncertain.

    Either value may give the direction, but not two different ones.
    """
    asked, wanted = _text(action), _text(direction)
    given = direction is not None and wanted not in NO_DIRECTION
    if asked in NOT_MOVING:
        return None if given else _STAYING
    words = None if asked is None else _words(asked)
    if not words or STAY in words and len(words) > 1:
        return None
    if STAY in words:
        return _STAYING
    further = frozenset[str]() if not given else None if wanted is None else _words(wanted)
    if further is None or STAY in further:
        return None
    directions = (words | further) & _DIRECTIONS
    return Meaning("move", *directions) if len(directions) == 1 else None


def is_silence(message: str) -> bool:
    """Return whether a message only says that there is none."""
    said = _plain(message[: _LONGEST + 1]).strip(_AROUND + "…")
    return said in SILENCE or not said


def is_placeholder(message: str) -> bool:
    """Return whether a message is the prompt's placeholder for one, or the beginning of it."""
    said = _SPACES.sub(" ", message[:_LONGEST].lower()).strip()
    bracketed = message.strip().startswith("<") and message.strip().endswith(">")
    return said in _COPIED or (bracketed and (not said or not BLANKS.isdisjoint(said.split())))


_PLACEHOLDERS = tuple(_SPACES.sub(" ", known.lower()).strip() for known in PLACEHOLDERS)
_TELLING = 12
"""Characters of a placeholder that suffice to recognise it."""
_COPIED = frozenset(known[:end] for known in _PLACEHOLDERS for end in range(min(len(known), _TELLING), len(known) + 1))


@lru_cache(maxsize=_REMEMBERED)
def _plain(text: str) -> str:
    return _INVISIBLE.sub("", unicodedata.normalize("NFKC", text)).lower().replace("’", "'").strip()


def _text(value: object) -> str | None:
    """Return the normalised text of a value, or of the few texts in a list or object; else None."""
    if isinstance(value, dict):
        value = [part for key, one in value.items() for part in (key if key.lower() not in _GENERIC else "", one)]
        value = [part for part in value if part not in ("", None)]
    if isinstance(value, list):
        few = 0 < len(value) <= _MOST_PARTS and all(isinstance(part, str) for part in value)
        value = " , ".join(value) if few else None
    return _spelled(value) if isinstance(value, str) and len(value) <= _LONGEST else None


@lru_cache(maxsize=_REMEMBERED)
def _spelled(text: str) -> str:
    return _AXIS.sub(r"\1", _CHANGE.sub(r"\1\2", _plain(text).replace("_", " "))).strip(" \"'")


@lru_cache(maxsize=_REMEMBERED)
def _words(text: str) -> frozenset[str] | None:
    """Return the meanings of the words in a text, or None if an unknown word is outside a remark."""
    phrases = list(_phrases(text))
    telling = [number for number, phrase in enumerate(phrases) if phrase.meaning != _FILLER]
    found = frozenset(phrases[number].meaning for number in telling)
    end = phrases[-1].end if phrases else 0
    if not _SKIPPED.sub("", text[end:]):
        return found
    if not telling:
        return None
    return found if _is_remark(text[phrases[telling[-1]].end :].lstrip(" \"'*`"), found) else None


def _phrases(text: str) -> Iterator[_Phrase]:
    """Yield the known phrases at the beginning of a text, up to the first unknown word."""
    position, phrase = 0, _phrase()
    while True:
        skipped = _SKIPPED.match(text, position)
        match = phrase.match(text, position) or (skipped and phrase.match(text, skipped.end()))
        if not match:
            return
        position = match.end()
        yield _Phrase(_MEANINGS[match[0]], position)


def _is_remark(rest: str, found: frozenset[str]) -> bool:
    """Return whether the rest of a value is a remark that adds nothing to the decision before it."""
    opening = (*REMARKS, *STAYING_REMARKS) if found == {STAY} else REMARKS
    if not rest.startswith(opening) or "?" in rest or DOUBTS & set(_LETTERS.findall(rest)):
        return False
    said = {_MEANINGS[match[0]] for match in _phrase().finditer(rest)} - {_FILLER}
    return said <= found | (set() if STAY in found else {MOVE})


_MOST = 32
"""Maximum number of labels in a text; one with more is no reply to the question."""

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
    """Return the values after the names of keys.

    Args:
        text: a reply without an object.
        cut: whether the text was cut; its last value may then be incomplete.

    Returns:
        Texts by requested key; `Conflicting` if a key has several texts.
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
    """Return a value without its markup and the comment after it; a decision is a single line."""
    text = _COMMENT.sub(r"\1", text)
    value = text.strip(_MARKUP).removesuffix("}").strip(_MARKUP)
    if key in ("action", "direction"):
        value = value.split("\n", 1)[0].strip(_MARKUP)
    for opening, closing in _QUOTES:
        if len(value) > 1 and value.startswith(opening) and value.endswith(closing):
            return _ESCAPES.sub(lambda match: str(json.loads(f'"{match[0]}"')), value[1:-1])
    return value
