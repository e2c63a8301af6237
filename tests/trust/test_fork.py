"""One moment before many models: the past is shared to the byte, and only what follows is paid for."""

from __future__ import annotations

import shutil
from pathlib import Path

import msgspec
import pytest

from commands import foundry, records, statuses
from ollama_server import OllamaServer
from trust.conftest import MIX, run_of, runs

QUIET = ("analyze=false", "runner.workers=1", "output.dir=out")


def lines_before(content: bytes, step: int) -> list[bytes]:
    return [line for line in content.splitlines() if msgspec.json.decode(line)["step"] < step]


@pytest.mark.slow
def test_a_fork_shares_the_past_and_pays_only_for_the_rest(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, MIX)
    with OllamaServer() as server:
        models = "model=llama3.2,scripted/random"
        command = ("fork", str(origin.path), "--at", "3", "-m", models, "sampling_seed=0-1", *QUIET)
        done = foundry(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
        assert done.returncode == 0, done.stdout + done.stderr
        assert sum(server.answered.values()) == 2 * 2 * 4 * 2
        before = records(tmp_path / "out")
        for run in runs(tmp_path / "out"):
            shutil.rmtree(run.path)
        done = foundry("resume", "out", cwd=tmp_path)
        assert done.returncode == 0 and sum(server.answered.values()) == 2 * 2 * 4 * 2
    forks = runs(tmp_path / "out")
    assert len({run.id for run in forks}) == 4 and records(tmp_path / "out") == before
    for run in forks:
        assert lines_before(run.steps_bytes(), 3) == lines_before(origin.steps_bytes(), 3)
        assert [c.text for c in run.calls() if c.step < 3] == [c.text for c in origin.calls() if c.step < 3]
        assert {c.model for c in run.calls() if c.step >= 3} == {run.config()["model"]["name"]}
        summary = run.summary()
        assert summary is not None and summary.origin is not None
        assert (summary.origin.sweep, summary.origin.run, summary.origin.at) == ("out", origin.id, 3)
    assert foundry("verify", "out", "--workers", "1", cwd=tmp_path).returncode == 0


@pytest.mark.slow
def test_a_fork_of_a_fork_keeps_every_wording(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, MIX, 1)
    first = ("fork", str(origin.path), "--at", "2", "model=scripted/random", "prompt=paraphrase", "sampling_seed=7")
    assert foundry(*first, "analyze=false", "output.dir=first", cwd=tmp_path).returncode == 0
    (middle,) = runs(tmp_path / "first")
    second = ("fork", str(middle.path), "--at", "4", "model=scripted/stay", "prompt=paper", "world.steps=5")
    assert foundry(*second, *QUIET, cwd=tmp_path).returncode == 0
    (last,) = runs(tmp_path / "out")
    assert [part["before"] for part in last.config()["fork"]["past"]] == [2, 4]
    assert lines_before(last.steps_bytes(), 4) == lines_before(middle.steps_bytes(), 4)
    assert lines_before(last.steps_bytes(), 2) == lines_before(origin.steps_bytes(), 2)
    done = foundry("verify", "out", "--workers", "1", cwd=tmp_path)
    assert done.returncode == 0 and "20 lines" not in done.stderr, done.stdout


@pytest.mark.slow
def test_a_fire_that_begins_later_leaves_the_past_valid(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, MIX)
    fire = "world.fires=[{name: late, start: %s, position: [0, 0], intensity: 1.0, radius: 100}]"
    base = ("fork", str(origin.path), "--at", "3", "model=scripted/avoid")
    assert foundry(*base, fire % 3, *QUIET, cwd=tmp_path).returncode == 0
    assert b'"fires":["late"]' in runs(tmp_path / "out")[0].steps_bytes()
    done = foundry(*base, fire % 2, "analyze=false", "output.dir=other", cwd=tmp_path)
    assert done.returncode == 2 and "change the past, at step 2" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("--at", "9"), "has 4 steps, so give a step from 2 to 5"),
        (("--at", "1"), "give a step from 2 to 5"),
        (("--at", "5"), "the episode ends after 4 steps: raise world.steps"),
        (("--at", "3", "seed=4"), "keeps the seed of its run"),
        (("--at", "3", "world.agents=5"), "agents.jsonl has 4 lines"),
        (("--at", "3", "world.half_size=20"), "change the past, at step 1"),
        (("--at", "3", "modl=x"), "Did you mean 'model'"),
        pytest.param(
            ("--at", "3", "world=gallery"), "These overrides change the past, at step 1", marks=pytest.mark.exhaustive
        ),
    ],
)
def test_what_cannot_be_continued_is_refused(
    overrides: tuple[str, ...], expected: str, grid_sweep: Path, tmp_path: Path
):
    done = foundry("fork", str(run_of(grid_sweep, MIX).path), *overrides, cwd=tmp_path)
    assert done.returncode == 2 and expected in done.stderr, done.stderr
    assert not (tmp_path / "outputs").exists()


@pytest.mark.exhaustive
def test_a_3d_run_is_continued_by_another_model(camera_sweep: Path, tmp_path: Path):
    (origin,) = runs(camera_sweep)
    done = foundry("fork", str(origin.path), "--at", "2", "model=scripted/spin", *QUIET, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    (run,) = runs(tmp_path / "out")
    assert statuses(tmp_path / "out") == ["complete"]
    assert lines_before(run.steps_bytes(), 2) == lines_before(origin.steps_bytes(), 2)
    assert foundry("verify", "out", "--workers", "1", cwd=tmp_path).returncode == 0
