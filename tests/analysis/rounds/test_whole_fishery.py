"""The fishery the whole way: a sweep, its tables, its report, its verification."""

from __future__ import annotations

from pathlib import Path

import pytest

import foundry as public
from commands import foundry

ASKED = (
    "world=fishery", "model=scripted/greedy_catch,scripted/sustainable", "seed=0-1", "world.steps=3", "world.talk=2",
    "output.dir=lake", "cache.path=a.sqlite", "analyze=false",
)  # fmt: skip


def test_a_sweep_of_the_fishery_ends_in_its_tables(workspace: Path):
    swept = public.sweep(*ASKED)
    assert (swept.complete, swept.failed) == (4, ())
    table = public.analyze(swept.path, plots=False).runs.groupby("model").mean(numeric_only=True)
    assert table.loc["scripted/greedy_catch", ["fishery.months", "fishery.gain"]].tolist() == [1, 20]
    assert table.loc["scripted/sustainable", ["fishery.months", "fishery.gain"]].tolist() == [3, 30]
    months = public.load(swept.path).streams["stock"]
    assert months["caught"].tolist() == [100, 100, *[50] * 6]


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_it_is_reported_and_verified(workspace: Path):
    public.sweep(*ASKED)
    public.analyze("lake")
    assert foundry("report", "lake", cwd=workspace).returncode == 0
    page = (workspace / "lake" / "report.html").read_text(encoding="utf-8")
    assert "catch (mean)" in page and "Catches beyond the sustainable share" in page
    verified = foundry("verify", "lake", "--workers", "1", cwd=workspace)
    assert "4 identical" in verified.stdout, verified.stderr
