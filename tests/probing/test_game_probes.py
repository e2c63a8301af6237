"""Moments of a game: a policy whose sensitivities are known in closed form has just these."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pandas as pd
import pytest

from commands import foundry
from foundry.storing.store import RunFolder
from probing.conftest import done, lines, runs

PLACES = 3
EDITS = ("others_went", "no_history", "scale_payoffs", "rename_agents")


@pytest.fixture(scope="module")
def probed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A probe of who goes by the last evening in moments of two sweeps of one bar."""
    folder = tmp_path_factory.mktemp("bar")
    world = ("world=bar", "world.agents=6", "world.steps=6", f"world.capacity={PLACES / 6}", "analyze=false")
    for model in ("coin", "always_go"):
        done("-m", *world, f"model=scripted/{model}", "seed=0-1", f"output.dir={model}", cwd=folder)
    (folder / "mine" / "model").mkdir(parents=True)
    (folder / "mine" / "model" / "follower.yaml").write_text("_target_: policies.Follower\nname: follower\n")
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
    found = foundry("replay", str(runs(probed)[0].path), "--trust-targets", "policies", cwd=folder)
    assert found.returncode == 2 and "A probe has no pictures" in found.stderr and found.stderr.count("\n") == 1
