"""Writes sweeps of 3D runs whose every record is known, without any scene's file, so that the way is shown alone."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import msgspec
from PIL import Image

from declared_forms import CAMERA
from foundry.records import CameraEpisode, CameraStep, Outcome, Pose, SeenImage
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder
from made_up_runs import summary, sweep_in

WORLD = {"name": "hall", "steps": 3, "scene": None, "camera": {}, "body": {}, "targets": []}


def pose(number: int) -> Pose:
    return Pose(x=float(number), y=0.0, z=0.0, yaw=90.0, pitch=0.0)


def episode() -> CameraEpisode:
    return CameraEpisode(
        scene="hall", scene_sha256="0" * 64, renderer="none", target="door <b>", target_prims=("/Door",),
        target_label=None, radius=1.0, start=pose(0), shortest_path=[], shortest_m=None, walkable_cells=9, cell_m=0.1,
    )  # fmt: skip


def step(number: int, **changes: Any) -> CameraStep:
    fields: dict[str, Any] = {
        "step": number, "agent": 0, "pose": pose(number - 1), "pose_next": pose(number), "reply": f"I go on, {number}.",
        "command": {"translate": {"bearing": 0.0, "distance": 1.0}, "turn": None, "gaze": None, "stay": False},
        "notes": ("translate: 'go on'",), "outcome": Outcome.CHOSEN, "boundary": None, "travelled": 1.0,
        "image": f"images/step_{number:04d}.png", "image_sha256": "1" * 64, "inference_s": 0.5, "distance_before": None,
        "distance_to_goal": 2.0, "visited_cells": number, "target_visible_px": 0, "visible_px": {"wall": 10},
        "line_of_sight": False, "success": False,
    }  # fmt: skip
    return CameraStep(**(fields | changes))


def png(number: int) -> bytes:
    file = BytesIO()
    Image.new("RGB", (8, 6), (80 * number, 0, 0)).save(file, "PNG")
    return file.getvalue()


def begin(folder: RunFolder) -> RunWriter:
    writer = RunWriter(folder, msgspec.json.encode(folder.config()).decode())
    writer.append([episode()])
    return writer


def play(writer: RunWriter, number: int, **changes: Any) -> None:
    writer.append([SeenImage(path=f"images/step_{number:04d}.png", content=png(number)), step(number, **changes)])


def sweep(path: Path, models: Sequence[str] = ("first", "second")) -> SweepFolder:
    return sweep_in(path, WORLD, CAMERA, models, (0,), "paper3d")


def whole(folder: RunFolder, **changes: Any) -> None:
    writer = begin(folder)
    play(writer, 1)
    play(writer, 2, **changes)
    play(writer, 3, image=None, boundary="wall")
    writer.close()
    write_run_summary(folder, summary(folder, writer.counts, None))
