"""What a run is hangs on the public name of a class and on its settings, not on where the class is defined."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from commands import refusal, succeeds
from foundry.composing.compose import compose
from foundry.composing.names import with_public_names
from foundry.errors import InputError
from foundry.expansion import expand
from foundry.naming import MOVED, present, target_of, with_first_names
from foundry.storing.store import SweepFolder

WORLD = "from foundry.worlds.grid.grid_world import GridScenario\n\n\nclass Mine(GridScenario):\n    pass\n"


def ids(*overrides: str) -> list[str]:
    composed = compose(overrides)
    return [run.id for run in expand(composed.asked, composed.conditions).runs]


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], None]:
    """Write a module of a user's own and make it importable."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name: str, text: str) -> None:
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")

    return write


@pytest.mark.parametrize("old", MOVED)
def test_what_sweeps_of_0_1_name_is_found_where_it_is_now(old: str):
    assert target_of(old) is target_of(MOVED[old])
    assert target_of(old).__name__ == MOVED[old].rpartition(".")[2]


def test_a_class_gives_one_id_by_whatever_path_it_is_asked_for_and_another_class_another(
    module: Callable[[str, str], None], workspace: Path
):
    module("alias", "from foundry.worlds.grid.grid_world import GridScenario as Shipped\n")
    module("own", WORLD)
    shipped = ids()
    for path in ("foundry.worlds.grid.world.GridScenario", "foundry.worlds.grid.GridScenario", "alias:Shipped"):
        assert ids(f"world._target_={path}") == shipped
    assert ids("world._target_=own.Mine") != shipped


def test_a_class_that_moves_keeps_its_ids_if_it_says_its_public_name(
    module: Callable[[str, str], None], workspace: Path
):
    module("own", WORLD)
    before = ids("world._target_=own.Mine")
    module("deeper", WORLD + '    public_name = "own.Mine"\n')
    module("own", "from deeper import Mine\n")
    sys.modules.pop("own")
    for path in ("deeper.Mine", "own.Mine"):
        assert ids(f"world._target_={path}") == before


def test_a_class_below_one_with_a_public_name_has_its_own(module: Callable[[str, str], None]):
    module("own", WORLD + '    public_name = "own.Mine"\n\n\nclass Other(Mine):\n    pass\n')
    assert with_public_names({"_target_": "own.Other"}) == {"_target_": "own.Other"}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nowhere.Mine", "own.Mine has the public_name 'nowhere.Mine', which cannot be imported."),
        ("own.Nobody", "own.Mine has the public_name 'own.Nobody', which cannot be imported."),
        ("", "own.Mine has the public_name '', which cannot be imported."),
        ("foundry.worlds.grid.grid_world.GridScenario", "which is another class."),
    ],
)
def test_a_public_name_that_is_not_the_class_s_is_told_in_one_line(
    name: str, said: str, module: Callable[[str, str], None], workspace: Path
):
    module("own", WORLD + f'    public_name = "{name}"\n')
    assert said in refusal("world._target_=own.Mine", "model=scripted/stay", cwd=workspace)
    assert not (workspace / "outputs").exists()


def test_parts_at_any_depth_have_their_public_names_and_what_cannot_be_found_stays():
    moved = {"_target_": "foundry.worlds.grid.GridScenario", "parts": [{"_target_": "foundry.prompts.Prompt"}]}
    named = with_public_names(moved)
    assert named["_target_"] == "foundry.worlds.grid.grid_world.GridScenario"
    assert named["parts"] == [{"_target_": "foundry.prompts.prompt.Prompt"}]
    for odd in ("nowhere.Thing", "os.system", "", None, 3, ["a"]):
        assert with_public_names({"_target_": odd}) == {"_target_": odd}
    with pytest.raises(InputError):
        compose(["world._target_=3"])


@pytest.mark.parametrize(
    ("recorded", "first"),
    [
        ("foundry.models.scripted.grid.Avoid", "foundry.models.scripted.avoid.Avoid"),
        ("foundry.models.human.model.HumanModel", "foundry.models.human.model.HumanModel"),
        ("foundry.worlds.grid.world.GridScenario", "foundry.worlds.grid.GridScenario"),
        (
            "foundry.worlds.camera.probing.world.MapProbeScenario",
            "foundry.worlds.camera.probing.world.MapProbeScenario",
        ),
    ],
)
def test_a_class_whose_module_moved_is_found_and_keeps_the_name_it_had_first(recorded: str, first: str):
    assert target_of(recorded) is target_of(present(recorded))
    for target in (recorded, present(recorded)):
        assert with_first_names({"_target_": target}) == {"_target_": first}


def test_what_is_recorded_is_the_public_name(module: Callable[[str, str], None], workspace: Path):
    module("alias", "from foundry.worlds.grid.grid_world import GridScenario as Shipped\n")
    small = ("world.agents=2", "world.steps=1", "model=scripted/stay", "analyze=false", "output.dir=out")
    succeeds("world._target_=alias.Shipped", *small, cwd=workspace)
    (condition,) = SweepFolder.open(workspace / "out").sweep.conditions
    assert condition.config["world"]["_target_"] == "foundry.worlds.grid.grid_world.GridScenario"
