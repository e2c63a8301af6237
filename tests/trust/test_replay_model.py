"""The backend that answers from a recorded sweep only."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from commands import foundry, statuses
from foundry.storing.store import calls_bytes
from trust.conftest import MIX, SMALL, play, run_of, runs


@pytest.mark.slow
def test_a_replayed_sweep_has_the_same_records_and_names_who_answered(grid_sweep: Path, tmp_path: Path):
    for model in ("qwen3:4b", MIX):
        folder = tmp_path / model.replace("/", "-").replace(":", "-")
        folder.mkdir()
        replayed = play(folder, "-m", f"model=replay/{grid_sweep}@{model}", "seed=0-1", *SMALL)
        for run in runs(replayed):
            origin = run_of(grid_sweep, model, run.run.seed)
            assert run.steps_bytes() == origin.steps_bytes() and run.messages_bytes() == origin.messages_bytes()
            assert [(c.model, c.digest, c.key) for c in run.calls()] == [
                (c.model, c.digest, c.key) for c in origin.calls()
            ]
            assert all(call.cached for call in run.calls())


def test_several_models_need_a_choice_that_is_offered(grid_sweep: Path, tmp_path: Path):
    done = foundry(f"model=replay/{grid_sweep}", *SMALL, cwd=tmp_path)
    assert done.returncode == 2 and f"It has: {MIX}, qwen3:4b" in done.stderr
    done = foundry(f"model=replay/{grid_sweep}", "model.of=qwen3:4", *SMALL, cwd=tmp_path)
    assert done.returncode == 2 and "Did you mean 'qwen3:4b'?" in done.stderr
    done = foundry(f"model=replay/{grid_sweep}@qwen3:4b", "seed=9", *SMALL, cwd=tmp_path)
    assert done.returncode == 2 and "have the seed 9: it has 0, 1" in done.stderr
    done = foundry("model=replay/nowhere", *SMALL, cwd=tmp_path)
    assert done.returncode == 2 and "Folder 'nowhere' does not exist" in done.stderr


def test_a_question_that_was_not_asked_ends_the_run_and_is_named(grid_sweep: Path, tmp_path: Path):
    longer = (f"model=replay/{grid_sweep}@qwen3:4b", *SMALL, "world.steps=5", "output.dir=out")
    done = foundry(*longer, cwd=tmp_path)
    assert done.returncode == 3
    assert "no answer to the message question of agent 0 at step 5" in done.stdout and "was not asked" in done.stdout
    other = (f"model=replay/{grid_sweep}@qwen3:4b", *SMALL, "prompt=paraphrase", "output.dir=other")
    done = foundry(*other, cwd=tmp_path)
    assert done.returncode == 3 and statuses(tmp_path / "other") == ["failed"]
    assert f"in run {run_of(grid_sweep, 'qwen3:4b').id} it was asked in other words" in done.stdout


def test_a_question_with_two_answers_is_refused_unless_a_run_is_named(grid_sweep: Path, copied: Path, tmp_path: Path):
    first, second = run_of(copied, "qwen3:4b"), run_of(copied, MIX)
    text = (copied / "sweep.yaml").read_text()
    (copied / "sweep.yaml").write_text(text.replace(MIX, "qwen3:4b"))
    calls = list(first.calls())
    forged = [msgspec.structs.replace(calls[0], text="something else"), *calls[1:]]
    (second.path / "calls.jsonl.zst").write_bytes(calls_bytes(forged))
    done = foundry(f"model=replay/{copied}", *SMALL, "output.dir=a", cwd=tmp_path)
    assert done.returncode == 3 and "in different ways" in done.stdout
    done = foundry(f"model=replay/{copied}", f"model.of={first.id}", *SMALL, "output.dir=b", cwd=tmp_path)
    assert done.returncode == 0
    assert runs(tmp_path / "b")[0].steps_bytes() == first.steps_bytes()
