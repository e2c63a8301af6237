"""Shipped games go the whole way: played, measured beside their baselines, reported."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis import analyze
from analysis.report import write_report
from commands import statuses
from foundry.cli import run
from foundry.commands.analyzing import run_baselines
from foundry.storing.store import SweepFolder

SHORT = ("seed=0-1", "world.steps=4", "analyze=false", "output.dir=s")


def test_games_are_swept_and_measured_beside_their_baselines(workspace: Path):
    assert run(["-m", "world=public_goods_punishment", "model=scripted/random", *SHORT]) == 0
    assert run_baselines(Path("s")) == 0
    beside = SweepFolder.open(SweepFolder.open("s").baselines_dir)
    assert statuses(beside.path) == ["complete"] * 4
    runs = analyze([Path("s")], plots=False).runs
    riders = runs[runs["model"] == "scripted/free_rider"]
    assert riders["public_goods.score"].tolist() == [100, 100] and "bar.score" not in runs


def test_a_policy_of_another_game_is_refused(workspace: Path):
    assert run(["-m", "world=bar", "model=scripted/conditional", *SHORT]) == 2


@pytest.mark.slow
def test_games_are_reported_with_their_own_measures(workspace: Path):
    assert run(["-m", "world=bar,public_goods", "model=scripted/random", *SHORT]) == 0
    page = write_report([Path("s")]).path.read_text(encoding="utf-8")
    assert "Tokens that are kept" in page and "Nearness of the attendance" in page
