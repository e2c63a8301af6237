"""What is said of a command outside the simulation: in records, on the command line, in the prompt's history."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

from foundry.errors import InputError
from foundry.records import CameraStep, Outcome
from foundry.worlds.camera.language.interpreter import Command, Limits, Translation, interpret, render_command

SHIPPED_LIMITS = Limits(max_distance_m=3.0, max_turn_deg=180.0, max_gaze_deg=60.0)
"""The limits of `conf/world/usd.yaml`."""


def command_record(command: Command) -> dict[str, Any]:
    """Return a command as plain data: `translate` (null or `{bearing, distance}`), `turn`, `gaze`, `stay`."""
    translate = command.translate
    return {
        "translate": None
        if translate is None
        else {"bearing": round(translate.bearing, 9), "distance": round(translate.distance, 9)},
        "turn": command.turn,
        "gaze": command.gaze,
        "stay": command.stay,
    }


def recorded_command(step: CameraStep) -> Command:
    """Return the command of a recorded decision; the inverse of `command_record`."""
    said = step.command
    translate = None if said["translate"] is None else Translation(**said["translate"])
    return Command(translate, said["turn"], said["gaze"], said["stay"], step.outcome, step.notes)


def describe(command: Command, record: CameraStep) -> str:
    """Return in a short phrase what was understood and what came of it."""
    said = render_command(command) if record.outcome in (Outcome.CHOSEN, Outcome.REPAIRED) else str(record.outcome)
    return f"{said}; {record.boundary}" if record.boundary else said


def read_replies(lines: Iterable[str], *, limited: bool) -> Iterator[str]:
    """Yield a JSON object for each reply, given as one JSON string a line.

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
            raise InputError(f'Line {number} is not a JSON string: write "..." with quotes, one reply a line.')
        command = interpret(reply, SHIPPED_LIMITS if limited else None)
        said = {**command_record(command), "outcome": command.outcome, "notes": list(command.notes)}
        yield json.dumps(said, ensure_ascii=False)
