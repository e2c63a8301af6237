"""Cleans texts before they are recorded, printed or written into tables, and writes numbers with their nouns."""

import re
import unicodedata
from collections.abc import Sequence
from typing import Any, TextIO

_ASIDE = frozenset("\n\t")
_MASK = "***"
_FORMULA = re.compile(r"'*[=+\-@\t\r](?s:.)")
_USER = re.compile(r"(?<=://)[^\s'\"]*@")
_USER_ALONE = re.compile(
    r"(?<![\w./@%+-])[^\s'\"/@,:=]+:[^\s'\"/@,]+@"
    r"(?=localhost\b|\[|\d+(?:\.\d+){3}|[a-z][\w-]*(?:\.[\w-]+)+|[a-z][\w.-]*:\d)",
    re.IGNORECASE,
)
"""Finds user and password in an address without a scheme, as `me:pw@host:11434`, but not in `qwen3:4b@50%`."""
_KEYS = r"[\w.-]*(?:password|passwd|pwd|token|key|secret|signature|sig|credential)"
_IN_QUERY = re.compile(rf"(?<=[?&])({_KEYS}=)[^\s'\"&#]+", re.IGNORECASE)
_PASSWORD = re.compile(r"\b((?:ssl)?password\s*=\s*)(?:'[^']*'|[^\s'\"&]+)", re.IGNORECASE)
_SECRET = re.compile(
    rf"\w+://[^\s/@'\"]*:[^\s/@'\"]+@|\w+://[^\s'\"]*[?&]{_KEYS}=[^\s'\"&*]"
    r"|\b(?:host|hostaddr|dbname|user|port|service)\s*=.*\b(?:ssl)?password\s*=\s*(?:'[^'*]|[^\s'*])"
    r"|\b(?:ssl)?password\s*=\s*(?:'[^'*]|[^\s'*]).*\b(?:host|hostaddr|dbname|user|port|service)\s*=",
    re.IGNORECASE,
)


def without_surrogates(text: str) -> str:
    """Replace lone surrogates, which UTF-8 cannot encode, by U+FFFD."""
    if text.isascii():
        return text
    return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")


def without_secrets(text: str) -> str:
    """Replace users, passwords and keys in addresses, such as `http://user:pw@host/?token=x`, by `***`.

    This includes addresses without a scheme (`user:pw@host:11434`) and those of databases (`host=x password=y`).
    """
    if "@" in text:
        text = _USER_ALONE.sub(f"{_MASK}@", _USER.sub(f"{_MASK}@", text))
    return _PASSWORD.sub(rf"\1{_MASK}", _IN_QUERY.sub(rf"\1{_MASK}", text)) if "=" in text else text


class WithoutSecrets:
    """A text stream that writes `***` for users, passwords and keys in addresses."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write the text without secrets."""
        return self._stream.write(without_secrets(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def holds_secret(text: str) -> bool:
    """Return whether an address in the text holds a password."""
    return _SECRET.search(text) is not None


def visible(text: str) -> str:
    r"""Escape characters that control a terminal or reverse the direction of writing, as in `\\x1b`."""
    return "".join(letter.encode("unicode_escape").decode() if _commands(letter) else letter for letter in text)


def one_line(text: object, longest: int | None = None) -> str:
    """Return a text or an error in one line, cut to at most `longest` characters."""
    line = " ".join(str(text).split())
    return line if longest is None or len(line) <= longest else f"{line[: longest - 1]}…"


def as_cell(text: str) -> str:
    """Put an apostrophe before a text that a spreadsheet would run as a formula if it were in a CSV file.

    Numbers and single characters are not changed; `from_cell` restores every text.
    """
    return f"'{text}" if _FORMULA.match(text) and not _is_number(text) else text


def from_cell(text: str) -> str:
    """Undo `as_cell`."""
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


def counted(number: int, name: str) -> str:
    """Return a number with a noun, as in "1 run" or "2 runs"."""
    return f"{number:,} {name}" if number == 1 else f"{number:,} {name}s"


def first_of(names: Sequence[str], most: int | None) -> str:
    """Return the first names, separated by commas, and the number of the others; None names all of them."""
    more = 0 if most is None else len(names[most:])
    return ", ".join(names[:most]) + (f" and {more} more" if more else "")


def ranges(numbers: Sequence[int]) -> str:
    """Return numbers as a sorted text with ranges, as in "0-2,7"."""
    parts: list[list[int]] = []
    for number in sorted(numbers):
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ",".join(str(part[0]) if len(part) == 1 else f"{part[0]}-{part[-1]}" for part in parts)


def in_words(seconds: float) -> str:
    """Return a duration in words, as in "2 h 5 min", "5 min 3 s" or "3 s"."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    if minutes:
        return f"{minutes} min {rest} s" if rest else f"{minutes} min"
    return f"{rest} s"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _commands(character: str) -> bool:
    if character.isascii():
        return not character.isprintable() and character not in _ASIDE
    return unicodedata.category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")
