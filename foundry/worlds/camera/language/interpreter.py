"""Reads the movement that a reply in plain language asks for; invents none.

Translation, turn of the body and turn of the gaze are read apart, each from its latest occurrence in the text;
"stay" takes back what was said in earlier sentences. A direction counts only as the word of a verb of motion, behind
another command, or in a sentence that says nothing else. What is negated, merely possible, conditional, asked or
given as an example is no command; nor is what is told of earlier steps or of others, as a purpose or for later
(`language.telling`), nor quotations of earlier steps and lists to choose from (`language.quotations`). An amount that
is not named is the configured default; one that exceeds a limit is clamped; the notes say so. A reply that is a JSON
object is read as that: with the keys that are asked for (`json_commands`), or with words of its own (`json_words`).

`chosen`: at least one command was found. `unreadable`: none was, and nothing moves. `repaired`: JSON that is not
the whole reply or, where JSON is asked for, a command in plain language.

Time is linear in the length of the reply.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import replace

from foundry.errors import InputError
from foundry.records import Outcome
from foundry.worlds.camera.language.command import Command, Limits, command_record
from foundry.worlds.camera.language.json_commands import embedded_command, whole_command
from foundry.worlds.camera.language.resolving import resolve
from foundry.worlds.camera.language.sentences import last_sentence
from foundry.worlds.camera.language.tokens import cleaned
from foundry.worlds.replies import without_thinking

SHIPPED_LIMITS = Limits(max_distance_m=3.0, max_turn_deg=180.0, max_gaze_deg=60.0)
"""The limits of `conf/world/usd.yaml`."""


class Interpreter(ABC):
    """Turns replies into commands; the same reply always into the same one."""

    @abstractmethod
    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in a reply; without limits, nothing is clamped and the defaults are those of `Limits`."""


class LatestInterpreter(Interpreter):
    """Reads the whole reply, every kind of motion from its latest occurrence."""

    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in a reply."""
        return interpret(reply, limits)


class LastSentenceInterpreter(Interpreter):
    """Reads the last sentence alone."""

    def read(self, reply: str, limits: Limits | None = None) -> Command:
        """Return the command in the last sentence of a reply."""
        limits = limits or Limits()
        return whole_command(reply, limits) or resolve(last_sentence(cleaned(without_thinking(reply))), limits)


class JsonInterpreter(Interpreter):
    """Reads the JSON command of the prompt `json`; plain language in its place is `repaired`."""

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
    """Return the command in a reply; a pure function that raises nothing.

    Args:
        reply: any text.
        limits: what to assume and what to clamp to; None for the defaults of `Limits`, which clamp nothing.
    """
    limits = limits or Limits()
    return whole_command(reply, limits) or resolve(cleaned(without_thinking(reply)), limits)


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
