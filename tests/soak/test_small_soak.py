"""A small sweep through a server that fails in every way; `test_soak.py` is the large one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from commands import calls, foundry, records
from disturbed import Disturbed, endings
from faulty_server import TRANSIENT, FaultyServer, Shares

SWEEP = (
    *("-m", "model=qwen3:4b", "seed=0-11", "world.agents=2", "world.steps=3", "output.dir=sweep", "analyze=false"),
    *("model.server.retry.wait_initial_s=0.01", "model.server.retry.wait_max_s=0.02", "runner.workers=1"),
    *("model.server.read_timeout_s=10.0", "model.server.retry.attempts=8"),
)
DECIDED = Shares(decided=0.1, refused=0.02)


@pytest.mark.slow
def test_a_sweep_through_every_fault_and_a_kill_is_the_undisturbed_one(tmp_path: Path):
    quiet, rough = tmp_path / "quiet", tmp_path / "rough"
    quiet.mkdir()
    rough.mkdir()
    with FaultyServer(DECIDED) as server:
        done = foundry(*SWEEP, cwd=quiet, OLLAMA_HOST=server.url)
        assert done.returncode == 3 and "refused" in done.stdout + done.stderr
    with FaultyServer(DECIDED, each_once=True) as server:
        work = Disturbed(server, rough / "sweep", rough / "outputs" / "answers.sqlite", np.random.default_rng(0))
        with work.session(*SWEEP) as process:
            work.after(60, process)
            work.kill(process)
        assert foundry("resume", "sweep", cwd=rough, OLLAMA_HOST=server.url).returncode == 3
    assert {name: server.books.faults[name] for name in TRANSIENT} == dict.fromkeys(TRANSIENT, 1)
    assert work.asked_again() == []
    assert work.paid_again() == {}
    assert {status for status, _ in endings(quiet / "sweep").values()} == {"complete", "failed"}
    for read in (endings, records, calls):
        assert read(rough / "sweep") == read(quiet / "sweep")
