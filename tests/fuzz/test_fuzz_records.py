"""A recorded file that was torn, spoiled or written by someone else is read, or refused in one line."""

import hashlib
import shutil
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from analysis.load import load, read_records, read_run
from commands import succeeds
from foundry.errors import FoundryError
from foundry.storing.store import RunFolder, SweepFolder

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


AT_LENGTH = (pytest.mark.exhaustive, pytest.mark.timeout(1800))
FILES = ("steps.jsonl", "messages.jsonl", "run.json", "calls.jsonl.zst", "sweep.yaml", "episode.jsonl")
SMALL = ("analyze=false", "output.dir=out", "runner.workers=1")


def played(folder: Path, *overrides: str) -> Path:
    """Run three steps; returns the sweep."""
    succeeds(*overrides, "world.steps=3", *SMALL, cwd=folder)
    return folder / "out"


@pytest.fixture(scope="module")
def grid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return played(tmp_path_factory.mktemp("grid"), "model=scripted/echo", "world.agents=4")


@pytest.fixture(scope="module")
def camera(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return played(tmp_path_factory.mktemp("camera"), "world=office", "model=scripted/wander")


def fuzz(sweep: Path, copy: Path, number: int) -> int:
    """Spoil one file after the other; returns how many were refused."""
    shutil.copytree(sweep, copy)
    (run,) = SweepFolder.open(copy).runs()
    files = [file for file in (copy / "sweep.yaml", *(run.path / name for name in FILES)) if file.exists()]
    whole = {file: file.read_bytes() for file in {*files, run.path / "run.json"}}
    rng, refused = np.random.default_rng(3), 0
    for turn in range(number):
        file = files[turn % len(files)]
        file.write_bytes(spoiled(whole[file], rng))
        if file.suffix == ".jsonl":
            settle(run)
        try:
            read(copy)
        except FoundryError as error:
            refused += 1
            assert str(error)
        for changed in (file, run.path / "run.json"):
            changed.write_bytes(whole[changed])
    return refused


def read(sweep: Path) -> None:
    """Read everything of a sweep as the analysis does."""
    load(sweep)
    for run in SweepFolder.open(sweep).runs():
        assert sum(1 for _ in run.calls()) >= 0
        summary = run.summary()
        if summary is not None and summary.status == "complete":
            read_run(run, read_records(run, summary))
        read_records(run, None)  # as if it had not ended


@pytest.mark.parametrize(
    ("kind", "number"),
    [
        ("grid", 30),
        pytest.param("camera", 30, marks=pytest.mark.exhaustive),
        *(pytest.param(kind, 10_000, marks=AT_LENGTH) for kind in ("grid", "camera")),
    ],
)
def test_spoiled_records_are_read_or_refused(kind: str, number: int, request: pytest.FixtureRequest, tmp_path: Path):
    refused = fuzz(request.getfixturevalue(kind), tmp_path / "copy", number)
    assert number / 4 < refused < number
