"""The scripted baselines: on the same worlds and seeds, where they can act."""

from pathlib import Path

import pytest

from analysis import analyze
from analysis.validation.facts import all_facts, policies_of
from commands import statuses
from foundry.cli import run
from foundry.commands.sweeps import run_baselines
from foundry.composing.baselines import baselines_of
from foundry.composing.compose import compose
from foundry.composing.preparing import local_runner
from foundry.expansion import Sweep, expand
from foundry.running.build import build
from foundry.storing.store import SweepFolder

LOCAL = {"_target_": "foundry.running.local.LocalRunner"}
DASK = {"_target_": "foundry.running.dask.DaskRunner", "workers": 64}
SCENES = ("kibo_paper", "follow", "map_probe")
"""Worlds whose scenes take seconds to load."""
SHORT = ("world.agents=3", "world.steps=3", "analyze=false")


def sweep(*argv: str) -> Sweep:
    composed = compose(["-m", *SHORT[:2], *argv])
    return expand(composed.asked, composed.conditions)


def models(sweep: Sweep) -> list[str]:
    return [condition.config["model"]["name"] for condition in sweep.conditions]


def test_each_world_is_run_once_with_each_of_its_settings_and_without_policies_that_the_sweep_compares():
    asked = sweep("model=scripted/first,scripted/oracle", "prompt=paper,japanese", "world.steps=5,8", "seed=0-2")
    found = baselines_of(asked, policies_of)
    assert models(found) == ["scripted/random", "scripted/stay", "scripted/avoid"] * 2
    assert [dict(condition.factors)["world.steps"] for condition in found.conditions] == [5] * 3 + [8] * 3
    assert {condition.seeds for condition in found.conditions} == {(0, 1, 2)}


def test_a_game_is_held_against_policies_of_its_own():
    texts = models(baselines_of(sweep("world=public_goods_punishment", "model=scripted/random", "seed=0"), policies_of))
    assert texts == ["scripted/free_rider", "scripted/conditional"]


@pytest.mark.parametrize(
    "facts",
    [pytest.param(facts, marks=[pytest.mark.slow] * (facts.world in SCENES), id=facts.world) for facts in all_facts()],
)
def test_the_null_and_the_best_policy_of_every_known_world_are_among_its_baselines(facts):
    composed = compose([f"world={facts.world}", "model=scripted/first"])
    texts = models(baselines_of(expand(composed.asked, composed.conditions), policies_of))
    assert {facts.random, facts.best} - {None} <= set(texts) and len(texts) == len(set(texts))


@pytest.mark.parametrize(
    ("recorded", "variable", "workers"),
    [({"workers": 3}, "2", 3), ({"workers": None}, "2", 2), ({}, "", None), (DASK, "2", 2)],
)
def test_they_take_the_workers_of_their_sweep_or_those_of_the_environment(recorded, variable, workers, monkeypatch):
    if variable:
        monkeypatch.setenv("FOUNDRY_WORKERS", variable)
    else:
        monkeypatch.delenv("FOUNDRY_WORKERS")
    runner = local_runner({**LOCAL, **recorded})
    assert (runner["_target_"], runner["workers"]) == (LOCAL["_target_"], workers)
    build(runner)


@pytest.mark.slow
def test_they_are_run_beside_the_sweep_and_stand_in_its_tables(workspace: Path):
    assert run(["-m", "model=scripted/avoid,scripted/herd", "seed=0-1", *SHORT, "output.dir=s"]) == 0
    assert run_baselines(Path("s")) == 0
    beside = SweepFolder.open(SweepFolder.open("s").baselines_dir)
    assert beside.settings["runner"]["workers"] == 1, "as FOUNDRY_WORKERS said to the sweep"
    assert statuses(beside.path) == ["complete"] * 6
    analysis = analyze([Path("s")], plots=False)
    assert analysis.runs["baseline"].tolist() == [False] * 4 + [True] * 6
    assert analysis.validation[["random", "best"]].notna().all(axis=None)


@pytest.mark.exhaustive
def test_baselines_that_could_not_be_run_show_in_the_exit_code_of_the_analysis(workspace: Path):
    assert run(["-m", "model=scripted/avoid,scripted/herd", "seed=0", *SHORT, "output.dir=s"]) == 0
    baselines = SweepFolder.open("s").baselines_dir
    assert run_baselines(Path("s")) == 0
    lost = SweepFolder.open(baselines).runs()[0].path
    (lost / "run.json").unlink()
    (lost / "steps.jsonl").unlink()
    (lost / "steps.jsonl").mkdir()
    assert run(["analyze", "--baselines", "s"]) == 3
