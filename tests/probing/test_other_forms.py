"""Moments of games and of 3D worlds: policies whose sensitivities are known in closed form have just these."""

from pathlib import Path
from typing import Any

import msgspec
import pandas as pd
import pytest

from foundry.storing.store import RunFolder
from probing.conftest import QUIET, done, lines, refused, runs, write_models

PLACES = 3
TRUSTED = ("--trust-targets", "policies")


def chosen(probed: Path, edit: str) -> dict[tuple[Any, ...], str]:
    """Return what was chosen, by run, step and agent; it is always the same."""
    found = [line for run in runs(probed) if run.factors["edit"] == edit for line in lines(run)]
    return {(line["run"], line["step"], line["agent"]): line["action"] for line in found}


def past_of(run: RunFolder, step: int, agent: int) -> tuple[int, bool] | None:
    """Return how many went on the evening before, and whether the agent did; None on the first."""
    went = [line for line in lines(run) if line["step"] == step - 1 and line["action"] == "go"]
    return None if step == 1 else (len(went), agent in {line["agent"] for line in went})


@pytest.mark.slow
def test_who_goes_by_the_last_evening_changes_with_what_is_told_of_it_and_with_nothing_else(tmp_path: Path):
    world = ("world=bar", "world.agents=6", "world.steps=6", f"world.capacity={PLACES / 6}", *QUIET)
    for model in ("coin", "always_go"):
        done("-m", *world, f"model=scripted/{model}", "seed=0-1", f"output.dir={model}", cwd=tmp_path)
    write_models(tmp_path, follower="policies.Follower")
    edits = "edit=others_went,no_history,scale_payoffs,rename_agents"
    asked = ("coin", "always_go", "--config-dir", "mine", "model=follower", "moments=32", "repeats=2", "window=2")
    done("probe", *asked, edits, "runner.workers=1", "output.dir=probed", cwd=tmp_path)
    probed = tmp_path / "probed"
    recorded = {run.id: run for name in ("coin", "always_go") for run in runs(tmp_path / name)}
    unedited, reversed_, forgotten = (chosen(probed, edit) for edit in ("none", "others_went", "no_history"))
    assert len(unedited) == 32 and {moment[0] for moment in unedited} == set(recorded)
    for (run, step, agent), action in unedited.items():
        past = past_of(recorded[run], step, agent)
        assert action == ("go" if past is None or past[0] <= PLACES else "stay")
        if past is None:
            assert (run, step, agent) not in reversed_ and (run, step, agent) not in forgotten
            continue
        assert forgotten[run, step, agent] == "go"
        went, own = past
        if (run, step, agent) in reversed_:
            assert reversed_[run, step, agent] == ("go" if 5 - (went - own) + own <= PLACES else "stay")
    assert any(reversed_[moment] != unedited[moment] for moment in reversed_)
    for edit in ("scale_payoffs", "rename_agents"):
        assert chosen(probed, edit) == unedited
    table = pd.read_csv(probed / "analysis" / "edits.csv").set_index("edit")
    assert table["distance"][["scale_payoffs", "rename_agents"]].tolist() == [0, 0]
    strata = msgspec.json.decode((probed / "moments.json").read_bytes())["strata"]
    assert {one["payoff"] for one in strata} == {"none", "at", "above", "below"}
    assert "10 identical" in done("verify", "probed", "--workers", "1", *TRUSTED, cwd=tmp_path)
    assert "A probe has no pictures" in refused("replay", str(runs(probed)[0].path), *TRUSTED, cwd=tmp_path)


@pytest.mark.exhaustive
def test_who_reads_images_follows_their_mirror_and_changes_without_them_and_who_reads_none_does_not(tmp_path: Path):
    tiny = ("world.camera.width=64", "world.camera.height=48", "world.steps=6", "analyze=false")
    walkers = ("-m", "world=kibo", "model=scripted/oracle,scripted/wander", "seed=0-1")
    done(*walkers, *tiny, "output.dir=pilot", cwd=tmp_path)
    write_models(tmp_path, forward="policies.Forward", brighter="policies.Brighter")
    models, edits = "model=scripted/oracle,forward,brighter", "edit=mirror_image,blank_image,other_image"
    asked = ("--config-dir", "mine", "-m", models, "moments=12", "repeats=2", edits, "output.dir=probed")
    done("probe", "pilot", *asked, cwd=tmp_path)
    probed, messages = tmp_path / "probed", {}
    for run in runs(tmp_path / "pilot"):
        messages |= {(run.id, call.step): call.messages for call in run.calls()}
    actions: dict[tuple[str, str], list[str]] = {}
    for run in runs(probed):
        for line, call in zip(lines(run), run.calls(), strict=True):
            is_unedited = run.factors["edit"] == "none"
            assert (call.messages == messages[line["run"], line["step"]]) == is_unedited
            actions.setdefault((run.factors["model"], run.factors["edit"]), []).append(line["action"])
    frame = pd.read_csv(probed / "analysis" / "edits.csv")
    column = frame[frame["kind"] == "all"].set_index(["model", "edit"])["distance"]
    sides = [action.startswith("turn") for action in actions["brighter", "none"]]
    assert set(actions["brighter", "blank_image"]) == {"forward"}
    assert column["brighter", "mirror_image"] == 0
    assert column["brighter", "blank_image"] == pytest.approx(sum(sides) / len(sides)) and any(sides)
    assert column["brighter", "other_image"] > 0
    assert column["forward"].tolist() == [0, 0, 0]
    turned = [action in ("turn left", "turn right") for action in actions["scripted/oracle", "none"]]
    assert column["scripted/oracle", "mirror_image"] == pytest.approx(sum(turned) / len(turned)) and any(turned)
    assert column["scripted/oracle", "blank_image"] == column["scripted/oracle", "other_image"] == 0
    done("bundle", "probed", "probed.tar.zst", cwd=tmp_path)
    done("unbundle", "probed.tar.zst", "again", cwd=tmp_path)
    assert "24 identical" in done("verify", "again", "--workers", "1", *TRUSTED, cwd=tmp_path)
