"""Hydra's basic launcher, which starts its jobs in the command's own process; the others are in tests/cluster."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from commands import SMALL, calls, foundry, records, statuses

SWEEP = ("-m", "model=scripted/random", "seed=0-1", *SMALL)


@pytest.mark.slow
def test_a_job_for_each_run_records_what_the_plain_command_does_once_and_leaves_ctrl_c_alone(tmp_path: Path):
    before = signal.getsignal(signal.SIGINT)
    assert foundry(*SWEEP, "output.dir=plain", "runner.workers=1", cwd=tmp_path).returncode == 0
    done = foundry(*SWEEP, "output.dir=launched", "hydra/launcher=basic", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert statuses(tmp_path / "launched") == ["complete"] * 2
    assert records(tmp_path / "launched") == records(tmp_path / "plain")
    assert calls(tmp_path / "launched") == calls(tmp_path / "plain")
    assert signal.getsignal(signal.SIGINT) == before
    ended = [(file, file.stat().st_mtime_ns) for file in sorted(tmp_path.rglob("run.json"))]
    assert foundry(*SWEEP, "output.dir=launched", "hydra/launcher=basic", cwd=tmp_path).returncode == 0
    assert [(file, file.stat().st_mtime_ns) for file, _ in ended] == ended
