"""Composes a sweep that continues a recorded run from a step, and rejects overrides that would change earlier steps."""

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import msgspec

from foundry.composing.compose import Composed
from foundry.composing.defaults import Defaults
from foundry.composing.recorded import compose_recorded
from foundry.episode import play
from foundry.errors import InputError, UndeclaredError
from foundry.expansion import Condition, calls_seed, overridden, settings_key
from foundry.records import Call
from foundry.running.build import build
from foundry.running.recorded import Departed, NotRecorded, RecordedAsker, past_wordings
from foundry.storing.run_files import sha256_of, whole_lines
from foundry.storing.store import RunFolder, SweepFolder, calls_bytes, last_whole_step, lines_of, write_atomically
from foundry.trust.verifying import Comparer, EndOfRecords


def compose_fork(
    run: RunFolder, sweep: str, at: int, overrides: Sequence[str], defaults: Defaults | None = None
) -> Composed | None:
    """Compose the configuration of a run with overrides, to continue it from the step `at`.

    Returns:
        The composed sweep, or None if Hydra answered the command line itself, as with --help.
    """
    _check_step(run, at)
    config = run.config()
    if "seed" in overridden(overrides):
        raise InputError(
            "A fork keeps the seed of its run, because earlier steps depend on it. Vary sampling_seed instead."
        )
    composed = compose_recorded(config, overrides, defaults)
    if composed is None:
        return None
    fork = _fork_block(run, config, sweep, at)
    conditions = tuple(
        replace(condition, config={**condition.config, "fork": fork}) for condition in composed.conditions
    )
    for condition in {settings_key(condition.config["world"]): condition for condition in conditions}.values():
        _check_past(run, condition, at)
    return replace(
        composed, asked=("fork", f"{sweep}/{run.id}", f"at={at}", *composed.chosen, *overrides), conditions=conditions
    )


def keep_origin(folder: SweepFolder, run: RunFolder, at: int) -> None:
    """Copy the calls before the step `at` into the folder of a fork, which then no longer needs the original run."""
    path = folder.origin_path(run.id, at)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, calls_bytes(_calls_before(run, at)))


def _calls_before(run: RunFolder, at: int) -> list[Call]:
    return [call for call in run.calls() if call.step < at]


def _check_step(run: RunFolder, at: int) -> None:
    steps = _steps_of(run)
    if not steps:
        raise InputError(f"Run '{run.id}' has no recorded step yet, so it cannot be continued.")
    last = last_whole_step(steps, complete=run.is_complete)
    if not 2 <= at <= last + 1:
        raise InputError(f"--at {at}: run '{run.id}' has {last} steps, so use a step from 2 to {last + 1}.")


class _StepOf(msgspec.Struct):
    step: int = 0


def _steps_of(run: RunFolder) -> list[int]:
    return [line.step for line in lines_of(whole_lines(run.steps_bytes()), _StepOf, run.stream_path("steps"))]


def _fork_block(run: RunFolder, config: Mapping[str, Any], sweep: str, at: int) -> dict[str, Any]:
    """Return the part `fork` of a fork's configuration: the continued run, and the prompts and seeds of its calls."""
    whole = {"before": None, "prompt": config["prompt"], "seed": calls_seed(config)}
    past: list[dict[str, Any]] = []
    for part in [*config.get("fork", {}).get("past", []), whole]:
        if part["before"] is not None and part["before"] < at:
            past.append(part)
        else:
            past.append({**part, "before": at})
            break
    return {"sweep": sweep, "run": run.id, "at": at, "records_sha256": _shared_digests(run, at), "past": past}


def _shared_digests(run: RunFolder, at: int) -> dict[str, str]:
    return {
        f"{stream}.jsonl": sha256_of(_shared(run, stream, at))
        for stream in run.streams
        if run.stream_path(stream).exists()
    }


def _shared(run: RunFolder, stream: str, at: int) -> bytes:
    path = run.stream_path(stream)
    lines = path.read_bytes().splitlines(keepends=True)
    steps = lines_of(b"".join(lines), _StepOf, path)
    return b"".join(line for line, step in zip(lines, steps, strict=True) if step.step < at)


def _check_past(run: RunFolder, condition: Condition, at: int) -> None:
    """Replay the steps before `at` in the world of the fork, and raise an error if they differ."""
    config = {**condition.config, "seed": run.run.seed}
    world = build(config["world"]).start(config["seed"])
    asker = RecordedAsker(_calls_before(run, at), past_wordings(config))
    comparer = Comparer(run, ended=False)
    try:
        asyncio.run(play(world, asker, comparer))
    except NotRecorded as end:
        if end.place[0] == at:
            return
        raise _refusal(f"at step {end.place[0]}, agents would get other questions than the recorded ones") from end
    except Departed as departed:
        place = departed.difference.place
        when = f"at step {place[0]}" if place else "at the start"
        raise _refusal(f"{when} this line would differ: {departed.difference.line()}") from departed
    except (EndOfRecords, UndeclaredError) as more:
        raise _refusal(f"at step {max(1, world.step)} the fork would have more records: {more}") from more
    raise InputError(f"--at {at}: the fork would end after {world.step} steps. Raise world.steps, or use a lower --at.")


def _refusal(why: str) -> InputError:
    return InputError(
        f"These overrides change steps before the fork: {why}. Change only settings that have no effect on those steps."
    )
