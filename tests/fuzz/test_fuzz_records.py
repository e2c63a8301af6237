"""A recorded file that was torn, spoiled or written by someone else is read, or refused in one line."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from analysis.load import load, read_records, read_run
from commands import foundry
from foundry.errors import FoundryError
from foundry.storing.store import RunFolder, SweepFolder
from spoiling import settle, spoiled

FEW, MANY = 60, 10_000
"""Spoiled files of each sweep, in the normal suite and in the slow tests."""
FILES = ("steps.jsonl", "messages.jsonl", "run.json", "calls.jsonl.zst", "sweep.yaml", "episode.jsonl")
SMALL = ("analyze=false", "output.dir=out", "runner.workers=1")


def played(folder: Path, *overrides: str) -> Path:
    """Run three steps; returns the sweep."""
    done = foundry(*overrides, "world.steps=3", *SMALL, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.fixture(scope="module")
def grid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return played(tmp_path_factory.mktemp("grid"), "model=scripted/echo", "world.agents=4")


@pytest.fixture(scope="module")
def camera(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return played(tmp_path_factory.mktemp("camera"), "world=office", "model=scripted/wander")


def fuzz(sweep: Path, copy: Path, number: int) -> tuple[int, int]:
    """Spoil one file after the other; returns how many were read all the same, and how many were refused."""
    shutil.copytree(sweep, copy)
    (run,) = SweepFolder.open(copy).runs()
    files = [file for file in (copy / "sweep.yaml", *(run.path / name for name in FILES)) if file.exists()]
    whole = {file: file.read_bytes() for file in {*files, run.path / "run.json"}}
    rng, refused = np.random.default_rng(3), 0
    for turn in range(number):
        file = files[turn % len(files)]
        file.write_bytes(spoiled(whole[file], rng))
        if file.suffix == ".jsonl":
            settle(run)
        try:
            read(copy)
        except FoundryError as error:
            refused += 1
            assert str(error)
        for changed in (file, run.path / "run.json"):
            changed.write_bytes(whole[changed])
    return number - refused, refused


def read(sweep: Path) -> None:
    """Read everything of a sweep as the analysis does."""
    load(sweep)
    for run in SweepFolder.open(sweep).runs():
        assert sum(1 for _ in run.calls()) >= 0
        summary = run.summary()
        if summary is not None and summary.status == "complete":
            read_run(run, read_records(run, summary))
        half_written(run)


def half_written(run: RunFolder) -> None:
    """Read a run as if it had not ended."""
    read_records(run, None)


@pytest.mark.parametrize("kind", ["grid", pytest.param("camera", marks=pytest.mark.slow)])
def test_spoiled_records_are_read_or_refused(kind: str, request: pytest.FixtureRequest, tmp_path: Path):
    read_all_the_same, refused = fuzz(request.getfixturevalue(kind), tmp_path / "copy", FEW)
    assert refused > FEW / 4 and read_all_the_same > 0


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("kind", ["grid", "camera"])
def test_spoiled_records_are_read_or_refused_at_length(kind: str, request: pytest.FixtureRequest, tmp_path: Path):
    read_all_the_same, refused = fuzz(request.getfixturevalue(kind), tmp_path / "copy", MANY)
    sys.stdout.write(
        f"\n{kind}: {MANY:,} spoiled files, {refused:,} refused, {read_all_the_same:,} read all the same\n"
    )
