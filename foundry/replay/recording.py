"""Reads the records of a run into an object from which any process can draw the run's pictures."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path

import msgspec

from foundry.composing.preflight import scenario_of
from foundry.errors import FoundryError, InputError, RecordError
from foundry.records import NOT_JSON, RunSummary
from foundry.storing.store import RunFolder, last_whole_step, stored_picture
from foundry.texts import one_line
from foundry.trust.unknown import check_targets
from foundry.worlds.base import Recorded, Redrawing


@dataclass(frozen=True)
class Recording:
    """The records of one run.

    Attributes:
        config: the effective configuration, as JSON.
        steps: lines of `steps.jsonl`, up to the last complete step.
        episode: the line of `episode.jsonl`; empty if the world writes none.
        last: the last complete step; 0 if there is none.
        note: why the run is incomplete; "" if it is complete.
        identity: model, world, prompt, seed and swept settings, as pairs of name and value.
        trusted: further packages that may contain classes of its world.
        messages: lines of `messages.jsonl`; empty if no message was delivered.
    """

    id: str
    folder: Path
    config: bytes
    steps: bytes
    episode: bytes
    last: int
    note: str
    identity: tuple[tuple[str, str], ...] = field(repr=False)
    trusted: tuple[str, ...] = ()
    messages: bytes = b""


class _StepOf(msgspec.Struct):
    step: int


def read_recording(run: RunFolder, trusted: Sequence[str] = ()) -> Recording:
    """Return the records of a run so far.

    Raises:
        InputError: the run has not begun.
        RecordError: the records are damaged.
    """
    if not run.path.is_dir():
        raise InputError(f"Run '{run.id}' has not been started yet, so there is nothing to replay.")
    steps = _whole_lines(run.steps_bytes())
    try:
        numbers = [line.step for line in msgspec.json.Decoder(_StepOf).decode_lines(steps)]
    except NOT_JSON as error:
        raise RecordError(f"The steps of '{run.path}' cannot be read: {error}") from error
    summary = run.summary()
    last = last_whole_step(numbers, complete=summary is not None and summary.status == "complete")
    config = run.config()
    return Recording(
        id=run.id,
        folder=run.path,
        config=msgspec.json.encode(config),
        steps=b"".join(line for line, number in zip(steps.splitlines(True), numbers, strict=True) if number <= last),
        episode=_whole_lines(run.episode_bytes()),
        last=last,
        note=_note(summary, last),
        identity=_identity(run),
        trusted=tuple(trusted),
        messages=_whole_lines(run.messages_bytes()),
    )


@lru_cache(maxsize=64)
def redrawing_of(recording: Recording) -> Redrawing:
    """Return an object that draws the pictures of a run; for an equal recording, return the same object."""
    return redrawn(recording)


def redrawn(recording: Recording) -> Redrawing:
    """Return the pictures that the run's world draws from its records; raise InputError if the world cannot."""
    config = msgspec.json.decode(recording.config)
    # Only the world is built, so the model is irrelevant.
    check_targets({"world": config["world"]}, recording.trusted, f"Run '{recording.id}'")
    recorded = Recorded(config["seed"], recording.steps, recording.episode, partial(stored_picture, recording.folder))
    scenario = scenario_of(config)
    with _drawing(recording):
        return scenario.redraw(recorded)


def picture_of(recording: Recording, redrawing: Redrawing, step: int) -> bytes:
    """Return a PNG of the state of a run after a step, or raise InputError if its world cannot draw it."""
    with _drawing(recording):
        return redrawing.draw(step)


@contextlib.contextmanager
def _drawing(recording: Recording) -> Iterator[None]:
    """Within this context, turn any error in a world's code into an error whose message is one line with its name."""
    try:
        yield
    except FoundryError:
        raise
    except Exception as error:
        world, said = dict(recording.identity).get("world"), one_line(f"{type(error).__name__}: {error}")
        raise InputError(f"World '{world}' cannot redraw run '{recording.id}' ({said}).") from error


def _whole_lines(content: bytes) -> bytes:
    return content[: content.rfind(b"\n") + 1]


def _note(summary: RunSummary | None, last: int) -> str:
    if summary is None:
        return f"unfinished: recorded up to step {last}"
    if summary.status != "complete":
        return f"failed after step {last}: {summary.error}"
    return ""


def _identity(run: RunFolder) -> tuple[tuple[str, str], ...]:
    config = run.config()
    named = {group: str(config[group]["name"]) for group in ("model", "world", "prompt")}
    swept = {key: str(value) for key, value in run.factors.items() if key not in named}
    return tuple({**named, "seed": str(config["seed"]), **swept}.items())
