"""Reads the lines of a run's record files, and sees to it that they are the ones the run wrote."""

import hashlib
from pathlib import Path
from typing import Any, TypeVar

from foundry.errors import RecordError
from foundry.records import Agent, Message, RunSummary
from foundry.storing.store import RunFolder, lines_of

COMPLETE, FAILED, UNFINISHED, NOT_STARTED = "complete", "failed", "unfinished", "not started"
"""How a run stands; the first two as in `run.json`."""

AGENTS, STEPS, MESSAGES, EPISODE = "agents.jsonl", "steps.jsonl", "messages.jsonl", "episode.jsonl"
"""The record files."""

_Line = TypeVar("_Line")


def read_lines(
    folder: RunFolder, name: str, content: bytes, summary: RunSummary | None, kind: type[_Line]
) -> list[_Line]:
    """Return the lines of a record file; the torn last line of a run that has not ended is left out.

    Raises:
        RecordError: the file is damaged, or is not the one that the run wrote.
    """
    file = folder.path / name
    if summary is None:
        content = content[: content.rfind(b"\n") + 1]
    else:
        _check_digest(file, content, summary)
    return lines_of(content, kind, file)


def read_messages(folder: RunFolder, summary: RunSummary | None) -> list[Message]:
    """Return the deliveries of a run, none where nobody talks; raises as `read_lines`."""
    return read_lines(folder, MESSAGES, folder.messages_bytes(), summary, Message)


def read_further(folder: RunFolder, stream: str, summary: RunSummary | None) -> list[dict[str, Any]]:
    """Return the lines of a record file of the world's own, none where the run wrote none; raises as `read_lines`."""
    file = folder.stream_path(stream)
    content = file.read_bytes() if file.is_file() else b""
    is_recorded = content or (summary is not None and file.name in summary.records_sha256)
    return read_lines(folder, file.name, content, summary, dict[str, Any]) if is_recorded else []


def read_agents(folder: RunFolder, summary: RunSummary | None) -> list[Agent]:
    """Return the agents that a run recorded; none where its world has no personas.

    Raises:
        RecordError: the file is damaged, or is not the one that the run wrote.
    """
    content = folder.agents_bytes()
    is_recorded = content or (summary is not None and AGENTS in summary.records_sha256)
    return read_lines(folder, AGENTS, content, summary, Agent) if is_recorded else []


def last_step(folder: RunFolder) -> int:
    """Return the step of the last whole line that a run recorded; 0 where there is none.

    Raises:
        RecordError: that line is damaged.
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
            f"{file} is not the file that the run wrote (its SHA-256 differs from run.json): "
            "restore it, or delete the run's folder and run it again."
        )
