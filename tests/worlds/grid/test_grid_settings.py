from __future__ import annotations

import pytest

from foundry.errors import InputError
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Clustered, Explicit, Uniform

PLACE = {"name": "a", "type": "t", "center": [0, 0], "extent": [1, 1], "capacity": 1}
UNPLACED = {"name": "a", "type": "t", "extent": [1, 1], "capacity": 1}
FIRE = {"name": "f", "start": 1, "position": [0, 0], "intensity": 0.5, "radius": 3}
GOOD = {
    "name": "w",
    "half_size": 5,
    "agents": 2,
    "steps": 1,
    "places": [PLACE],
    "fires": [FIRE],
    "personas": {"gender": {"f": 1.0}},
    "layout": Uniform(),
    "communication_distance": 2,
    "history": {"memory": 1, "messages": 1},
}


def test_good_settings_are_taken():
    assert GridScenario(**GOOD).count_calls() == 4


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"agnets": 3}, "'agnets' not found. Did you mean 'agents'?"),
        ({"agents": "x"}, "world.agents: expected `int`"),
        ({"agents": 0}, "world.agents: expected `int` >= 1"),
        ({"history": {"memory": 1, "mesages": 2}}, "Setting of world.history 'mesages' not found. Did you mean 'm"),
        ({"history": {"memory": 1}}, "world.history lacks the setting 'messages'"),
        ({"history": None}, "world.history: expected a mapping"),
        ({"places": 3}, "world.places: expected a list"),
        ({"places": [PLACE | {"capcity": 3}]}, "world.places[0] 'capcity' not found. Did you mean 'capacity'?"),
        ({"places": [PLACE | {"center": [5, 0]}]}, "Place 'a' covers X from 4 to 6"),
        ({"places": [PLACE, PLACE | {"name": "b", "center": [2, 2]}]}, "Places 'a' and 'b' overlap"),
        ({"places": [PLACE, PLACE | {"center": [4, 4]}]}, "Two of world.places are named 'a'"),
        ({"places": [PLACE | {"extent": [5, 5]}]}, "no room outside"),
        ({"fires": [FIRE | {"position": [9, 0]}]}, "Fire 'f' is at [9, 0]"),
        ({"fires": [FIRE | {"start": 0}]}, "world.fires[0].start"),
        ({"fires": [FIRE | {"intensity": 1.5}]}, "world.fires[0].intensity"),
        ({"fires": [FIRE | {"radius": float("inf")}]}, "finite radius"),
        ({"fires": [FIRE, FIRE]}, "Two of world.fires are named 'f'"),
        ({"personas": {"gender": {"f": -1.0}}}, "world.personas.gender"),
        ({"personas": {"gender": {}}}, "world.personas.gender"),
        ({"communication_distance": -1}, "world.communication_distance is -1"),
        ({"layout": Explicit(positions=[[0, 0]])}, "world.layout.positions lists 1 cells for 2 agents"),
        ({"layout": Explicit(positions=[[0, 0], [6, 0]])}, "world.layout.positions[1] is [6, 0]"),
        ({"layout": "uniform"}, "world.layout: expected `Layout`"),
        ({"draw_positions": True}, "world.places[0].center is [0, 0], and world.draw_positions=true draws it"),
        ({"draw_positions": True, "places": []}, "world.fires[0].position is [0, 0], and world.draw_positions=true"),
        (
            {"draw_positions": True, "places": [UNPLACED], "fires": [], "view": 3},
            "world.draw_positions=true works only without further parts",
        ),
        (
            {"draw_positions": True, "places": [UNPLACED], "fires": [], "layout": Clustered(clusters=1, radius=2)},
            "needs the layout 'uniform', and world.layout is 'clustered'",
        ),
        (
            {"draw_positions": True, "places": [UNPLACED | {"extent": [6, 1]}], "fires": []},
            "A place of extent [6, 1] is larger than the grid of half_size 5",
        ),
        (
            {"draw_positions": True, "places": [UNPLACED | {"extent": [5, 5]}, UNPLACED | {"name": "b"}], "fires": []},
            "world.draw_positions found no room for 2 places",
        ),
    ],
)
def test_a_bad_setting_is_named_in_one_line(changes, says):
    with pytest.raises(InputError) as caught:
        GridScenario(**(GOOD | changes))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_setting_and_a_wrong_one_of_a_layout_are_named():
    with pytest.raises(InputError, match="world lacks the setting 'steps'"):
        GridScenario(**{key: value for key, value in GOOD.items() if key != "steps"})
    with pytest.raises(InputError, match="'radus' not found. Did you mean 'radius'"):
        Clustered(clusters=1, radus=2)
    with pytest.raises(InputError, match="'radius' not found"):
        Uniform(radius=3)
