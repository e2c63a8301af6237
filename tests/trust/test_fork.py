"""A recorded run answers again: replayed alone, forked into many models, and compared with another run."""

import math
import shutil
from pathlib import Path

import msgspec
import pytest

from commands import foundry, records, refusal, statuses, succeeds
from foundry.storing.store import calls_bytes
from foundry.trust.comparing import compare
from ollama_server import OllamaServer
from trust.conftest import MIX, SMALL, play, run_of, runs

QUIET = ("analyze=false", "runner.workers=1", "output.dir=out")


def lines_before(content: bytes, step: int) -> list[bytes]:
    return [line for line in content.splitlines() if msgspec.json.decode(line)["step"] < step]


@pytest.mark.slow
def test_a_fork_shares_the_past_and_pays_only_for_the_rest(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, MIX)
    with OllamaServer() as server:
        models = "model=llama3.2,scripted/random"
        command = ("fork", str(origin.path), "--at", "3", "-m", models, "sampling_seed=0-1", *QUIET)
        succeeds(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
        assert sum(server.answered.values()) == 2 * 2 * 4 * 2
        before = records(tmp_path / "out")
        for run in runs(tmp_path / "out"):
            shutil.rmtree(run.path)
        succeeds("resume", "out", cwd=tmp_path)
        assert sum(server.answered.values()) == 2 * 2 * 4 * 2
    forks = runs(tmp_path / "out")
    assert len({run.id for run in forks}) == 4 and records(tmp_path / "out") == before
    for run in forks:
        assert lines_before(run.steps_bytes(), 3) == lines_before(origin.steps_bytes(), 3)
        assert [c.text for c in run.calls() if c.step < 3] == [c.text for c in origin.calls() if c.step < 3]
        assert {c.model for c in run.calls() if c.step >= 3} == {run.config()["model"]["name"]}
        summary = run.summary()
        assert summary.origin is not None
        assert (summary.origin.sweep, summary.origin.run, summary.origin.at) == ("out", origin.id, 3)
    succeeds("verify", "out", "--workers", "1", cwd=tmp_path)


@pytest.mark.slow
def test_a_fork_of_a_fork_keeps_every_wording(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, MIX, 1)
    first = ("fork", str(origin.path), "--at", "2", "model=scripted/random", "prompt=paraphrase", "sampling_seed=7")
    succeeds(*first, "analyze=false", "output.dir=first", cwd=tmp_path)
    (middle,) = runs(tmp_path / "first")
    second = ("fork", str(middle.path), "--at", "4", "model=scripted/stay", "prompt=paper", "world.steps=5")
    succeeds(*second, *QUIET, cwd=tmp_path)
    (last,) = runs(tmp_path / "out")
    assert [part["before"] for part in last.config()["fork"]["past"]] == [2, 4]
    assert lines_before(last.steps_bytes(), 4) == lines_before(middle.steps_bytes(), 4)
    assert lines_before(last.steps_bytes(), 2) == lines_before(origin.steps_bytes(), 2)
    done = succeeds("verify", "out", "--workers", "1", cwd=tmp_path)
    assert "20 lines" not in done.stderr, done.stdout


@pytest.mark.slow
def test_a_fire_that_begins_later_leaves_the_past_valid(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, MIX)
    fire = "world.fires=[{name: late, start: %s, position: [0, 0], intensity: 1.0, radius: 100}]"
    base = ("fork", str(origin.path), "--at", "3", "model=scripted/avoid")
    succeeds(*base, fire % 3, *QUIET, cwd=tmp_path)
    assert b'"fires":["late"]' in runs(tmp_path / "out")[0].steps_bytes()
    refused = refusal(*base, fire % 2, "analyze=false", "output.dir=other", cwd=tmp_path)
    assert "change steps before the fork: at step 2" in refused


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("--at", "9"), "has 4 steps, so use a step from 2 to 5"),
        (("--at", "1"), "use a step from 2 to 5"),
        (("--at", "5"), "the fork would end after 4 steps. Raise world.steps"),
        (("--at", "3", "seed=4"), "keeps the seed of its run"),
        (("--at", "3", "world.agents=5"), "agents.jsonl has 4 lines"),
        (("--at", "3", "world.half_size=20"), "change steps before the fork: at step 1"),
        (("--at", "3", "modl=x"), "Did you mean 'model'"),
    ],
)
def test_what_cannot_be_continued_is_refused(
    overrides: tuple[str, ...], expected: str, grid_sweep: Path, tmp_path: Path
):
    assert expected in refusal("fork", str(run_of(grid_sweep, MIX).path), *overrides, cwd=tmp_path)
    assert not (tmp_path / "outputs").exists()


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
    assert f"It has: {MIX}, qwen3:4b" in refusal(f"model=replay/{grid_sweep}", *SMALL, cwd=tmp_path)
    assert "Did you mean 'qwen3:4b'?" in refusal(f"model=replay/{grid_sweep}", "model.of=qwen3:4", *SMALL, cwd=tmp_path)
    assert "have the seed 9: it has 0, 1" in refusal(
        f"model=replay/{grid_sweep}@qwen3:4b", "seed=9", *SMALL, cwd=tmp_path
    )
    assert "Folder 'nowhere' does not exist" in refusal("model=replay/nowhere", *SMALL, cwd=tmp_path)


def test_a_question_that_was_not_asked_ends_the_run_and_is_named(grid_sweep: Path, tmp_path: Path):
    longer = (f"model=replay/{grid_sweep}@qwen3:4b", *SMALL, "world.steps=5", "output.dir=out")
    done = foundry(*longer, cwd=tmp_path)
    assert done.returncode == 3
    assert "no answer to the message question of agent 0 at step 5" in done.stdout
    assert "no run asked this question" in done.stdout
    other = (f"model=replay/{grid_sweep}@qwen3:4b", *SMALL, "prompt=paraphrase", "output.dir=other")
    done = foundry(*other, cwd=tmp_path)
    assert done.returncode == 3 and statuses(tmp_path / "other") == ["failed"]
    assert f"run {run_of(grid_sweep, 'qwen3:4b').id} asked this question with another prompt" in done.stdout


def test_a_question_with_two_answers_is_refused_unless_a_run_is_named(grid_sweep: Path, copied: Path, tmp_path: Path):
    first, second = run_of(copied, "qwen3:4b"), run_of(copied, MIX)
    text = (copied / "sweep.yaml").read_text()
    (copied / "sweep.yaml").write_text(text.replace(MIX, "qwen3:4b"))
    calls = list(first.calls())
    forged = [msgspec.structs.replace(calls[0], text="something else"), *calls[1:]]
    (second.path / "calls.jsonl.zst").write_bytes(calls_bytes(forged))
    done = foundry(f"model=replay/{copied}", *SMALL, "output.dir=a", cwd=tmp_path)
    assert done.returncode == 3 and "has different answers to" in done.stdout
    succeeds(f"model=replay/{copied}", f"model.of={first.id}", *SMALL, "output.dir=b", cwd=tmp_path)
    assert runs(tmp_path / "b")[0].steps_bytes() == first.steps_bytes()


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
    done = succeeds("diff", one, other, cwd=grid_sweep)
    lines = done.stdout.splitlines()
    place = lines.index("first differing state: steps.jsonl line 1 (step 1, agent 0, state): x")
    assert [line.split(": ")[0] for line in lines[place + 1 : place + 3]] == ["  first run", "  second run"]
    assert "mean distance" in done.stdout
    finished = msgspec.json.decode(foundry("diff", one, other, "--json", cwd=grid_sweep).stdout)
    assert finished["state"]["field"] == "x" and len(finished["drift"]) == 4 and finished["drift"][0]["turned"] is None


@pytest.mark.slow
def test_poses_are_compared_in_3d(camera_sweep: Path, grid_sweep: Path):
    (run,) = runs(camera_sweep)
    parting = compare(run, run)
    assert [(row.distance, row.turned) for row in parting.drift] == [(0.0, 0.0)] * 3
    assert "their forms are 'camera' and 'grid'" in refusal(
        "diff", str(run.path), str(run_of(grid_sweep, MIX).path), cwd=camera_sweep
    )
    assert "contains 4 runs. Name one" in refusal("diff", str(grid_sweep), str(run.path), cwd=camera_sweep)
