import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.composing.compose import compose
from foundry.errors import InputError
from foundry.expansion import Condition, expand, expand_ranges, has_range, slug


def condition(model: str = "scripted/random", seeds: tuple[int, ...] = (0, 1), **changes: object) -> Condition:
    config = {
        "world": {"name": "w", "steps": 3},
        "model": {"name": model},
        "prompt": {"name": "paper"},
        "sampling_seed": None,
        "record": {"frames": False},
        **changes,
    }
    return Condition(factors={"model": model}, config=config, seeds=seeds)


@pytest.mark.parametrize(
    ("asked", "expanded"),
    [
        ("seed=0-3", "seed=0,1,2,3"),
        ("seed=0-2,7,9-11", "seed=0,1,2,7,9,10,11"),
        ("seed=4", "seed=4"),
        ("sampling_seed=1-2", "sampling_seed=1,2"),
        ("world.steps=1-2", "world.steps=1-2"),
        ("seed=[0-1,5]", "seed=0,1,5"),
        ("seed=5-5", "seed=5"),
    ],
)
def test_ranges_of_seeds_are_spelt_out(asked: str, expanded: str):
    assert expand_ranges(asked) == expanded


@pytest.mark.parametrize(
    ("asked", "message"), [("seed=9-2", "write seed=2-9"), ("seed=0-1000000", "more than 1,000,000")]
)
def test_a_range_that_runs_backwards_or_is_absurdly_long_is_refused(asked: str, message: str):
    with pytest.raises(InputError, match=message):
        expand_ranges(asked)


@pytest.mark.parametrize(("override", "several"), [("seed=0-9", True), ("seed=1,2", True), ("seed=3", False)])
def test_several_seeds_are_recognised(override: str, several: bool):
    assert has_range(override) is several


def test_seed_world_model_prompt_and_sampling_seed_each_make_another_run_and_always_the_same():
    conditions = [
        condition(),
        condition(world={"name": "w", "steps": 4}),
        condition(model="scripted/stay"),
        condition(prompt={"name": "japanese"}),
        condition(sampling_seed=1),
    ]
    first, second = ([run.id for run in expand([], conditions).runs] for _ in range(2))
    assert first == second and len(set(first)) == 10


@pytest.mark.parametrize(
    ("near", "far"),
    [
        ({"model": {"name": "m"}}, {"model": {"name": "m", "server": {"hosts": "far"}}}),
        ({"fork": {"sweep": "pilot", "run": "r", "at": 3}}, {"fork": {"sweep": "moved", "run": "r", "at": 3}}),
    ],
)
def test_how_a_model_and_a_forked_sweep_are_reached_does_not_change_what_a_run_is(near: dict, far: dict):
    usual = condition()
    conditions = [Condition(usual.factors, {**usual.config, **changes}, usual.seeds) for changes in (near, far)]
    first, second = (expand([], [condition]).runs for condition in conditions)
    assert [run.id for run in first] == [run.id for run in second]


def test_a_run_that_is_asked_for_twice_is_run_once():
    assert len(expand([], [condition(seeds=(1, 1, 2)), condition()]).runs) == 3


def test_runs_of_one_model_stand_together_in_the_order_of_the_models():
    models = ["a", "b"]
    conditions = [condition(model=m, world={"name": "w", "steps": n}) for n in (1, 2) for m in models]
    runs = expand([], conditions).runs
    assert [conditions[run.condition].config["model"]["name"] for run in runs] == ["a"] * 4 + ["b"] * 4


def test_the_definition_changes_with_the_runs_and_with_what_is_recorded():
    base = expand([], [condition()]).definition
    assert base == expand(["other words"], [condition()]).definition
    assert base != expand([], [condition(seeds=(0,))]).definition
    assert base != expand([], [condition(record={"frames": True})]).definition


@given(st.text())
def test_a_slug_is_safe_on_every_file_system(name: str):
    assert re.fullmatch(r"[a-z0-9](-?[a-z0-9]+)*", slug(name))
    assert len(slug(name)) <= 24


def test_run_ids_hold_no_character_that_a_file_system_refuses():
    (run,) = expand([], [condition(model="hf.co/someone/a-model-Instruct-GGUF:Q4_K_M", seeds=(12,))]).runs
    assert re.fullmatch(r"del-instruct-gguf-q4-k-m-s12-[a-z0-9]{12}", run.id), "the end of a name tells most"


@pytest.mark.parametrize("asked", [("-m",), ("++hydra.mode=MULTIRUN",)])
def test_several_values_are_swept_however_hydra_is_told_to(asked: tuple[str, ...]):
    composed = compose([*asked, "model=scripted/stay,scripted/random"])
    assert len(composed.conditions) == 2
