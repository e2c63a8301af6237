"""Names that lead elsewhere, configurations that grow or run code: one clear line, and no file outside the folder."""

import os
from pathlib import Path

import pytest

from commands import foundry, refusal, statuses, succeeds
from foundry.errors import InputError, StorageError
from foundry.storing.run_writer import RunWriter
from foundry.storing.store import SweepFolder, ensure_writable

SMALL = ("model=scripted/random", "world.agents=2", "world.steps=2", "output.dir=out", "runner.workers=1")
LAUGHS = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12)
)
NAMES = ["../../evil", "..\\..\\evil", "/etc/evil", "con", "aux.txt", "x" * 240, ".", "[/red]", "$HOME", "`id`", "é日"]


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


@pytest.mark.slow
@pytest.mark.parametrize("analyze", ["false", pytest.param("true", marks=pytest.mark.exhaustive)])
def test_names_of_parts_lead_nowhere(analyze: str, tmp_path: Path):
    names = ",".join(f"'{name}'".replace("\\", "\\\\") for name in NAMES)
    inner = tmp_path / "deep" / "inner"
    inner.mkdir(parents=True)
    parts = (f"model.name={names}", "world.name='../../w'", "prompt.name='../p'")
    succeeds("-m", *SMALL, *parts, f"analyze={analyze}", cwd=inner)
    assert "[/red]" in foundry("status", "out", cwd=inner).stdout
    assert all(file.startswith("deep/inner/out/") for file in files(tmp_path))
    assert statuses(inner / "out") == ["complete"] * len(NAMES)


@pytest.mark.parametrize("name", ["x" * 5000, "\x1b[2Jred", "a\u202eb", "two\nlines"])
def test_a_name_that_cannot_be_shown_is_refused(name: str, tmp_path: Path):
    line = refusal(*SMALL, f'model.name="{name}"', cwd=tmp_path)
    assert "model.name=" in line and len(line) < 200
    assert "\x1b" not in line


@pytest.mark.parametrize("name", ["x" * 300, "file/below", "/dev/null/out", "/proc/out", "a\0b"])
def test_a_folder_that_cannot_be_is_one_line(name: str, tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError) as caught:
        ensure_writable(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert files(tmp_path) == {"file"}


def test_a_recorded_run_is_not_written_elsewhere(tmp_path: Path):
    succeeds(*SMALL, "analyze=false", cwd=tmp_path)
    file = tmp_path / "out" / "sweep.yaml"
    (known,) = SweepFolder.open(tmp_path / "out").runs()
    text, before = file.read_text(), files(tmp_path)
    for run in ("../../../evil", "/etc/evil", "", "a\0b", "x" * 400):
        written = "".join(f"\\u{ord(one):04x}" for one in run)
        file.write_text(text.replace(f'"id":"{known.id}"', f'"id":"{written}"'))
        assert "is not a valid id of a run" in refusal("resume", "out", cwd=tmp_path)
        assert files(tmp_path) == before


def test_a_run_that_is_a_link_is_refused_and_what_it_leads_to_is_kept(tmp_path: Path):
    succeeds(*SMALL, "analyze=false", cwd=tmp_path)
    (run,) = SweepFolder.open(tmp_path / "out").runs()
    elsewhere = tmp_path / "elsewhere"
    (elsewhere / "frames").mkdir(parents=True)
    os.rename(run.path, tmp_path / "moved")
    run.path.symlink_to(elsewhere)
    with pytest.raises(StorageError, match="is a link"):
        RunWriter(run, "")
    assert [path.name for path in elsewhere.iterdir()] == ["frames"]


def test_a_bomb_in_a_folder_of_configurations_is_refused_before_it_grows(tmp_path: Path):
    (tmp_path / "mine" / "model").mkdir(parents=True)
    (tmp_path / "mine" / "model" / "bomb.yaml").write_text(LAUGHS)
    line = refusal("--config-dir", "mine", "model=bomb", cwd=tmp_path)
    assert "bomb.yaml" in line and "more than" in line
    assert not (tmp_path / "outputs").exists()


def test_a_file_that_includes_itself_by_way_of_another_is_refused_in_one_line(tmp_path: Path):
    (tmp_path / "mine" / "model").mkdir(parents=True)
    (tmp_path / "mine" / "model" / "here.yaml").write_text("defaults: [there]\n")
    (tmp_path / "mine" / "model" / "there.yaml").write_text("defaults: [here]\n")
    done = foundry("--config-dir", "mine", "model=here", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1) and "includes itself" in done.stderr


@pytest.mark.parametrize(
    "part", ["world", *(pytest.param(one, marks=pytest.mark.exhaustive) for one in ("model", "prompt", "runner"))]
)
def test_nothing_that_a_record_names_is_run(part: str, tmp_path: Path):
    succeeds(*SMALL, "analyze=false", cwd=tmp_path)
    file, canary = tmp_path / "out" / "sweep.yaml", tmp_path / "canary"
    (run,) = SweepFolder.open(tmp_path / "out").runs()
    own = {"runner": "foundry.running.local.LocalRunner"}.get(part) or run.config()[part]["_target_"]
    text = file.read_text()
    assert f"_target_: {own}\n" in text
    file.write_text(text.replace(f"_target_: {own}\n", "_target_: pathlib.Path.touch\n").replace(own, "os.system"))
    (run.path / "run.json").unlink()
    where = str(run.path)
    for command in (("verify", "out"), ("status", "out"), ("replay", where), ("fork", where, "--at", "1")):
        done = foundry(*command, cwd=tmp_path)
        assert "Traceback" not in done.stderr
        builds_it = command[0] != "status" and part != "runner" and (command[0] != "replay" or part == "world")
        assert done.returncode == 2 or not builds_it
    assert foundry("resume", "out", cwd=tmp_path).returncode == 2
    assert not canary.exists() and not run.ended
