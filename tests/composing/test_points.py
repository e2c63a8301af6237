"""The points of a grid."""

from __future__ import annotations

import pytest

from foundry.composing.compose import compose
from foundry.errors import InputError


def test_a_sweep_is_composed_once_a_condition_with_all_its_seeds(workspace):
    composed = compose(["-m", "model=scripted/stay,scripted/herd", "world.steps=2,3", "seed=4-6"])
    assert composed is not None and composed.launch is None
    found = [(one.config["model"]["name"], one.config["world"]["steps"], one.seeds) for one in composed.conditions]
    assert found == [(name, steps, (4, 5, 6)) for name in ("scripted/stay", "scripted/herd") for steps in (2, 3)]


@pytest.mark.parametrize("asked", ["world=kibo,office", "+sweep=validation_3d world=kibo_paper,follow"])
def test_a_setting_is_held_against_the_worlds_of_the_sweep_and_not_against_the_default_one(asked: str):
    composed = compose(["-m", *asked.split(), "world.camera.width=96", "model=scripted/stay"])
    assert composed is not None
    assert [one.config["world"]["camera"]["width"] for one in composed.conditions] == [96] * 2
    assert "world.camera.width=96" in composed.asked


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (
            "world=kibo,bar world.camera.width=96",
            "World 'bar' has no setting 'world.camera', which world 'kibo' has.",
        ),
        (
            "model=scripted/random,llama3.2 model.options.temperature=0",
            "Model 'scripted/random' has no setting 'model.options', which model 'llama3.2' has.",
        ),
        ("world=bar,fishery world.agent=3", "Setting 'world.agent' not found. Did you mean 'world.agents'?"),
        ("world=bar world.capacit=1", "Setting 'world.capacit' not found. Did you mean 'world.capacity'?"),
        ("world=bar +world.capacity=1", "Setting 'world.capacity' exists already: leave out the +"),
    ],
)
def test_a_setting_that_a_condition_lacks_is_told_with_what_lacks_it(asked: str, told: str):
    with pytest.raises(InputError) as caught:
        compose(["-m", *asked.split(), "seed=0"])
    assert str(caught.value).startswith(told)
