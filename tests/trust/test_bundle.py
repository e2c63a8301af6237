"""A bundle holds all that is needed, says nothing of the machine, and has the same bytes every time."""

import io
import shutil
import tarfile
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import zstandard

from commands import foundry, records, refusal, statuses, succeeds
from foundry.errors import InputError
from foundry.storing.store import SweepFolder, calls_bytes
from foundry.trust.bundling import write_bundle
from foundry.trust.manifest import Manifest
from foundry.trust.unbundling import unpack_bundle
from foundry.worlds.camera import surroundings
from trust.conftest import build_wall, play_in_a_room, rewrite, run_of, runs
from worlds.camera.usd_files import mesh, picture, write_stage


def members(bundle: Path) -> dict[str, bytes]:
    content = zstandard.ZstdDecompressor().decompressobj().decompress(bundle.read_bytes())
    with tarfile.open(fileobj=io.BytesIO(content)) as archive:
        return {getmember.name: archive.extractfile(getmember).read() for getmember in archive.getmembers()}  # type: ignore[union-attr]


@pytest.fixture(scope="module")
def bundled(grid_sweep: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bundled") / "grid.tar.zst"
    write_bundle(grid_sweep, path)
    return path


def test_the_same_sweep_gives_the_same_bytes_which_say_nothing_of_the_machine(
    grid_sweep: Path, bundled: Path, tmp_path: Path
):
    moved = shutil.copytree(grid_sweep, tmp_path / "elsewhere" / grid_sweep.name)
    write_bundle(Path(moved), tmp_path / "again.tar.zst")
    assert (tmp_path / "again.tar.zst").read_bytes() == bundled.read_bytes()
    found = members(bundled)
    for name, content in found.items():
        text = zstandard.ZstdDecompressor().decompressobj().decompress(content) if name.endswith(".zst") else content
        for private in (str(grid_sweep.parent), str(Path.home()) + "/", "127.0.0.1:"):
            assert private.encode() not in text, name
    manifest = msgspec.json.decode(found.pop("manifest.json"), type=Manifest)
    assert [file.path for file in manifest.files] == sorted(found)
    assert "CITATION.cff" in found and "sweep.yaml" in found


def test_runs_of_a_bundle_have_the_same_records_and_verify(grid_sweep: Path, bundled: Path, tmp_path: Path):
    done = succeeds("unbundle", str(bundled), "anew", cwd=tmp_path)
    assert "4 runs" in done.stdout, done.stderr
    assert records(tmp_path / "anew") == records(grid_sweep)
    assert [run.summary() for run in runs(tmp_path / "anew")] == [run.summary() for run in runs(grid_sweep)]
    assert "4 identical" in succeeds("verify", "anew", "--workers", "1", cwd=tmp_path).stdout
    gone, cut, *_ = runs(tmp_path / "anew")
    shutil.rmtree(gone.path)
    (cut.path / "run.json").unlink()
    verified = foundry("verify", "anew", "--workers", "1", cwd=tmp_path)
    assert verified.returncode == 3 and "2 identical, 2 missing" in verified.stdout
    assert f"{gone.id} is missing: manifest.json says that it has ended" in verified.stdout


def test_a_bundle_does_not_repeat_what_the_command_line_said_of_the_machine(copied: Path, tmp_path: Path):
    private = ["model.server.hosts=http://gpu", "+model.of.server.read_timeout_s=9", "++output.dir=/data/x",
               "model.server={hosts: http://gpu}", "~cache.path", "hydra.job.name=x", "--config-dir=mine"]  # fmt: skip
    asked = ["-m", "model=qwen3:4b", "world.server_room=1", "model.serving=fast"]
    rewrite(copied, lambda content: content.update(asked=[*asked, *private]))
    rewrite(copied, lambda content: content["history"][0].update(asked=[*private, *asked]))
    write_bundle(copied, tmp_path / "out.tar.zst")
    unpack_bundle(tmp_path / "out.tar.zst", tmp_path / "anew")
    before, sweep = SweepFolder.open(copied).sweep, SweepFolder.open(tmp_path / "anew").sweep
    assert [entry.when for entry in sweep.history] == [entry.when for entry in before.history]
    assert [sweep.asked, *(entry.overrides for entry in sweep.history)] == [tuple(asked)] * 2


def test_a_secret_of_the_environment_is_never_bundled(copied: Path, tmp_path: Path):
    run = run_of(copied, "qwen3:4b")
    first, *others = run.calls()
    leaking = msgspec.structs.replace(first, text="my key is sk-abcdef123456")
    (run.path / "calls.jsonl.zst").write_bytes(calls_bytes([leaking, *others]))
    line = refusal("bundle", str(copied), "out.tar.zst", cwd=tmp_path, SOME_API_KEY="sk-abcdef123456")
    assert "holds the value of SOME_API_KEY" in line
    assert "sk-abcdef" not in line and list(tmp_path.glob("*.zst*")) == []


@pytest.mark.slow
def test_a_3d_bundle_brings_its_scene_in_which_the_sweep_grows_until_the_scene_changes(tmp_path: Path):
    write_bundle(play_in_a_room(tmp_path / "theirs"), tmp_path / "room.tar.zst")
    manifest = unpack_bundle(tmp_path / "room.tar.zst", tmp_path / "anew")
    shutil.rmtree(tmp_path / "theirs")
    surroundings._surroundings.cache_clear()  # as in another process
    scenes = [Path(file.path).name for file in manifest.files if file.path.startswith("scenes/")]
    assert sorted(scenes) == ["scene.usda", "wall.png", "wall.usda"]
    (run,) = runs(tmp_path / "anew")
    assert {msgspec.json.decode(line)["scene"] for line in run.episode_bytes().splitlines()} == {"scene"}
    shutil.rmtree(run.path)
    done = succeeds("resume", "anew", "model=scripted/stay", "runner.workers=1", cwd=tmp_path)
    assert statuses(tmp_path / "anew") == ["complete"] * 2, done.stdout + done.stderr
    write_bundle(tmp_path / "anew", tmp_path / "second.tar.zst")
    unpack_bundle(tmp_path / "second.tar.zst", tmp_path / "third")
    done = succeeds("verify", "third", "--frames", "--workers", "1", cwd=tmp_path)
    scene = next((tmp_path / "third").glob("scenes/*/room/scene.usda"))
    scene.write_text(f"{scene.read_text()}\n# another file\n")
    surroundings._surroundings.cache_clear()
    shutil.rmtree(runs(tmp_path / "third")[0].path)
    for command in (("resume", "third", "seed=1"), ("resume", "third")):
        assert "is not the scene of the run" in refusal(*command, cwd=tmp_path)


@pytest.mark.slow
def test_a_file_that_a_scene_may_not_read_is_not_bundled(tmp_path: Path):
    for name in ("secret.png", "room/wall.png"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        picture(tmp_path / name, np.arange(48).reshape(4, 4, 3) * 5)
    scene = write_stage(tmp_path / "room" / "scene.usda", build_wall_on_a_floor)
    scene.write_text(scene.read_text() + 'def "x" {\nasset secret = @../secret.png@\n}\n')
    run = ("world=usd", f"scene={scene}", "task=Look", "world.steps=1", "model=scripted/stay")
    succeeds(*run, "output.dir=out", "analyze=false", cwd=tmp_path)
    write_bundle(tmp_path / "out", tmp_path / "room.tar.zst")
    files = {Path(file.path).name for file in unpack_bundle(tmp_path / "room.tar.zst", tmp_path / "anew").files}
    assert {"scene.usda", "wall.png"} <= files and "secret.png" not in files


def build_wall_on_a_floor(stage: Any) -> None:
    build_wall(stage)
    mesh(stage, "/Floor", ((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)))


@pytest.mark.slow
def test_a_bundled_sweep_with_forks_and_baselines_is_whole(grid_sweep: Path, tmp_path: Path):
    origin = run_of(grid_sweep, "qwen3:4b")
    options = ("--at", "3", "model=scripted/stay", "analyze=false", "output.dir=fork", "runner.workers=1")
    succeeds("fork", str(origin.path), *options, cwd=tmp_path)
    fork = SweepFolder.open(tmp_path / "fork")
    shutil.copytree(grid_sweep, fork.baselines_dir)
    write_bundle(fork.path, tmp_path / "fork.tar.zst")
    unpack_bundle(tmp_path / "fork.tar.zst", tmp_path / "anew")
    for sweep in ("anew", "anew/baselines"):
        succeeds("verify", sweep, "--workers", "1", cwd=tmp_path)
    (run,) = runs(tmp_path / "anew")
    shutil.rmtree(run.path)
    succeeds("resume", "anew", cwd=tmp_path)
    assert run.steps_bytes() == runs(fork.path)[0].steps_bytes()


def test_the_folder_of_a_bundle_is_made_and_nothing_is_written_over_or_where_it_cannot_be(
    grid_sweep: Path, tmp_path: Path
):
    write_bundle(grid_sweep, tmp_path / "new" / "out.tar.zst")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written to"):
        write_bundle(grid_sweep, tmp_path / "file" / "out.tar.zst")
    with pytest.raises(InputError, match="cannot be written to"):
        unpack_bundle(tmp_path / "new" / "out.tar.zst", tmp_path / "file" / "deep" / "anew")
    assert "Use 'x.tar.zst'" in refusal("bundle", str(grid_sweep), "x.zip", cwd=tmp_path)
    assert not (tmp_path / "x.zip").exists(), "the file would be no zip"
    (tmp_path / "x.tar.zst").write_bytes(b"mine")
    assert (
        "exists" in refusal("bundle", str(grid_sweep), "x.tar.zst", cwd=tmp_path)
        and (tmp_path / "x.tar.zst").read_bytes() == b"mine"
    )
