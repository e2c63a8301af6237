"""What Hydra hands to foundry's own launcher is what foundry gave it to call, and nobody else's."""

from __future__ import annotations

from typing import Any

import pytest

from foundry.composing.compose import compose
from foundry.errors import InputError
from hydra_plugins.foundry_plugins.sweeping import FoundryLauncher


def test_a_sweep_is_composed_once_a_condition_with_all_its_seeds(workspace):
    composed = compose(["-m", "model=scripted/stay,scripted/herd", "world.steps=2,3", "seed=4-6"])
    assert composed is not None and composed.launch is None
    found = [(one.config["model"]["name"], one.config["world"]["steps"], one.seeds) for one in composed.conditions]
    assert found == [(name, steps, (4, 5, 6)) for name in ("scripted/stay", "scripted/herd") for steps in (2, 3)]


def test_another_program_that_chooses_the_launcher_is_told_that_it_serves_foundry():
    launcher: Any = FoundryLauncher()
    launcher.setup(hydra_context=None, task_function=print, config=None)
    with pytest.raises(InputError, match="serve the command foundry alone"):
        launcher.launch([["seed=0"]], 0)
