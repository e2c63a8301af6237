"""Moments of 3D worlds with their images: what reads them is told from what does not, in closed form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from probing.conftest import done, lines, runs

TINY = ("world.camera.width=64", "world.camera.height=48", "world.steps=6", "analyze=false")
MODELS = {"forward": "policies.Forward", "brighter": "policies.Brighter"}


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two models that walk through the station, and a probe of three in their moments."""
    folder = tmp_path_factory.mktemp("walked")
    done("-m", "world=kibo", "model=scripted/oracle,scripted/wander", "seed=0-1", *TINY, "output.dir=pilot", cwd=folder)
    (folder / "mine" / "model").mkdir(parents=True)
    for name, target in MODELS.items():
        (folder / "mine" / "model" / f"{name}.yaml").write_text(f"_target_: {target}\nname: {name}\n")
    settings = ("moments=12", "repeats=2", "edit=mirror_image,blank_image,other_image", "output.dir=probed")
    done(
        "probe", "pilot", "--config-dir", "mine", "-m", "model=scripted/oracle,forward,brighter", *settings, cwd=folder
    )
    return folder


def edits(path: Path) -> Any:
    frame = pd.read_csv(path / "analysis" / "edits.csv")
    return frame[frame["kind"] == "all"].set_index(["model", "edit"])["distance"]


def chosen(path: Path, model: str, edit: str) -> list[str]:
    """Return the choices of a model, moment by moment."""
    found = [run for run in runs(path) if run.factors["model"] == model and run.factors["edit"] == edit]
    return [line["action"] for run in found for line in lines(run)]


@pytest.mark.exhaustive
def test_who_reads_images_follows_their_mirror_and_changes_without_them_and_who_reads_none_does_not(walked: Path):
    probed, found = walked / "probed", edits(walked / "probed")
    asked = {(run.id, call.step): call.messages for run in runs(walked / "pilot") for call in run.calls()}
    for run in runs(probed):
        for line, call in zip(lines(run), run.calls(), strict=True):
            is_unedited = run.factors["edit"] == "none"
            assert (call.messages == asked[line["run"], line["step"]]) == is_unedited
    sides = [one.startswith("turn") for one in chosen(probed, "brighter", "none")]
    assert set(chosen(probed, "brighter", "blank_image")) == {"forward"}
    assert found["brighter", "mirror_image"] == 0
    assert found["brighter", "blank_image"] == pytest.approx(sum(sides) / len(sides)) and any(sides)
    assert found["brighter", "other_image"] > 0
    assert found["forward"].tolist() == [0, 0, 0]
    turned = [one in ("turn left", "turn right") for one in chosen(probed, "scripted/oracle", "none")]
    assert found["scripted/oracle", "mirror_image"] == pytest.approx(sum(turned) / len(turned)) and any(turned)
    assert found["scripted/oracle", "blank_image"] == found["scripted/oracle", "other_image"] == 0


@pytest.mark.exhaustive
def test_a_probe_of_a_3d_world_is_verified_and_handed_on(walked: Path):
    done("bundle", "probed", "probed.tar.zst", cwd=walked)
    done("unbundle", "probed.tar.zst", "again", cwd=walked)
    told = done("verify", "again", "--workers", "1", "--trust-targets", "policies", cwd=walked)
    assert "24 identical" in told
