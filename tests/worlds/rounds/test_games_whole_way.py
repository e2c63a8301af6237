"""Shipped games go the whole way: played, measured, compared with their baselines, reported."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from analysis import analyze
from analysis.report import write_report
from commands import statuses
from foundry.cli import run
from foundry.commands.analyzing import run_baselines
from foundry.storing.store import SweepFolder


def test_games_are_swept_measured_and_reported_beside_their_baselines(workspace: Path):
    worlds = "world=bar,public_goods_punishment"
    asked = ("-m", worlds, "model=scripted/coin,scripted/conditional", "seed=0-1", "world.steps=4", "analyze=false")
    assert run([*asked, "output.dir=mixed-up"]) == 2, "a policy of one game does not play the other"
    assert run(["-m", *asked[1:2], "model=scripted/random", *asked[3:], "output.dir=s"]) == 0
    assert run_baselines(Path("s")) == 0
    beside = SweepFolder.open(SweepFolder.open("s").baselines_dir)
    assert statuses(beside.path) == ["complete"] * 8
    runs = analyze([Path("s")], plots=False).runs
    riders = runs[runs["model"] == "scripted/free_rider"]
    assert riders["public_goods.score"].tolist() == [100, 100] and riders["bar.score"].isna().all()
    assert (runs[runs["model"] == "scripted/always_go"]["bar.share"] == 1).all()
    assert pd.notna(runs["public_goods.antisocial"]).any()
    page = write_report([Path("s")]).path.read_text(encoding="utf-8")
    assert "Tokens that are kept" in page and "Nearness of the attendance" in page
