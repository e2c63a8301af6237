"""Whole runs of shipped worlds and scripted policies, as the arrays that signatures are computed from."""

from __future__ import annotations

import asyncio
from pathlib import Path

import msgspec

from analysis.camera.camera_records import CameraRecords
from analysis.camera.camera_run import CameraRun
from analysis.grid.grid_records import FurnishedLine, GridRecords
from analysis.grid.grid_run import GridRun
from episodes import Kept, composed, play_through
from foundry.expansion import expand
from foundry.records import GridStep, Message
from foundry.storing.store import SweepFolder


def whole_run(path: Path, world: str, policy: str, *overrides: str, seed: int) -> GridRun | CameraRun:
    """Play a run to its end and return it; `path` is a folder that does not exist yet."""
    found, kept = composed(world, policy, *overrides), Kept()
    asyncio.run(play_through(found, seed, kept))
    folder = SweepFolder.create(path, expand([], found.conditions), {}, []).runs()[0]
    if kept.steps:
        return CameraRecords(kept.opening, kept.steps, []).arrays(folder)
    lines = [record for record in kept.records if isinstance(record, GridStep)]
    kind = FurnishedLine if hasattr(lines[0], "lost") else GridStep
    steps = [msgspec.json.decode(msgspec.json.encode(line), type=kind) for line in lines]
    return GridRecords(steps, [record for record in kept.records if isinstance(record, Message)]).arrays(folder)
