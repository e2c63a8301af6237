"""Moments of games and of 3D worlds: policies whose sensitivities are known in closed form have just these."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pandas as pd
import pytest

from foundry.storing.store import RunFolder
from probing.conftest import done, lines, refused, runs, write_models

PLACES = 3
EDITS = ("others_went", "no_history", "scale_payoffs", "rename_agents")


@pytest.fixture(scope="module")
def probed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A probe of who goes by the last evening in moments of two sweeps of one bar."""
    folder = tmp_path_factory.mktemp("bar")
    world = ("world=bar", "world.agents=6", "world.steps=6", f"world.capacity={PLACES / 6}", "analyze=false")
    for model in ("coin", "always_go"):
        done("-m", *world, f"model=scripted/{model}", "seed=0-1", f"output.dir={model}", cwd=folder)
    write_models(folder, follower="policies.Follower")
    settings = ("moments=32", "repeats=2", "window=2", f"edit={','.join(EDITS)}", "output.dir=probed")
    done("probe", "coin", "always_go", "--config-dir", "mine", "model=follower", *settings, cwd=folder)
    return folder / "probed"


def chosen(probed: Path, edit: str) -> dict[tuple[Any, ...], str]:
    """Return what was chosen, by run, step and agent; it is always the same."""
    found = [line for run in runs(probed) if run.factors["edit"] == edit for line in lines(run)]
    return {(line["run"], line["step"], line["agent"]): line["action"] for line in found}


def past_of(run: RunFolder, step: int, agent: int) -> tuple[int, bool] | None:
    """Return how many went on the evening before, and whether the agent did; None on the first."""
    went = [line for line in lines(run) if line["step"] == step - 1 and line["action"] == "go"]
    return None if step == 1 else (len(went), agent in {line["agent"] for line in went})


@pytest.mark.exhaustive
def test_who_goes_by_the_last_evening_changes_with_what_is_told_of_it_and_with_nothing_else(probed: Path):
    recorded = {run.id: run for name in ("coin", "always_go") for run in runs(probed.parent / name)}
    unedited, reversed_, forgotten = (chosen(probed, edit) for edit in ("none", "others_went", "no_history"))
    assert len(unedited) == 32 and {moment[0] for moment in unedited} == set(recorded)
    for (run, step, agent), action in unedited.items():
        told = past_of(recorded[run], step, agent)
        assert action == ("go" if told is None or told[0] <= PLACES else "stay")
        if told is None:
            assert (run, step, agent) not in reversed_ and (run, step, agent) not in forgotten
            continue
        went, own = told
        assert forgotten[run, step, agent] == "go"
        opposite = 5 - (went - own) + own
        if (run, step, agent) in reversed_:
            assert reversed_[run, step, agent] == ("go" if opposite <= PLACES else "stay")
    assert reversed_ and any(reversed_[moment] != unedited[moment] for moment in reversed_)
    for edit in ("scale_payoffs", "rename_agents"):
        assert chosen(probed, edit) == unedited
    table = pd.read_csv(probed / "analysis" / "edits.csv").set_index("edit")
    assert table["distance"][["scale_payoffs", "rename_agents"]].tolist() == [0, 0]
    shares = [
        sum(reversed_[one] != unedited[one] for one in mine) / len(mine)
        for seed in (0, 1)
        if (mine := [one for one in reversed_ if recorded[one[0]].run.seed == seed])
    ]
    assert table["distance"]["others_went"] == pytest.approx(sum(shares) / len(shares))


@pytest.mark.exhaustive
def test_a_probe_of_a_game_is_a_sweep_like_any_other(probed: Path):
    folder = probed.parent
    assert "10 identical" in done("verify", "probed", "--workers", "1", "--trust-targets", "policies", cwd=folder)
    assert "10" in done("status", "probed", cwd=folder)
    done("view", "probed", "--export", "page", cwd=folder)
    assert (folder / "page" / "index.html").is_file()
    strata = msgspec.json.decode((probed / "moments.json").read_bytes())["strata"]
    assert {one["payoff"] for one in strata} == {"none", "at", "above", "below"}
    refusal = refused("replay", str(runs(probed)[0].path), "--trust-targets", "policies", cwd=folder)
    assert "A probe has no pictures" in refusal


TINY = ("world.camera.width=64", "world.camera.height=48", "world.steps=6", "analyze=false")


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two models that walk through the station, and a probe of three in their moments."""
    folder = tmp_path_factory.mktemp("walked")
    done("-m", "world=kibo", "model=scripted/oracle,scripted/wander", "seed=0-1", *TINY, "output.dir=pilot", cwd=folder)
    write_models(folder, forward="policies.Forward", brighter="policies.Brighter")
    settings = ("moments=12", "repeats=2", "edit=mirror_image,blank_image,other_image", "output.dir=probed")
    done(
        "probe", "pilot", "--config-dir", "mine", "-m", "model=scripted/oracle,forward,brighter", *settings, cwd=folder
    )
    return folder


def edits(path: Path) -> Any:
    frame = pd.read_csv(path / "analysis" / "edits.csv")
    return frame[frame["kind"] == "all"].set_index(["model", "edit"])["distance"]


def chosen_by(path: Path, model: str, edit: str) -> list[str]:
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
    sides = [one.startswith("turn") for one in chosen_by(probed, "brighter", "none")]
    assert set(chosen_by(probed, "brighter", "blank_image")) == {"forward"}
    assert found["brighter", "mirror_image"] == 0
    assert found["brighter", "blank_image"] == pytest.approx(sum(sides) / len(sides)) and any(sides)
    assert found["brighter", "other_image"] > 0
    assert found["forward"].tolist() == [0, 0, 0]
    turned = [one in ("turn left", "turn right") for one in chosen_by(probed, "scripted/oracle", "none")]
    assert found["scripted/oracle", "mirror_image"] == pytest.approx(sum(turned) / len(turned)) and any(turned)
    assert found["scripted/oracle", "blank_image"] == found["scripted/oracle", "other_image"] == 0


@pytest.mark.exhaustive
def test_a_probe_of_a_3d_world_is_verified_and_handed_on(walked: Path):
    done("bundle", "probed", "probed.tar.zst", cwd=walked)
    done("unbundle", "probed.tar.zst", "again", cwd=walked)
    told = done("verify", "again", "--workers", "1", "--trust-targets", "policies", cwd=walked)
    assert "24 identical" in told
