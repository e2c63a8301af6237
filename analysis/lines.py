"""Reads the lines of a run's record files, and checks that the files were not changed."""

import hashlib
from pathlib import Path
from typing import Any, TypeVar

from foundry.errors import RecordError
from foundry.records import Agent, Message, RunSummary
from foundry.storing.store import RunFolder, lines_of

COMPLETE, FAILED, UNFINISHED, NOT_STARTED = "complete", "failed", "unfinished", "not started"
"""The values of a run's status; `run.json` contains the first two."""

AGENTS, STEPS, MESSAGES, EPISODE = "agents.jsonl", "steps.jsonl", "messages.jsonl", "episode.jsonl"
"""The record files."""

_Line = TypeVar("_Line")


def read_lines(
    folder: RunFolder, name: str, content: bytes, summary: RunSummary | None, kind: type[_Line]
) -> list[_Line]:
    """Return the lines of a record file, without the incomplete last line of an unfinished run.

    Raises:
        RecordError: the file is damaged, or was changed after the run.
    """
    file = folder.path / name
    if summary is None:
        content = content[: content.rfind(b"\n") + 1]
    else:
        _check_digest(file, content, summary)
    return lines_of(content, kind, file)


def read_messages(folder: RunFolder, summary: RunSummary | None) -> list[Message]:
    """Return the delivered messages of a run; raises the errors of `read_lines`."""
    return read_lines(folder, MESSAGES, folder.messages_bytes(), summary, Message)


def read_further(folder: RunFolder, stream: str, summary: RunSummary | None) -> list[dict[str, Any]]:
    """Return the lines of a further record file, if the run has one; raises the errors of `read_lines`."""
    file = folder.stream_path(stream)
    content = file.read_bytes() if file.is_file() else b""
    return _read_optional(folder, file.name, content, summary, dict[str, Any])


def read_agents(folder: RunFolder, summary: RunSummary | None) -> list[Agent]:
    """Return the agents of a run, if its world has personas; raises the errors of `read_lines`."""
    return _read_optional(folder, AGENTS, folder.agents_bytes(), summary, Agent)


def _read_optional(
    folder: RunFolder, name: str, content: bytes, summary: RunSummary | None, kind: type[_Line]
) -> list[_Line]:
    is_recorded = content or (summary is not None and name in summary.records_sha256)
    return read_lines(folder, name, content, summary, kind) if is_recorded else []


def last_step(folder: RunFolder) -> int:
    """Return the step of the last whole line of a run, or 0; a damaged line raises a RecordError."""
    content = folder.steps_bytes()
    whole = content[: content.rfind(b"\n") + 1].splitlines()[-1:]
    steps = lines_of(b"".join(whole), dict[str, Any], folder.path / STEPS)
    return max((int(line.get("step", 0)) for line in steps), default=0)


def _check_digest(file: Path, content: bytes, summary: RunSummary) -> None:
    expected = summary.records_sha256.get(file.name)
    if expected is None and summary.status != COMPLETE:
        return
    if hashlib.sha256(content).hexdigest() != expected:
        raise RecordError(
            f"{file} was changed after the run (its SHA-256 differs from run.json): restore it, or delete the run's "
            "folder and run it again."
        )
