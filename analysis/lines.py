"""Reads the lines of a run's record files, and verifies that they are unchanged."""

import hashlib
from pathlib import Path
from typing import Any, TypeVar

from foundry.errors import RecordError
from foundry.records import Agent, Message, RunSummary
from foundry.storing.store import RunFolder, lines_of

COMPLETE, FAILED, UNFINISHED, NOT_STARTED = "complete", "failed", "unfinished", "not started"
"""The values of a run's status; the first two are as in `run.json`."""

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
    """Return the deliveries of a run, none in worlds without messages; raises the errors of `read_lines`."""
    return read_lines(folder, MESSAGES, folder.messages_bytes(), summary, Message)


def read_further(folder: RunFolder, stream: str, summary: RunSummary | None) -> list[dict[str, Any]]:
    """Return the lines of a further record file, none if the run wrote none; raises the errors of `read_lines`."""
    file = folder.stream_path(stream)
    content = file.read_bytes() if file.is_file() else b""
    is_recorded = content or (summary is not None and file.name in summary.records_sha256)
    return read_lines(folder, file.name, content, summary, dict[str, Any]) if is_recorded else []


def read_agents(folder: RunFolder, summary: RunSummary | None) -> list[Agent]:
    """Return the recorded agents of a run; none if its world has no personas.

    Raises:
        RecordError: the file is damaged, or was changed after the run.
    """
    content = folder.agents_bytes()
    is_recorded = content or (summary is not None and AGENTS in summary.records_sha256)
    return read_lines(folder, AGENTS, content, summary, Agent) if is_recorded else []


def last_step(folder: RunFolder) -> int:
    """Return the step of the last whole line of a run; 0 without lines.

    Raises:
        RecordError: the last whole line is damaged.
    """
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
