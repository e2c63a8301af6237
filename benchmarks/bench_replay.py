"""Replays: the film of 20 agents over 200 steps, whole command, and how long pictures take."""

from __future__ import annotations

import contextlib
import io
import os
import time

from measuring import at_most, cost_of_command, print_table, print_title, run_sweep, scratch

from foundry.replay.pictures import pictures
from foundry.replay.recording import read_recording
from foundry.storing.store import RunFolder

AGENTS, STEPS, TARGET_S = 20, 200, 20.0
PICTURES = 20


def per_picture(run: RunFolder) -> float:
    """Return the milliseconds that a picture takes in one process, after the first one."""
    recording = read_recording(run)
    steps = list(range(min(PICTURES, recording.last + 1)))
    list(pictures([recording], steps[:1], workers=1))
    started = time.perf_counter()
    count = len(list(pictures([recording], steps, workers=1)))
    return 1000 * (time.perf_counter() - started) / count


def main() -> None:
    print_title(
        "Replay", f"The film is `foundry replay RUN --video run.mp4`, from start-up to exit, {os.cpu_count()} cores."
    )
    with scratch() as folder, contextlib.redirect_stderr(io.StringIO()):
        grid = ("world=cafe_library", "model=scripted/random", f"world.agents={AGENTS}", f"world.steps={STEPS}")
        camera = ("world=kibo", "model=scripted/wander", f"world.steps={PICTURES}")
        (flat,) = run_sweep(folder / "grid", *grid, "runner.workers=1").folder.runs()
        (deep,) = run_sweep(folder / "camera", *camera, "runner.workers=1").folder.runs()
        film = cost_of_command("replay", str(flat.path), "--video", str(folder / "run.mp4"))
        rows = [
            [
                f"film of {AGENTS} agents and {STEPS} steps",
                f"{film.wall_s:.1f} s",
                *at_most(film.wall_s, TARGET_S, "s"),
            ],
            ["CPU time of that", f"{film.cpu_s:.1f} s", "", ""],
            ["its size", f"{(folder / 'run.mp4').stat().st_size / 1e6:.2f} MB", "", ""],
            ["a 2D picture, one process", f"{per_picture(flat):.0f} ms", "", ""],
            ["a 3D overview with its inset, one process", f"{per_picture(deep):.0f} ms", "", ""],
        ]
    print_table(["replay", "measured", "target", ""], rows)


if __name__ == "__main__":
    main()
