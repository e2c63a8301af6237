"""A sweep's folder at a URL: runs are sent when they have ended, and fetched as a whole or not at all."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from commands import SMALL, foundry, records, refusal, succeeds
from foundry.errors import FoundryError, InputError
from foundry.expansion import settings_key
from foundry.models.base import ModelInfo
from foundry.running.lane import LaneSpec
from foundry.running.remote import Chunk, RemoteRuns, RemoteSweep, fetch, part_of, play_chunk
from foundry.storing.store import SweepFolder

pytest.importorskip("fsspec", reason="needs the extra remote: pip install 'foundry-worlds[remote]'")
SWEEP = ("-m", "model=scripted/random", "seed=0-2", *SMALL, "runner.workers=1")


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    workspace = tmp_path_factory.mktemp("swept")
    succeeds(*SWEEP, "output.dir=sweep", "record.frames=4", cwd=workspace)
    return SweepFolder.open(workspace / "sweep")


@pytest.fixture
def sent(swept: SweepFolder, tmp_path: Path) -> RemoteSweep:
    remote = RemoteSweep.open((tmp_path / "bucket" / "x").as_uri())
    remote.put_sweep(swept)
    for run in swept.runs()[:-1]:
        remote.put(swept, run)
    return remote


@pytest.mark.slow
def test_what_was_sent_comes_back_the_same_and_only_what_is_missing_is_fetched_again(
    swept: SweepFolder, sent: RemoteSweep, tmp_path: Path
):
    fetched = fetch(sent.url, tmp_path / "here")
    first, second, third = swept.runs()
    assert set(fetched.runs) == sent.ended() == {first.id, second.id}
    here = {run.id: run for run in fetched.folder.runs()}
    for run in (first, second):
        names = [file.relative_to(run.path) for file in run.files()]
        assert [file.relative_to(here[run.id].path) for file in here[run.id].files()] == names
        assert all((run.path / name).read_bytes() == (here[run.id].path / name).read_bytes() for name in names)
    assert not here[third.id].ended
    sent.put(swept, third)
    assert fetch(sent.url, tmp_path / "here").runs == (third.id,)
    assert records(tmp_path / "here") == records(swept.path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["steps.jsonl", "run.json"])
def test_a_run_that_is_not_whole_is_left_out_and_named(
    name: str, swept: SweepFolder, sent: RemoteSweep, tmp_path: Path
):
    first, second = swept.runs()[:2]
    damaged = tmp_path / "bucket" / "x" / "runs" / first.id / name
    damaged.write_bytes(damaged.read_bytes()[:-20])
    fetched = fetch(sent.url, tmp_path / "here")
    assert (fetched.runs, fetched.damaged) == ((second.id,), (first.id,))
    done = foundry("status", sent.url, "--fetch", "here", cwd=tmp_path)
    assert done.returncode == 3 and first.id in done.stdout


def test_another_sweep_at_the_url_is_refused(sent: RemoteSweep, tmp_path: Path):
    other = ("-m", "model=scripted/random", "seed=7", *SMALL, "runner.workers=1", "output.dir=other")
    succeeds(*other, cwd=tmp_path)
    with pytest.raises(InputError, match="holds another sweep"):
        sent.put_sweep(SweepFolder.open(tmp_path / "other"))
    assert "holds another sweep" in refusal("status", sent.url, "--fetch", "other", cwd=tmp_path)


@pytest.mark.slow
def test_a_sweep_that_has_grown_is_sent_and_fetched_as_it_is_now(swept: SweepFolder, sent: RemoteSweep, tmp_path: Path):
    fetch(sent.url, tmp_path / "before")
    shutil.copytree(swept.path, tmp_path / "sweep")
    more = ("-m", "model=scripted/random", "seed=7", *SMALL, "record.frames=4", "output.dir=sweep")
    succeeds(*more, cwd=tmp_path)
    grown = SweepFolder.open(tmp_path / "sweep")
    sent.put_sweep(grown)
    sent.put(grown, grown.runs()[-1])
    assert fetch(sent.url, tmp_path / "before").runs == (grown.runs()[-1].id,)
    assert SweepFolder.open(tmp_path / "before").sweep.runs == grown.sweep.runs
    with pytest.raises(InputError, match="holds another sweep"):
        sent.put_sweep(swept)


@pytest.mark.parametrize("url", ["file:///nowhere/at/all", "no-such-kind://x/y"])
def test_a_url_that_holds_nothing_is_told_in_one_line(url: str, tmp_path: Path):
    assert url in refusal("status", url, "--fetch", "here", cwd=tmp_path)
    assert not (tmp_path / "here").exists()


def test_a_name_that_leads_out_of_the_folder_is_not_followed(swept: SweepFolder, tmp_path: Path):
    from fsspec.implementations.memory import MemoryFileSystem

    remote = RemoteSweep("memory://evil", MemoryFileSystem(), "/evil")
    remote.put_sweep(swept)
    run = swept.runs()[0]
    remote.put(swept, run)
    store = MemoryFileSystem.store
    key = f"/evil/runs/{run.id}/../../../outside"
    store[key] = store[f"/evil/runs/{run.id}/steps.jsonl"]
    folder = remote.fetch_sweep(tmp_path / "deep" / "here")
    assert remote.fetch(folder, folder.runs()).runs == (run.id,)
    assert not list(tmp_path.rglob("outside"))


@pytest.mark.slow
def test_a_chunk_plays_what_is_not_complete_and_sends_it(swept: SweepFolder, sent: RemoteSweep, tmp_path: Path):
    last = swept.runs()[-1]
    infos = {settings_key(last.config()["model"]): ModelInfo(name="scripted/random")}
    spec = LaneSpec("0", "0", swept, tuple(run.id for run in swept.runs()), infos, cache="")
    files = {run.id: tmp_path / "bucket" / "x" / "runs" / run.id / "run.json" for run in swept.runs()[:-1]}
    before = {run: file.stat().st_mtime_ns for run, file in files.items()}
    played = play_chunk(Chunk(spec, sent.url))
    assert (played.fatal, set(played.runs)) == (None, {run.id for run in swept.runs()})
    after = {run: file.stat().st_mtime_ns for run, file in files.items()}
    assert after == before
    fetch(sent.url, tmp_path / "here")
    assert records(tmp_path / "here") == records(swept.path)


def test_a_chunk_whose_url_cannot_be_written_to_says_so(swept: SweepFolder, tmp_path: Path):
    (tmp_path / "file").write_text("no folder")
    infos = {settings_key(swept.runs()[0].config()["model"]): ModelInfo(name="scripted/random")}
    spec = LaneSpec("0", "0", swept, (swept.runs()[0].id,), infos, cache="")
    with pytest.raises(FoundryError, match="cannot be used"):
        play_chunk(Chunk(spec, (tmp_path / "file").as_uri()))


def test_workers_of_chunks_cannot_see_each_other_and_are_told_how_many_they_are(swept: SweepFolder, tmp_path: Path):
    again = SweepFolder.create(tmp_path / "again", swept.sweep, {}, [])
    again.start_progress("0")
    ids = tuple(run.id for run in again.runs())
    runs = RemoteRuns(again, RemoteSweep.open((tmp_path / "bucket" / "y").as_uri()))
    chunks = list(runs.chunks(LaneSpec("0", "0", again, ids, {}, cache=""), 3))
    assert [chunk.spec.runs for chunk in chunks] == [(run,) for run in ids]
    assert {(chunk.spec.workers, chunk.spec.apart) for chunk in chunks} == {(3, True)}


def test_a_part_of_a_sweep_has_the_same_runs_and_configurations(swept: SweepFolder):
    condition = swept.sweep.conditions[0]
    other = replace(condition, config={**condition.config, "sampling_seed": 9})
    whole = replace(swept.sweep, conditions=(condition, other), runs=tuple(
        replace(run, condition=index % 2) for index, run in enumerate(swept.sweep.runs)
    ))  # fmt: skip
    part = part_of(whole, [whole.runs[1]])
    assert (len(part.conditions), part.runs[0].id) == (1, whole.runs[1].id)
    assert part.config(part.runs[0]) == whole.config(whole.runs[1])
