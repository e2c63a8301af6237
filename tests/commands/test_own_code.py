"""A user's own code is found beside `--config-dir` and in the working directory, and never stands before ours."""

import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from commands import environment, foundry, refusal, succeeds
from foundry import own_code, paths
from foundry.commands.application import app

SMALL = ("world.agents=3", "world.steps=2", "runner.workers=1", "analyze=false")
POLICY = """
from foundry.worlds.any.any_policies import Stay


class Quiet(Stay):
    pass
"""


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    folder = tmp_path / "mine"
    for part in ("model", "world", "signatures"):
        (folder / part).mkdir(parents=True)
    (folder / "quiet_policy.py").write_text(POLICY)
    (folder / "model" / "quiet.yaml").write_text("_target_: quiet_policy.Quiet\nname: quiet\n")
    return folder


def test_code_beside_config_dir_runs_without_pythonpath_and_a_sweeps_folder_is_named_alike_everywhere(
    mine: Path, tmp_path: Path
):
    own, into, asked = ("--config-dir", "mine"), "output.dir=out", ("model=quiet", *SMALL)
    succeeds(*own, *asked, into, cwd=tmp_path)
    (run,) = (tmp_path / "out" / "runs").iterdir()
    for command in (("status", into), ("verify", into), ("resume", into), ("replay", str(run), "--steps", "0")):
        done = succeeds(*command, *own, cwd=tmp_path)
        assert "1" in done.stdout, (command, done.stdout + done.stderr)
    assert "1 run, 1 complete" in foundry("plan", *asked, into, *own, cwd=tmp_path).stdout


def test_every_command_takes_the_folder_of_own_parts_and_refuses_one_that_is_not_there(tmp_path: Path):
    for command in get_command(app).commands.values():  # type: ignore[attr-defined]
        assert any("--config-dir" in param.opts for param in command.params), command.name
    for argv in (("model=scripted/stay",), ("plan", "model=scripted/stay"), ("status", "out"), ("doctor",)):
        assert "nowhere" in (line := refusal(*argv, "--config-dir", "nowhere", cwd=tmp_path)), argv
    assert "--config-dir nowhere: folder not found" in line


@pytest.mark.slow
def test_modules_of_the_working_directory_are_found_after_all_others_and_never_stand_before_ours(tmp_path: Path):
    (tmp_path / "quiet_here.py").write_text(f"import analysis{POLICY}")
    for name in ("analysis", "yaml", "hydra", "msgspec"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise SystemExit('the wrong one')\n")
    asked = ("model=scripted/stay", "model._target_=quiet_here.Quiet", *SMALL)
    done = subprocess.run(
        [sys.executable, "-m", "foundry", *asked],
        cwd=tmp_path, env=environment(PYTHONPATH=str(paths.PACKAGE.parent)), capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_working_directory_goes_to_the_end_of_the_path_and_a_clone_stays_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    for first in ("", str(tmp_path)):
        monkeypatch.setattr(sys, "path", [first, "/elsewhere"])
        own_code.working_directory_last()
        assert sys.path == ["/elsewhere", str(tmp_path)]
    monkeypatch.setattr(sys, "path", ["", str(tmp_path), "/elsewhere"])
    own_code.working_directory_last()
    assert sys.path == [str(tmp_path), "/elsewhere"], "PYTHONPATH is what somebody wanted"
    monkeypatch.chdir(paths.PACKAGE.parent)
    monkeypatch.setattr(sys, "path", ["", "/elsewhere"])
    own_code.working_directory_last()
    assert sys.path == ["", "/elsewhere"]


def test_bad_files_hurt_nobody_who_does_not_use_them(mine: Path, tmp_path: Path):
    (mine / "broken.py").write_text("def broken(:\n")
    (mine / "broken_on_import.py").write_text("raise ZeroDivisionError('oh')\n")
    (mine / "model" / "broken.yaml").write_text("_target_: [unclosed\n")
    (mine / "world" / "broken.yaml").write_text("name: &a [*a]\n")
    succeeds("--config-dir", "mine", "plan", "--prompt", "model=quiet", cwd=tmp_path)


@pytest.mark.parametrize(
    ("text", "target", "named"),
    [
        ("def broken(:\n", "quiet_bad.Quiet", "quiet_bad.py"),
        ("1 / 0\n", "quiet_bad.Quiet", "quiet_bad.Quiet"),
        ("", "quiet_bad.Quiet", "quiet_bad"),
        ("", "[unclosed", "bad.yaml"),
    ],
)
def test_who_uses_a_bad_file_is_told_its_name_in_one_line(
    text: str, target: str, named: str, mine: Path, tmp_path: Path
):
    (mine / "quiet_bad.py").write_text(text)
    (mine / "model" / "bad.yaml").write_text(f"_target_: {target}\nname: bad\n")
    assert named in refusal("--config-dir", "mine", "model=bad", *SMALL, cwd=tmp_path)


@pytest.mark.parametrize(
    ("file", "shipped"),
    [
        ("world/bar.yaml", "conf/world/bar.yaml"),
        ("prompt/json.yaml", "conf/prompt/json.yaml"),
        ("model/scripted/stay.yaml", "conf/model/scripted/stay.yaml"),
        ("schema/grid.yaml", "conf/schema/grid.yaml"),
        ("format/spread.yaml", "conf/format/spread.yaml"),
        ("sweep/first.yaml", "sweeps/first.yaml"),
        ("signatures/hazard.py", "analysis/grid/signatures/hazard.py"),
        ("edits/mirror.py", "grid/grid_edits.py"),
    ],
)
def test_an_own_part_with_a_shipped_name_is_refused_with_both_files_and_a_free_name(
    file: str, shipped: str, mine: Path, tmp_path: Path
):
    own = mine / file
    own.parent.mkdir(parents=True, exist_ok=True)
    own.write_text("name: own\n")
    own.with_stem(f"{own.stem}_2").write_text("name: own\n")
    commands = ("plan", "check") if file == "world/bar.yaml" else ("plan",)
    for command in commands:
        line = refusal(command, "model=quiet", "--config-dir", "mine", cwd=tmp_path)
        assert str(own) in line and shipped in line and f"{own.stem}_3'" in line
