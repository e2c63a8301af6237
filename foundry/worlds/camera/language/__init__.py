"""Commands of 3D worlds: as data, in words, and in records."""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from foundry.errors import InputError
from foundry.records import CameraStep, Outcome, command_kind
from foundry.worlds.camera.language.lexicon import Way

BEARINGS = {
    frozenset((Way.FORWARD,)): 0.0,
    frozenset((Way.FORWARD, Way.LEFT)): 45.0,
    frozenset((Way.LEFT,)): 90.0,
    frozenset((Way.BACK, Way.LEFT)): 135.0,
    frozenset((Way.BACK,)): 180.0,
    frozenset((Way.BACK, Way.RIGHT)): -135.0,
    frozenset((Way.RIGHT,)): -90.0,
    frozenset((Way.FORWARD, Way.RIGHT)): -45.0,
}
"""The bearing of each direction, degrees from the heading, counter-clockwise."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Distances and angles that a command has by default and at most; None means no limit.

    Attributes:
        max_distance_m: largest distance of a translation.
        max_turn_deg: largest turn of the body to either side.
        max_gaze_deg: largest turn of the gaze up or down.
        default_distance_m: distance of a translation that names none.
        default_turn_deg: angle of a turn that names none.
        default_gaze_deg: angle of a turn of the gaze that names none.
        small_factor: factor on the default for "a bit".
        step_length_m: distance of "one step".
    """

    max_distance_m: float | None = None
    max_turn_deg: float | None = None
    max_gaze_deg: float | None = None
    default_distance_m: float = 1.0
    default_turn_deg: float = 30.0
    default_gaze_deg: float = 15.0
    small_factor: float = 0.5
    step_length_m: float = 0.7

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not 0 < value < float("inf"):
                raise InputError(f"limits.{field.name} is {value}. Give a number above 0.")


@dataclass(frozen=True)
class Translation:
    """A straight movement of the body to another place.

    Attributes:
        bearing: degrees from the heading, counter-clockwise: 0 forward, 90 left, 180 back, -90 right.
        distance: metres.
    """

    bearing: float
    distance: float


@dataclass(frozen=True)
class Command:
    """The command in a reply; the value of a motion is None if the reply does not ask for it.

    Attributes:
        turn: turn of the body, degrees, left positive.
        gaze: turn of the gaze, degrees, up positive.
        stay: whether the reply asks to stay, without any motion.
        outcome: `chosen`, `repaired` or `unreadable`.
        notes: remarks on how the reply was read, one line each.
    """

    translate: Translation | None = None
    turn: float | None = None
    gaze: float | None = None
    stay: bool = False
    outcome: Outcome = Outcome.UNREADABLE
    notes: tuple[str, ...] = ()

    @property
    def idle(self) -> bool:
        """True if the command moves nothing: "stay", an unreadable reply, or a command whose amounts are all zero."""
        return not (self.turn or self.gaze or (self.translate is not None and self.translate.distance))

    @property
    def is_read(self) -> bool:
        """True if the reply contains a command."""
        return self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED)

    @property
    def kind(self) -> str:
        """The kind of this command, one of `foundry.records.COMMAND_KINDS`."""
        way = self.translate or Translation(0.0, 0.0)
        return command_kind(way.bearing, way.distance, self.turn or 0.0, self.gaze or 0.0)


def every_kind(limits: Limits) -> tuple[Command, ...]:
    """Return one command of each kind in `foundry.records.COMMAND_KINDS`, without the first kind, `stay`.

    The commands have the default amounts, clamped to the limits.
    """
    metres = min(limits.default_distance_m, limits.max_distance_m or math.inf)
    turn = min(limits.default_turn_deg, limits.max_turn_deg or math.inf)
    gaze = min(limits.default_gaze_deg, limits.max_gaze_deg or math.inf)
    ways = (Command(translate=Translation(bearing, metres)) for bearing in (0.0, 180.0, 90.0, -90.0))
    return (*ways, Command(turn=turn), Command(turn=-turn), Command(gaze=gaze), Command(gaze=-gaze))


def render_command(command: Command) -> str:
    """Return a command in words; reading these words gives the same command."""
    parts = []
    if command.translate is not None:
        parts.append(_rendered_translation(command.translate))
    if command.turn is not None:
        parts.append(f"turn {'right' if command.turn < 0 else 'left'} {_number(command.turn)} degrees")
    if command.gaze is not None:
        parts.append(f"look {'down' if command.gaze < 0 else 'up'} {_number(command.gaze)} degrees")
    return ", ".join(parts) or ("stay" if command.stay else "nothing understood")


def _rendered_translation(translation: Translation) -> str:
    distance = f"move {_number(translation.distance)} m"
    for ways, bearing in BEARINGS.items():
        if bearing == translation.bearing:
            return f"{distance} {'-'.join(sorted(way.value for way in ways))}"
    side = "right" if translation.bearing < 0 else "left"
    return f"{distance} at an angle of {_number(translation.bearing)} degrees to the {side}"


def _number(value: float) -> str:
    return np.format_float_positional(abs(value), trim="-")


def limited(name: str, asked: float, largest: float | None, unit: str, notes: list[str]) -> float:
    """Return an amount clamped to ±`largest` (None: no limit). Add a note if the amount was changed."""
    if largest is None or abs(asked) <= largest:
        return float(asked)
    notes.append(f"{name}: {abs(asked):g} {unit} clamped to {largest:g} {unit}")
    return math.copysign(largest, asked)


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
    """Return the command of a recorded decision."""
    said = step.command
    translate = None if said["translate"] is None else Translation(**said["translate"])
    return Command(translate, said["turn"], said["gaze"], said["stay"], step.outcome, step.notes)


def describe(command: Command, record: CameraStep) -> str:
    """Return a phrase that says how a decision was understood, and which obstacle stopped the agent, if any."""
    said = str(record.outcome)
    if record.outcome in (Outcome.CHOSEN, Outcome.REPAIRED):
        said = f"answers {record.command['answer']}" if "answer" in record.command else render_command(command)
    return f"{said}; {record.boundary}" if record.boundary else said
