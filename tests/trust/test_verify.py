"""Verification finds every change, says where it is, and needs no server."""

import hashlib
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec.structs import replace

from commands import foundry, succeeds
from foundry.records import Call
from foundry.storing.store import RunFolder, calls_bytes
from foundry.worlds.camera.eye.rendering import Renderer
from trust.conftest import MIX, play, run_of, runs


def edited(path: Path, pattern: str, replacement: str) -> None:
    text = path.read_text(encoding="utf-8")
    changed = re.sub(pattern, replacement, text, count=1)
    assert changed != text
    path.write_text(changed, encoding="utf-8")


def editing(pattern: str, replacement: str, file: str = "run.json") -> Callable[[RunFolder], None]:
    return lambda run: edited(run.path / file, pattern, replacement)


def recalling(change: Callable[[list[Call]], list[Call]]) -> Callable[[RunFolder], object]:
    return lambda run: (run.path / "calls.jsonl.zst").write_bytes(calls_bytes(change(list(run.calls()))))


forge_status = editing('"status": "complete"', '"status": "failed"')
drop_digests = editing(r'"records_sha256": \{[^}]*\}', '"records_sha256": {}')


def spoil_prompt(run: RunFolder) -> None:
    calls = list(run.calls())
    calls[5].messages[0]["content"] += "!"
    (run.path / "calls.jsonl.zst").write_bytes(calls_bytes(calls))


def add_line(run: RunFolder) -> None:
    path = run.path / "steps.jsonl"
    path.write_bytes(path.read_bytes() + path.read_bytes().splitlines(keepends=True)[-1])


def damage_summary(run: RunFolder) -> None:
    (run.path / "run.json").write_text("{")


def test_untouched_records_are_identical_whatever_process_looks(grid_sweep: Path):
    done = succeeds("verify", str(grid_sweep), "--workers", "2", cwd=grid_sweep)
    assert "4 runs: 4 identical" in done.stdout and "128 questions compared" in done.stdout
    again = foundry("verify", grid_sweep.name, "--workers", "2", cwd=grid_sweep.parent)
    assert "4 runs: 4 identical" in again.stdout, "by the processes that are there already, which are elsewhere"


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [
        (
            editing(r'"y":(-?\d+)', '"y":99', "steps.jsonl"),
            "steps.jsonl line 1 (step 1, agent 0, record): y: recorded 99",
        ),
        (
            recalling(lambda calls: [replace(call, text="no") if call.step == 2 else call for call in calls]),
            "(step 2, agent ",
        ),
        (spoil_prompt, "line 6 (step 1, agent 1, action): messages[0].content"),
        (
            recalling(lambda calls: [replace(calls[0], digest="another"), *calls[1:]]),
            "line 1 (step 1, agent 0, message): key",
        ),
        (recalling(lambda calls: calls[:-1]), "(step 4, agent 3, action): recorded 'nothing'"),
        (add_line, "steps.jsonl line 17"),
        (editing(r'"messages.jsonl": "....', '"messages.jsonl": "0000'), "run.json: records_sha256.messages.jsonl"),
        (
            recalling(lambda calls: [calls[0], replace(calls[0], text="no"), *calls[1:]]),
            "number of calls: recorded 33, now 32",
        ),
        (
            recalling(lambda calls: [replace(calls[0], text="no"), *calls]),
            "steps.jsonl line 1 (step 1, agent 0, record): ",
        ),
        (editing('"form": "grid"', '"form": "rounds"'), "run.json: form: recorded 'rounds', now 'grid'"),
        (editing(r'"seed": 0', '"seed": 7'), "run.json: seed: recorded 7, now 0"),
        (editing(r'"prompt_tokens": (\d)', r'"prompt_tokens": 1\1'), "run.json: counts.prompt_tokens: recorded 1"),
        (forge_status, "run.json: status: recorded 'failed', now 'complete'"),
        (
            editing('"model": "qwen3:4b"', '"model": "scripted/herd"'),
            "run.json: members[0]: recorded 'scripted/herd', now 'qwen3:4b'",
        ),
        (drop_digests, "run.json: records_sha256.steps.jsonl: recorded 'nothing'"),
        (damage_summary, "run.json: recorded 'damaged"),
        (recalling(lambda calls: [{"step": 1}]), "calls.jsonl.zst: recorded 'damaged"),  # type: ignore[list-item]
        (editing("agents: 4", "agents: 5", "config.yaml"), "config.yaml: world.agents: recorded 5, now 4"),
    ],
)
def test_a_change_is_found_where_it_is(spoil: Callable[[RunFolder], None], expected: str, copied: Path):
    run = run_of(copied, MIX)
    spoil(run)
    done = foundry("verify", str(run.path), "--workers", "1", cwd=copied)
    assert done.returncode == 3, done.stderr
    assert f"{run.id} differs: " in done.stdout and expected in done.stdout, done.stdout


def test_a_run_that_failed_or_was_killed_is_verified_as_far_as_it_goes(copied: Path):
    failed, killed, *_ = runs(copied)
    calls = [call for call in failed.calls() if call.step < 3]
    (failed.path / "calls.jsonl.zst").write_bytes(calls_bytes(calls))
    steps = failed.steps_bytes().splitlines(keepends=True)
    (failed.path / "steps.jsonl").write_bytes(b"".join(steps[:8]))
    (failed.path / "messages.jsonl").write_bytes(b"")
    edited(failed.path / "run.json", r'"records_sha256": \{[^}]*\}', '"records_sha256": {}')
    edited(failed.path / "run.json", '"status": "complete"', '"status": "failed"')
    (killed.path / "run.json").unlink()
    with (killed.path / "steps.jsonl").open("ab") as file:
        file.truncate(len(killed.steps_bytes()) - 5)
    done = foundry("verify", str(copied), "--workers", "1", cwd=copied)
    assert "failed after 2 steps" in done.stdout, done.stdout
    assert "has not ended: its records reach" in done.stdout, done.stdout
    assert "4 runs: 3 identical, 1 not ended; " in done.stdout, done.stdout
    assert done.returncode == 0


@pytest.mark.slow
def test_a_3d_run_with_its_images_and_frames_is_verified(camera_sweep: Path, tmp_path: Path):
    succeeds("verify", str(camera_sweep), "--frames", "--workers", "1", cwd=tmp_path)
    copy = Path(shutil.copytree(camera_sweep, tmp_path / "copy"))
    image = runs(copy)[0].path / "images" / "step_0002.png"
    image.write_bytes(image.read_bytes() + b"\0")
    done = foundry("verify", str(copy), "--workers", "1", cwd=tmp_path)
    assert done.returncode == 3 and "images/step_0002.png: SHA-256" in done.stdout


@pytest.mark.slow
def test_a_3d_run_that_another_renderer_drew_is_told_from_one_that_was_changed(
    camera_sweep: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    copy = Path(shutil.copytree(camera_sweep, tmp_path / "copy"))
    (run,), view = runs(copy), Renderer.view
    before = hashlib.sha256(run.episode_bytes()).hexdigest()
    edited(run.path / "episode.jsonl", '"renderer":"', '"renderer":"another ')
    edited(run.path / "run.json", before, hashlib.sha256(run.episode_bytes()).hexdigest())

    def verified(change: int) -> str:
        monkeypatch.setattr(Renderer, "view", lambda *asked: view(*asked) ^ change)
        done = foundry("verify", str(copy), "--workers", "1", cwd=tmp_path)
        assert done.returncode == (0 if "1 identical" in done.stdout else 3), done.stdout
        return done.stdout

    same = verified(0)
    assert "1 identical" in same and "was drawn by another " in same and " draws the same pixels" in same
    close = verified(1)
    assert "1 run: 1 drawn by another renderer" in close and "the first picture shows the same content" in close
    assert "1 run: 1 differs" in verified(4), "the picture is beyond the tolerance"
    shutil.rmtree(run.path / "images")
    assert "no picture was recorded, so nobody can tell whether the content is the same" in verified(4)
    edited(run.path / "steps.jsonl", '"visible_px":{', '"visible_px":{"ghost":1,')
    assert "1 differs" in verified(0), "what was changed is found beside it"


def test_a_worker_that_died_at_the_very_end_left_a_run_that_failed(tmp_path: Path):
    sweep = play(tmp_path, "model=scripted/random", "world.agents=2", "world.steps=1", "analyze=false")
    (run,) = runs(sweep)
    forge_status(run)
    drop_digests(run)
    edited(run.path / "run.json", '"error": null', '"error": "out of luck"')
    assert "failed after 1 steps: out of luck" in succeeds("verify", str(sweep), cwd=tmp_path).stdout


def read_otherwise(run: RunFolder, pattern: str, replacement: str) -> None:
    """Change a record, its digest and what `run.json` says of the readers, as if others had recorded it."""
    path = run.path / "steps.jsonl"
    before = hashlib.sha256(path.read_bytes()).hexdigest()
    edited(path, '"outcome":"chosen"', '"outcome":"unreadable"')
    edited(run.path / "run.json", before, hashlib.sha256(path.read_bytes()).hexdigest())
    edited(run.path / "run.json", pattern, replacement)


@pytest.mark.parametrize(
    ("pattern", "replacement", "said"),
    [
        (r'"readers": \d+', '"readers": 1', "was recorded with readers 1 of foundry"),
        (r'"json-repair": "[^"]*"', '"json-repair": "0.1"', "was recorded with json-repair 0.1 ("),
    ],
)
def test_a_run_that_other_readers_recorded_is_told_from_one_that_was_changed(pattern, replacement, said, copied: Path):
    run = run_of(copied, MIX)
    read_otherwise(run, pattern, replacement)
    done = foundry("verify", str(run.path), "--workers", "1", cwd=copied)
    assert done.returncode == 3, done.stderr
    assert said in done.stdout and "outcome: recorded 'unreadable', now 'chosen'" in done.stdout
    assert "1 run: 1 recorded with other readers" in done.stdout and "differs" not in done.stdout
    with (run.path / "messages.jsonl").open("ab") as file:
        file.write(b"\n")
    done = foundry("verify", str(run.path), "--workers", "1", cwd=copied)
    assert "1 run: 1 differs" in done.stdout, done.stdout


def test_a_run_of_older_readers_that_is_read_as_it_was_is_identical(copied: Path):
    run = run_of(copied, MIX)
    run.stream_path("agents").unlink()
    edited(run.path / "run.json", r',?\s*"agents.jsonl": "\w+"', "")
    done = foundry("verify", str(run.path), "--workers", "1", cwd=copied)
    assert done.returncode == 3 and "agents.jsonl" in done.stdout, done.stdout
    edited(run.path / "run.json", r',\s*"readers": \d+', "")
    done = succeeds("verify", str(run.path), "--workers", "1", cwd=copied)
    assert "1 identical" in done.stdout, done.stdout
