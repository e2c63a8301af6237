"""A recorded sweep whose moments are probed: a fire that everyone perceives from step 3 on, and nothing remembered."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

from commands import foundry
from foundry.storing.store import RunFolder, SweepFolder

PARTS = Path(__file__).parents[1] / "parts"
FIRE = "world.fires=[{name: great, start: 3, position: [0, 0], intensity: 1.0, radius: 1000}]"
WORLD = (
    "world.agents=4", "world.steps=7", "world.communication_distance=12", FIRE,
    "world.history={memory: 0, messages: 0}",
)  # fmt: skip
HERD_AND_AVOID = "model=scripted/herd,scripted/avoid"


def done(*arguments: str, cwd: Path, **variables: str) -> str:
    """Run a command that succeeds; returns what it printed."""
    found = foundry(*arguments, cwd=cwd, PYTHONPATH=str(PARTS), **variables)
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


def runs(path: Path) -> list[RunFolder]:
    return SweepFolder.open(path).runs()


def lines(run: RunFolder) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = msgspec.json.Decoder().decode_lines(run.steps_bytes())
    return found


@pytest.fixture(scope="session")
def pilot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two models, three seeds each."""
    folder = tmp_path_factory.mktemp("pilot")
    done("-m", HERD_AND_AVOID, "seed=0-2", *WORLD, "analyze=false", "output.dir=pilot", cwd=folder)
    return folder / "pilot"


@pytest.fixture(scope="session")
def probed(pilot: Path) -> Path:
    """Five models in moments of two, without the fire and in a mirror, too; `other` is random by another name."""
    (pilot.parent / "mine" / "model").mkdir(parents=True)
    for name, target in (("left", "policies.Left"), ("other", "foundry.worlds.any.any_policies.Random")):
        (pilot.parent / "mine" / "model" / f"{name}.yaml").write_text(f"_target_: {target}\nname: {name}\n")
    models = f"{HERD_AND_AVOID},scripted/random,left,other"
    settings = ("moments=30", "repeats=8", "edit=no_fire,mirror", "output.dir=probed")
    told = done("probe", "pilot", "--config-dir", "mine", "-m", models, *settings, cwd=pilot.parent)
    assert "30 moments of 6 runs, 15 conditions, 8 repeats: at most 3,600 calls" in told
    return pilot.parent / "probed"
