"""A form that stands outside the package goes the whole way, by the commands alone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from commands import foundry, statuses
from foundry.storing.store import SweepFolder
from outside_form import Outside

TRUST = ("--trust-targets", "ring_world")


def records(sweep: Path) -> dict[str, bytes]:
    """Return all record files of a sweep by their paths in it."""
    return {str(file.relative_to(sweep)): file.read_bytes() for file in sorted(sweep.glob("runs/*/*.jsonl"))}


@pytest.fixture
def sweep(outside: Outside, tmp_path: Path) -> Path:
    """The same sweep, free to be changed."""
    return Path(shutil.copytree(outside.sweep, tmp_path / "ring"))


def test_it_is_verified_compared_continued_bundled_measured_shown_and_drawn(outside: Outside, sweep: Path):
    runs = [str(run.path) for run in SweepFolder.open(sweep).runs()]
    outside.foundry("status", str(sweep))
    assert "4 identical" in outside.foundry("verify", str(sweep), "--workers", "1", *TRUST)
    assert "step" in foundry("diff", runs[0], runs[2], "--config-dir", "mine", cwd=outside.cwd).stdout
    forked = str(sweep.parent / "forked")
    outside.foundry("fork", runs[0], "--at", "2", "model=other", f"output.dir={forked}", "analyze=false", *TRUST)
    assert "1 identical" in outside.foundry("verify", forked, "--workers", "1", *TRUST)
    outside.foundry("bundle", str(sweep), str(sweep.parent / "b.tar.zst"))
    assert foundry("unbundle", "b.tar.zst", "bundled", cwd=sweep.parent).returncode == 0
    assert records(sweep.parent / "bundled") == records(sweep) != {}
    outside.foundry("report", str(sweep))
    assert "ring" in (sweep / "report.html").read_text(encoding="utf-8")
    assert (sweep / "analysis" / "sources.csv").is_file()
    outside.foundry("view", str(sweep), "--export", str(sweep.parent / "page"))
    assert (sweep.parent / "page" / "index.html").is_file()
    outside.foundry("replay", runs[0], "--steps", "1", *TRUST)
    assert list(sweep.glob("analysis/replay/*/*.png"))


def test_a_run_that_was_lost_is_played_again_to_the_same_records(outside: Outside, sweep: Path):
    kept = records(sweep)
    shutil.rmtree(SweepFolder.open(sweep).runs()[0].path)
    outside.foundry("resume", str(sweep), *TRUST)
    assert statuses(sweep) == ["complete"] * 4
    assert records(sweep) == kept and any(path.endswith("laps.jsonl") for path in kept)
