"""Runs are found by their folders, and read as far as they are whole."""

import dataclasses
import shutil
from pathlib import Path

import msgspec
import pytest

from foundry.commands.replay import chosen_steps
from foundry.errors import InputError, RecordError
from foundry.replay.pictures import pictures
from foundry.replay.recording import Recording, read_recording
from foundry.storing.store import RunFolder, find_run


@pytest.fixture
def copied(grid_runs: list[RunFolder], tmp_path: Path) -> Path:
    """The folder of a run in a copy of its sweep, to be damaged."""
    sweep = grid_runs[0].path.parent.parent
    shutil.copytree(sweep, tmp_path / "copy")
    return tmp_path / "copy" / "runs" / grid_runs[0].id


def test_a_run_is_found_by_its_folder_or_answered_with_the_closest_one(grid_runs: list[RunFolder], tmp_path: Path):
    assert find_run(grid_runs[1].path).id == grid_runs[1].id
    with pytest.raises(InputError, match=f"Run 'x{grid_runs[1].id}' not found. Did you mean '{grid_runs[1].id}'"):
        find_run(grid_runs[1].path.with_name("x" + grid_runs[1].id))
    with pytest.raises(InputError, match=f"contains {len(grid_runs)} runs. Name one, such as .*{grid_runs[0].id}"):
        find_run(grid_runs[0].path.parent.parent)
    with pytest.raises(InputError, match="is not a sweep's folder"):
        find_run(tmp_path)
    with pytest.raises(InputError, match="does not exist"):
        find_run(tmp_path / "nowhere" / "runs" / "one")


def test_a_run_that_was_cut_is_read_up_to_its_last_whole_step(copied: Path):
    steps = copied / "steps.jsonl"
    lines = steps.read_bytes().splitlines(keepends=True)
    (copied / "run.json").unlink()
    steps.write_bytes(b"".join(lines[:14]) + lines[14][:20])  # of six agents: two steps, two agents and a half
    recording = read_recording(find_run(copied))
    assert (recording.last, recording.note) == (2, "unfinished: recorded up to step 2")
    assert recording.steps == b"".join(lines[:12])


def test_a_failed_run_says_where_and_why_it_ended(copied: Path):
    summary = (copied / "run.json").read_text(encoding="utf-8")
    failed = summary.replace('"status": "complete"', '"status": "failed"').replace('"error": null', '"error": "gone"')
    (copied / "run.json").write_text(failed, encoding="utf-8")
    assert read_recording(find_run(copied)).note == "failed after step 6: gone"


def test_a_run_without_steps_shows_its_initial_state(copied: Path):
    first = (copied / "frames" / "step_0000.png").read_bytes()
    (copied / "steps.jsonl").write_bytes(b"")
    recording = read_recording(find_run(copied))
    (drawn,) = pictures([recording], [0], workers=1)
    assert (recording.last, drawn.png) == (0, first)


def test_damaged_steps_are_named_and_a_run_that_never_started_cannot_be_shown(copied: Path):
    (copied / "steps.jsonl").write_bytes(b"{nonsense}\n")
    with pytest.raises(RecordError, match="The steps of '.*' cannot be read"):
        read_recording(find_run(copied))
    shutil.rmtree(copied)
    with pytest.raises(InputError, match="has not been started yet"):
        read_recording(find_run(copied))


@pytest.mark.slow
def test_a_run_in_a_scene_that_changed_is_refused(camera_runs: list[RunFolder]):
    recording = read_recording(camera_runs[0])
    digest = recording.episode.split(b'"scene_sha256":"')[1][:64]
    changed = dataclasses.replace(recording, episode=recording.episode.replace(digest, b"0" * 64))
    with pytest.raises(InputError, match="is not the scene of the run"):
        list(pictures([changed], [0], workers=1))


def retargeted(recording: Recording, part: str, target: str) -> Recording:
    config = msgspec.json.decode(recording.config)
    config[part]["_target_"] = target
    return dataclasses.replace(recording, config=msgspec.json.encode(config))


def test_only_the_world_of_a_record_is_built(grid_runs: list[RunFolder]):
    recording = read_recording(grid_runs[0])
    assert list(pictures([retargeted(recording, "model", "elsewhere.Model")], [0], workers=1))
    with pytest.raises(InputError, match="world: the recorded target 'os.system' is refused"):
        list(pictures([retargeted(recording, "world", "os.system")], [0], workers=1))


@pytest.mark.parametrize(
    ("text", "every", "steps"),
    [(None, None, [0, 1, 2, 3, 4, 5, 6]), ("0,5,2-4", None, [0, 2, 3, 4, 5]), (" 6 , 6", None, [6]), (None, 4, [0, 4])],
)
def test_steps_are_chosen(text: str | None, every: int | None, steps: list[int]):
    assert chosen_steps(text, every, 6) == steps


@pytest.mark.parametrize(
    ("text", "every", "said"),
    [
        ("7", None, "there is no step 7; the records end with step 6"),
        ("5-2", None, "the range '5-2' begins after its end. Write 2-5."),
        ("1,two", None, "'two' is neither a step nor a range"),
        ("", None, "neither a step"),
        (None, 0, "--every 0"),
        ("1", 2, "exclude each other"),
    ],
)
def test_wrong_steps_are_refused(text: str | None, every: int | None, said: str):
    with pytest.raises(InputError, match=said):
        chosen_steps(text, every, 6)
