"""What every text of a model must go through before it is kept, or shown on a terminal."""

from __future__ import annotations

import re
import unicodedata

_ASIDE = frozenset("\n\t")
_USER = re.compile(r"(?<=://)[^\s'\"]*@")
_PASSWORD = re.compile(r"(?<=password=)[^\s'\"&]+", re.IGNORECASE)
_SECRET = re.compile(r"\w+://[^\s/@'\"]*:[^\s/@'\"]+@|\w+://[^\s'\"]*[?&](?:ssl)?password=[^\s'\"&*]", re.IGNORECASE)


def without_surrogates(text: str) -> str:
    """Return the text with lone surrogates, which UTF-8 cannot hold, as U+FFFD."""
    if text.isascii():
        return text
    return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")


def without_secrets(text: str) -> str:
    """Return the text with users and passwords in its addresses (`http://user:pw@host`) as `***`."""
    return _PASSWORD.sub("***", _USER.sub("***@", text)) if "://" in text else text


def holds_secret(text: str) -> bool:
    """Return whether an address in the text holds a password."""
    return _SECRET.search(text) is not None


def visible(text: str) -> str:
    r"""Return the text with characters that command a terminal or turn its writing around written out, as `\\x1b`."""
    return "".join(_written_out(one) if _commands(one) else one for one in text)


def counted(number: int, name: str) -> str:
    """Return a number of things with their name, in the plural unless it is one."""
    return f"{number:,} {name}" if number == 1 else f"{number:,} {name}s"


def _commands(character: str) -> bool:
    if character.isascii():
        return not character.isprintable() and character not in _ASIDE
    return unicodedata.category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")


def _written_out(character: str) -> str:
    return character.encode("unicode_escape").decode()
