"""The snippets of docs/publish.md run on the tables of a sweep."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import foundry
from foundry import paths

pytestmark = pytest.mark.exports
TEXT = (paths.PACKAGE.parent / "docs" / "publish.md").read_text(encoding="utf-8")


def snippets(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an analysed sweep where the snippets look for it."""
    folder = tmp_path_factory.mktemp("place")
    small = ("world.agents=3", "world.steps=2", "seed=0-1", "runner.workers=1")
    where = (f"output.dir={folder}/outputs/pilot", f"cache.path={folder}/answers.sqlite")
    foundry.analyze(foundry.sweep("model=scripted/random,scripted/stay", *small, *where).path, plots=False)
    return folder


@pytest.mark.parametrize("code", snippets("python"), ids=["parquet", "load"])
def test_pandas_and_polars_read_the_tables(code: str, place: Path):
    pytest.importorskip("polars", reason="pip install polars")
    read = "print(stays.sort('model')['action'].to_list())" if "stays" in code else "print(len(contrasts), len(idle))"
    done = subprocess.run(
        [sys.executable, "-c", code + read], cwd=place, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(paths.PACKAGE.parent)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    stays = done.stdout.strip()
    assert stays.endswith(", 1.0]") if "stays" in code else stays.endswith(" 4")


def test_r_reads_the_tables(place: Path):
    r = shutil.which("Rscript") or pytest.skip("needs R: apt-get install r-base-core r-cran-reticulate")
    (code,) = snippets("r")
    environment = {**os.environ, "RETICULATE_PYTHON": sys.executable}
    done = subprocess.run([r, "-e", code], cwd=place, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(re.findall(r"scripted-stay-s[01]\S+\s+1", done.stdout)) == 2
