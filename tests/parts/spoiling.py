"""Spoils recorded files: torn, of wrong types, with random bytes, with numbers that no array holds."""

from __future__ import annotations

import hashlib
from typing import Any

import msgspec
import numpy as np

from foundry.storing.store import RunFolder

HOSTILE: tuple[bytes, ...] = (
    *(b"null", b"true", b"-1", b"0.5", b"1e308", b"1e999", b"NaN", b"Infinity", b"-0.0", b"[]", b"{}", b'""'),
    *(str(2**31).encode(), str(2**63).encode(), str(-(2**63)).encode(), str(2**64).encode(), b'"\\ud800"'),
    *(b'"chosen"', b'"failed"', b"9" * 5000, b'"../../x"', b'"\\u0000"', b"[[[[]]]]", b"[-1]", b"[99999]"),
    b'["no such fire"]', b'{"translate": 1}', b'{"x": 1}', b"[" * 2000, b'{"a":' * 2000,
)  # fmt: skip
"""Texts that stand where a value was; not all are JSON."""


def spoiled(content: bytes, rng: np.random.Generator) -> bytes:
    """Return the content, changed somewhere."""
    kind = int(rng.integers(7))
    at = int(rng.integers(len(content) + 1))
    if kind == 0:
        return content[:at]
    if kind == 1:
        return content[:at] + rng.bytes(int(rng.integers(1, 20))) + content[at:]
    if kind == 2 and content:
        changed = bytearray(content)
        changed[at % len(content)] ^= int(rng.integers(1, 256))
        return bytes(changed)
    lines = content.split(b"\n")
    if kind == 3:
        lines.insert(int(rng.integers(len(lines))), lines[int(rng.integers(len(lines)))])
    elif kind == 4:
        del lines[int(rng.integers(len(lines)))]
    else:
        place = int(rng.integers(len(lines)))
        lines[place] = _with_another_value(lines[place], rng)
    return b"\n".join(lines)


def _with_another_value(line: bytes, rng: np.random.Generator) -> bytes:
    """Return a JSON object with one value, at any depth, in which something hostile stands."""
    try:
        found = msgspec.json.decode(line)
    except msgspec.DecodeError:
        return HOSTILE[int(rng.integers(len(HOSTILE)))]
    places = list(_places(found))
    if not places:
        return HOSTILE[int(rng.integers(len(HOSTILE)))]
    holder, key = places[int(rng.integers(len(places)))]
    if rng.random() < 0.1 and isinstance(holder, dict):
        del holder[key]
        return msgspec.json.encode(found)
    holder[key] = msgspec.Raw(HOSTILE[int(rng.integers(len(HOSTILE)))])
    return msgspec.json.encode(found)


def _places(value: Any) -> Any:
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield value, key
            yield from _places(value[key])


def settle(run: RunFolder) -> None:
    """Say in `run.json` that the record files are the ones that the run wrote."""
    file = run.path / "run.json"
    summary = msgspec.json.decode(file.read_bytes())
    for name in summary["records_sha256"]:
        summary["records_sha256"][name] = hashlib.sha256((run.path / name).read_bytes()).hexdigest()
    file.write_bytes(msgspec.json.encode(summary))
