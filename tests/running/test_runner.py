"""Workers die, runs fail; the others go on."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import foundry, statuses
from foundry.composing.compose import compose
from foundry.composing.preflight import check, declare
from foundry.expansion import Sweep, expand
from foundry.running.lane import Lane, LaneSpec
from foundry.running.local import PlayPhase, Runner, SweepJob
from foundry.storing.standing import failures
from foundry.storing.store import RunFolder, SweepFolder
from ollama_server import OllamaServer

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


@pytest.mark.slow
def test_a_run_that_kills_its_worker_every_time_is_given_up_and_the_others_complete(own_parts: Path):
    ended = sweep(own_parts, "deadly", workers=2)
    assert 0 < ended.count("failed") < 8 and ended.count("failed") + ended.count("complete") == 8
    summaries = [run.summary() for run in SweepFolder.open(own_parts / "out").runs()]
    causes = {one.error for one in summaries if one and one.status == "failed"}
    assert all(cause and "died 2 times while it had only this run open" in cause for cause in causes)


@pytest.mark.slow
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


def declared(*asked: str) -> Sweep:
    composed = compose(("-m", *asked))
    assert composed is not None
    return declare(expand(composed.asked, composed.conditions))


def test_runs_that_were_open_when_a_worker_died_are_played_again_one_at_a_time(workspace: Path):
    opened: list[int] = []
    with OllamaServer(on_chat=lambda *call: opened.append(len(folder.progress()["0-0"]["open"]))) as server:
        sweep = declared(
            "model=qwen3:4b", "seed=0-2", "world.agents=2", "world.steps=2", f"model.server.hosts={server.url}"
        )
        folder = SweepFolder.create(workspace / "out", sweep, {}, [])
        folder.start_progress("0")
        suspects = tuple(run.id for run in folder.runs())
        spec = LaneSpec("0-0", "0", folder, (), check(sweep), cache="answers.sqlite", suspects=suspects, open_runs=3)
        assert Lane(spec).run() is None
    assert statuses(folder.path) == ["complete"] * 3 and set(opened) == {1}


def test_the_runs_that_may_take_the_most_calls_begin_first_and_equal_ones_in_their_order(tmp_path: Path):
    begun: list[RunFolder] = []

    class Noting(Runner):
        @contextlib.contextmanager
        def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
            yield lambda runs, number: begun.extend(runs)

    sweep = declared("model=scripted/stay", "world.steps=3,9,6", "world.agents=2,6", "seed=0-1")
    folder = SweepFolder.create(tmp_path / "out", sweep, {}, [])
    Noting(1).run(SweepJob(folder, {}, "", 0))
    shapes = {run.id: run.config()["world"] for run in folder.runs()}
    most = sorted(folder.runs(), key=lambda run: -shapes[run.id]["steps"] * shapes[run.id]["agents"])
    assert [run.id for run in begun] == [run.id for run in most]
