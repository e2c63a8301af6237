"""Shipped worlds go the whole way with a scripted model: played, verified, measured, shown, drawn, reported."""

from pathlib import Path

import pytest
import yaml

from analysis import analyze
from analysis.pipeline import check_declared
from analysis.report import write_report
from commands import statuses
from foundry.cli import run
from foundry.paths import sweeps_dir
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export

DRAWN = ("cliff_walking", "minigrid", "tictactoe")
PLAYED = ("bar", "cafe_library", "evacuation", "fishery", "naming", "public_goods_punishment", "survival", *DRAWN)
"""One of each kind: `conformance/test_shipped.py` plays all of them."""
SHORT = ("model=scripted/random", "seed=0", "world.steps=2", "analyze=false", "record.frames=false", "output.dir=s")


def worlds() -> list[str]:
    found = yaml.safe_load((sweeps_dir() / "worlds.yaml").read_text(encoding="utf-8"))
    return str(found["hydra"]["sweeper"]["params"]["world"]).split(",")


def played(names: list[str]) -> SweepFolder:
    assert run(["+sweep=worlds", f"world={','.join(names)}", *SHORT]) == 0
    assert statuses("s") == ["complete"] * len(names)
    return SweepFolder.open("s")


@pytest.mark.slow
def test_a_world_of_each_kind_without_a_scene_is_played_verified_measured_shown_and_drawn(
    workspace: Path, capsys: pytest.CaptureFixture[str]
):
    names = list(PLAYED)
    sweep = played(names)
    assert run(["verify", "s", "--workers", "1"]) == 0
    assert f"{len(names)} identical" in capsys.readouterr().out
    analysis = analyze([sweep.path], plots=False)
    check_declared([sweep], analysis.table.measures, None)  # every column can be declared
    assert analysis.runs["world"].tolist() == names and (analysis.runs["outcome.readable"] == 1).all()
    assert analysis.runs.loc[analysis.runs["world"].isin(DRAWN), "returns.mean"].notna().all()
    shown = export(sweep.path, workspace / "page")
    assert shown.runs == len(names) and shown.page.is_file()
    runs = {run.config()["world"]["name"]: run for run in sweep.runs()}
    for name in DRAWN:
        assert run(["replay", str(runs[name].path), "--out", f"pictures/{name}"]) == 0
        assert len(list((workspace / "pictures" / name).glob("*.png"))) == 3


@pytest.mark.exhaustive
def test_every_world_is_reported(workspace: Path):
    sweep = played(worlds())
    page = write_report([sweep.path]).path.read_text(encoding="utf-8")
    own = ("Kept tokens", "Nearness of the attendance", "Catches beyond the sustainable share")
    assert all(text in page for text in (*worlds(), *own))
