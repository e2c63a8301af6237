"""The fishery the whole way: a sweep, its tables, its report, its verification."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from commands import foundry


def test_a_sweep_of_the_fishery_ends_in_its_tables_and_its_report(workspace: Path):
    policies = "model=scripted/greedy_catch,scripted/sustainable"
    asked = ("-m", "world=fishery", policies, "seed=0-1", "world.steps=3", "output.dir=lake", "cache.path=a.sqlite")
    swept = foundry(*asked, cwd=workspace)
    assert swept.returncode == 0 and "4 of 4 runs complete in lake" in swept.stdout, swept.stderr
    table = pd.read_csv(workspace / "lake" / "analysis" / "signatures.csv").groupby("model").mean(numeric_only=True)
    assert table.loc["scripted/greedy_catch", ["fishery.months", "fishery.gain"]].tolist() == [1, 20]
    assert table.loc["scripted/sustainable", ["fishery.months", "fishery.gain"]].tolist() == [3, 30]
    assert foundry("report", "lake", cwd=workspace).returncode == 0
    page = (workspace / "lake" / "report.html").read_text(encoding="utf-8")
    assert "catch (mean)" in page and "Catches beyond the sustainable share" in page
    verified = foundry("verify", "lake", "--workers", "1", cwd=workspace)
    assert "4 identical" in verified.stdout, verified.stderr
