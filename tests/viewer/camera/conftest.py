import asyncio

import pytest

from episodes import composed, recorded
from foundry.storing.store import SweepFolder
from labelled_rooms import write_rooms

TARGET = "world.targets=[{name: green box, prims: [/World/Thing_2], radius: 1}]"
SMALL = ("world.camera.width=96", "world.camera.height=72", "world.steps=8")
CLAIMS = "model.sentences=['I see the green box. Turn left 45 degrees.']"


@pytest.fixture(scope="session")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Two runs that turn by 45 degrees a step: one beside the green box, one behind a wall that claims to see it."""
    folder = tmp_path_factory.mktemp("rooms")
    asked = ("usd", f"scene='{write_rooms(folder / 'rooms.usda')}'", TARGET, *SMALL, "world.start.yaw=0")
    beside = composed(asked[0], "spin", *asked[1:], "+world.start.x=5.5", "+world.start.y=2")
    behind = composed(asked[0], "mumbler", *asked[1:], "+world.start.x=2", "+world.start.y=2", CLAIMS)
    return asyncio.run(recorded(folder / "sweep", [beside, behind]))
