"""The points of a grid."""

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from foundry import paths
from foundry.composing.compose import compose
from foundry.errors import InputError


def test_a_sweep_is_composed_once_a_condition_with_all_its_seeds(workspace):
    composed = compose(["-m", "model=scripted/stay,scripted/herd", "world.steps=2,3", "seed=4-6"])
    assert composed.launch is None
    found = [
        (condition.config["model"]["name"], condition.config["world"]["steps"], condition.seeds)
        for condition in composed.conditions
    ]
    assert found == [(name, steps, (4, 5, 6)) for name in ("scripted/stay", "scripted/herd") for steps in (2, 3)]


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("world=kibo,bar world.camera.width=96", "World 'bar' has no setting 'world.camera', which world 'kibo' has."),
        (
            "model=scripted/random,llama3.2 model.options.temperature=0",
            "Model 'scripted/random' has no setting 'model.options', which model 'llama3.2' has.",
        ),
        ("world=bar,fishery world.agent=3", "Setting 'world.agent' not found. Did you mean 'world.agents'?"),
        ("world=bar world.capacit=1", "Setting 'world.capacit' not found. Did you mean 'world.capacity'?"),
        (
            "model=a model.temperature=0",
            "Setting 'model.temperature' not found. Did you mean 'model.options.temperature'?",
        ),
        ("world=bar +world.capacity=1", "Setting 'world.capacity' exists already. Leave out the +"),
    ],
)
def test_a_setting_that_a_condition_lacks_is_told_with_what_lacks_it(asked: str, told: str):
    with pytest.raises(InputError) as caught:
        compose(["-m", *asked.split(), "seed=0"])
    assert str(caught.value).startswith(told)


@pytest.mark.parametrize("is_shipped", [False, True])
def test_a_file_that_changes_between_two_commands_of_a_process_is_read_again(
    is_shipped: bool, workspace: Path, monkeypatch: pytest.MonkeyPatch
):
    shipped = paths.conf_dir()
    folder = workspace / ("shipped" if is_shipped else "mine")
    shutil.copytree(shipped, folder) if is_shipped else (folder / "world").mkdir(parents=True)
    monkeypatch.setattr(paths, "conf_dir", lambda: folder if is_shipped else shipped)
    file = folder / "world" / "tavern.yaml"
    bar = (shipped / "world" / "bar.yaml").read_text()
    asked = [
        "world=tavern",
        "world.steps=2",
        "model=scripted/random",
        *([] if is_shipped else ["--config-dir", "mine"]),
    ]
    for capacity in ("0.5", "0.25"):
        file.write_text(re.sub("^  capacity: [.0-9]+", f"  capacity: {capacity}", bar, flags=re.MULTILINE))
        assert _world(asked)["capacity"] == float(capacity)


def test_what_a_caller_changes_in_its_configuration_is_in_no_other():
    composed = compose(["world=bar", "model=scripted/random"])
    composed.first.world.capacity = 0.125
    assert _world(["world=bar", "model=scripted/random"])["capacity"] != 0.125


def _world(asked: list[str]) -> dict[str, Any]:
    composed = compose(asked)
    return composed.conditions[0].config["world"]
