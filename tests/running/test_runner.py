"""Workers die, runs fail; the others go on."""

from __future__ import annotations

from pathlib import Path

import pytest

from commands import foundry, statuses
from foundry.storing.standing import failures
from foundry.storing.store import SweepFolder

PARTS = Path(__file__).parents[1] / "parts"
PROMPT = "_target_: foundry.prompts.prompt.Prompt\nname: terse\ntemplates: {message: 'Say?', action: 'Act?'}\n"
WORLD = "defaults: [cafe_library, _self_]\nname: fate\nagents: 1\nsteps: 2\n"


@pytest.fixture
def own_parts(workspace: Path) -> Path:
    """A folder with a model that dies, one with a bug, and a world where one agent in four is doomed."""
    for group in ("model", "world", "prompt"):
        (workspace / "mine" / group).mkdir(parents=True)
    (workspace / "mine" / "prompt" / "terse.yaml").write_text(PROMPT)
    (workspace / "mine" / "world" / "fate.yaml").write_text(WORLD)
    for name in ("Deadly", "Faulty"):
        text = f"_target_: policies.{name}\nname: {name}\n"
        (workspace / "mine" / "model" / f"{name.lower()}.yaml").write_text(text)
    return workspace


def sweep(own_parts: Path, model: str, workers: int) -> list[str | None]:
    """Run eight seeds with two fates; returns how the runs ended."""
    done = foundry(
        "-m", "--config-dir", "mine", f"model={model}", "world=fate", "prompt=terse", "seed=0-7", "output.dir=out",
        "++world.personas={fate: {doomed: 1, blessed: 3}}", f"runner.workers={workers}", "analyze=false",
        cwd=own_parts, PYTHONPATH=str(PARTS),
    )  # fmt: skip
    assert done.returncode == 3, done.stdout + done.stderr
    return statuses(own_parts / "out")


def test_a_run_that_kills_its_worker_every_time_is_given_up_and_the_others_complete(own_parts: Path):
    ended = sweep(own_parts, "deadly", workers=2)
    assert 0 < ended.count("failed") < 8 and ended.count("failed") + ended.count("complete") == 8
    summaries = [run.summary() for run in SweepFolder.open(own_parts / "out").runs()]
    causes = {one.error for one in summaries if one and one.status == "failed"}
    assert all(cause and "worker process died" in cause for cause in causes)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_bug_fails_its_run_with_its_traceback_and_the_others_complete(workers: int, own_parts: Path):
    ended = sweep(own_parts, "faulty", workers)
    assert 0 < ended.count("failed") < 8 and ended.count("failed") + ended.count("complete") == 8
    summaries = [run.summary() for run in SweepFolder.open(own_parts / "out").runs()]
    failed = next(one for one in summaries if one and one.status == "failed")
    assert (failed.error, failed.error_type) == ("a bug", "ZeroDivisionError")
    assert failed.traceback and "policies.py" in failed.traceback
    summaries = [run.summary() for run in SweepFolder.open(own_parts / "out").runs()]
    assert {one.error for one in failures(summaries)} == {"ZeroDivisionError: a bug"}
