"""The wheel carries everything and works from any directory."""

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from foundry import paths

CLONE = paths.PACKAGE.parent


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the clone and unpacked as pip would, without the clone on the path."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(CLONE)]
    done = subprocess.run(build, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run_installed(installed: Path, cwd: Path, code: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_the_wheel_holds_configs_sweeps_and_plugins_and_uses_its_own(installed: Path, tmp_path: Path):
    for name in (
        "foundry/conf/config.yaml",
        "foundry/conf/model/scripted/random.yaml",
        "foundry/sweeps/first.yaml",
        "hydra_plugins/foundry_plugins/sources.py",
        "analysis/__init__.py",
        "analysis/py.typed",
        "foundry/py.typed",
        "foundry/new_parts/world/world/part_name.yaml",
        "foundry/new_parts/world/try_it.txt",
    ):
        assert (installed / name).is_file(), name
    assert not (installed / "tests").exists()
    code = "from foundry import paths; print(paths.conf_dir()); print(paths.sweeps_dir())"
    folders = run_installed(installed, tmp_path, code).split()
    assert folders == [str(installed / "foundry" / "conf"), str(installed / "foundry" / "sweeps")]


@pytest.mark.slow
def test_the_wheel_runs_the_main_job_in_any_directory_and_loads_nothing_that_draws_scenes(
    installed: Path, tmp_path: Path
):
    code = """
import sys
import analysis
import analysis.figures.pictures
from foundry.cli import run
models = "model=scripted/random,scripted/flaky"
assert run(["+sweep=first", models, "seed=0", "world.steps=2", "output.dir=out", "analyze=false"]) == 0
analysis.analyze("out", plots=False)
print("loaded", sorted({name.partition(".")[0] for name in sys.modules} & {"pxr", "pyvista", "vtk", "vtkmodules"}))
"""
    said = run_installed(installed, tmp_path, code)
    assert "2 of 2 runs complete in out" in said and said.splitlines()[-1] == "loaded []"


@pytest.mark.slow
def test_the_wheel_has_a_name_of_its_own_and_extras_are_asked_of_that_name(installed: Path):
    (metadata,) = installed.glob("*.dist-info/METADATA")
    assert "\nName: foundry-worlds\n" in metadata.read_text(encoding="utf-8")
    files = [path for folder in ("foundry", "docs", "conf") for path in (CLONE / folder).rglob("*.*")]
    advice = [path.read_text(encoding="utf-8") for path in files if path.suffix in (".py", ".md", ".yaml")]
    asked = re.findall(r"pip install '?([\w-]+)\[", "".join(advice))
    assert len(asked) > 5 and set(asked) == {"foundry-worlds"}
