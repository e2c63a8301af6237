"""Two runs side by side: where they part, and how far."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import pytest

from commands import foundry
from foundry.trust.comparing import compare
from trust.conftest import MIX, run_of, runs


def test_the_drift_is_what_the_records_say_and_a_run_does_not_differ_from_itself(grid_sweep: Path):
    one, other = run_of(grid_sweep, "qwen3:4b"), run_of(grid_sweep, MIX)
    parting = compare(one, other)
    steps = [[msgspec.json.decode(line) for line in run.steps_bytes().splitlines()] for run in (one, other)]
    for row in parting.drift:
        pairs = [pair for pair in zip(*steps, strict=True) if pair[0]["step"] == row.step]
        moved = [math.hypot(a["x_next"] - b["x_next"], a["y_next"] - b["y_next"]) for a, b in pairs]
        assert row.distance == pytest.approx(sum(moved) / 4)
        assert row.elsewhere == sum(map(bool, moved)) / 4
        assert row.acted == sum((a["action"], a["direction"]) != (b["action"], b["direction"]) for a, b in pairs) / 4
    herd = next(m for m in other.summary().members if m.model == "scripted/herd")  # type: ignore[union-attr]
    assert parting.answer is not None and parting.answer.place == (1, min(herd.agents), "message")
    assert parting.drift[-1].acted > 0
    run = run_of(grid_sweep, MIX)
    parting = compare(run, run)
    assert (parting.question, parting.answer, parting.state) == (None, None, None)
    assert [(row.step, row.agents, row.elsewhere, row.acted, row.distance) for row in parting.drift] == [
        (step, 4, 0.0, 0.0, 0.0) for step in (1, 2, 3, 4)
    ]


def test_the_command_prints_a_table_or_json(grid_sweep: Path):
    one, other = (str(run_of(grid_sweep, "qwen3:4b", seed).path) for seed in (0, 1))
    done = foundry("diff", one, other, cwd=grid_sweep)
    assert done.returncode == 0 and "first other state: steps.jsonl line 1 (step 1, agent 0, state): x: " in done.stdout
    assert "mean distance" in done.stdout
    found = msgspec.json.decode(foundry("diff", one, other, "--json", cwd=grid_sweep).stdout)
    assert found["state"]["field"] == "x" and len(found["drift"]) == 4 and found["drift"][0]["turned"] is None


@pytest.mark.slow
def test_poses_are_compared_in_3d(camera_sweep: Path, grid_sweep: Path):
    (run,) = runs(camera_sweep)
    parting = compare(run, run)
    assert [(row.distance, row.turned) for row in parting.drift] == [(0.0, 0.0)] * 3
    done = foundry("diff", str(run.path), str(run_of(grid_sweep, MIX).path), cwd=camera_sweep)
    assert done.returncode == 2 and "one is of form 'camera', the other of 'grid'" in done.stderr
    done = foundry("diff", str(grid_sweep), str(run.path), cwd=camera_sweep)
    assert done.returncode == 2 and "holds 4 runs: name one" in done.stderr
