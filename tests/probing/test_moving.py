"""One quantity of what agents perceive, moved alone: curves and their steepness."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from foundry.errors import InputError
from foundry.worlds.base import Question
from foundry.worlds.probe.quantities import check_path, moved, moves_of, quantities
from probing.conftest import done, write_models

HERE = {
    "x": 1, "y": 2, "half_size": 12, "open": True, "neighbours": [{"id": 3}, {"id": 4}],
    "fires": [{"name": "a", "x": 4, "y": 6, "radius": 9, "distance": 5.0}, {"name": "b", "x": 1, "y": 2, "radius": 9,
                                                                            "distance": 0.0}],
    "evenings": [{"went": 3}, {"went": None}, {"went": 5}],
}  # fmt: skip


def question(**changes: Any) -> Question:
    return Question(agent=0, step=1, kind="action", observation={**HERE, **changes})


def observed(path: str, value: float, form: str = "any", **changes: Any) -> dict[str, Any] | None:
    found = moved(question(**changes), path, value, form)
    return None if found is None else dict(found.observation)


def test_a_number_is_set_and_nothing_else_to_values_of_ranges_and_lists():
    assert moves_of("a.b=1..3,10,0.5,2") == ["a.b=1", "a.b=2", "a.b=3", "a.b=10", "a.b=0.5"]
    assert observed("evenings.-1.went", 7) == {**HERE, "evenings": [{"went": 3}, {"went": None}, {"went": 7}]}
    assert observed("evenings.0.went", 0) == {**HERE, "evenings": [{"went": 0}, {"went": None}, {"went": 5}]}
    for count in range(3):
        assert observed("neighbours.count", count) == {**HERE, "neighbours": HERE["neighbours"][:count]}


@pytest.mark.parametrize("text", ["a", "a=", "a=b", "=1..2", "a=3..1", "a=0.5..2", "a=1..101"])
def test_what_is_no_quantity_with_values_is_refused(text: str):
    with pytest.raises(InputError, match="sweep_over="):
        moves_of(text)


@pytest.mark.parametrize(
    ("path", "value"),
    [("evenings.1.went", 2), ("evenings.3.went", 2), ("evenings.-4.went", 2), ("open", 1), ("fires.0.name", 1),
     ("neighbours.count", 3), ("neighbours.count", 0.5), ("neighbours", 1), ("x.y", 1), ("evenings.went", 1)],
)  # fmt: skip
def test_a_question_without_such_a_number_is_left_out(path: str, value: float):
    assert observed(path, value) is None


def test_a_fire_moves_in_its_own_direction_and_its_distance_is_that_of_its_cell():
    for value, cell in ((5, (4, 6)), (0, (1, 2)), (1, (2, 3)), (9, (6, 9))):
        found = observed("fires.0.distance", value, "grid")
        fire, other = found["fires"]
        assert (fire["x"], fire["y"]) == cell and fire["distance"] == math.dist((1, 2), cell)
        assert other == HERE["fires"][1] and fire["radius"] == 9
        assert {**found, "fires": None} == {**HERE, "fires": None}


@pytest.mark.parametrize(
    ("path", "value", "changes"),
    [
        ("fires.0.distance", 10, {}),  # further than it is perceived
        ("fires.0.distance", 8, {"half_size": 7}),  # outside the field
        ("fires.1.distance", 3, {}),  # in the agent's own cell, so in no direction
        ("fires.0.distance", 3, {"window": ["..."]}),
        ("fires.0.distance", 3, {"burning": [[4, 6]]}),
        ("fires.2.distance", 3, {}),
    ],
)
def test_a_fire_that_cannot_be_there_is_left_out(path: str, value: float, changes: dict[str, Any]):
    assert observed(path, value, "grid", **changes) is None


def test_all_numbers_are_named_and_the_closest_is_offered():
    known = set(quantities(HERE))
    assert {"x", "fires.0.distance", "fires.-1.distance", "evenings.-1.went", "neighbours.count"} <= known
    assert "open" not in known and "fires.0.name" not in known
    with pytest.raises(InputError, match="Did you mean 'fires.0.distance'"):
        check_path("fires.0.distanc", "grid", [question()], [3.0])
    with pytest.raises(InputError, match="No moment allows any of these values"):
        check_path("fires.0.distance", "grid", [question()], [90.0])


@pytest.fixture(scope="module")
def swept(pilot: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("swept")
    write_models(folder, dread="policies.Dread")
    asked = ("-m", "model=dread,scripted/random", "sweep_over=fires.0.distance=2,4,6,8", "moments=24", "repeats=2")
    done("probe", str(pilot), "--config-dir", "mine", *asked, "output.dir=out", "runner.workers=1", cwd=folder)
    return folder / "out" / "analysis"


@pytest.mark.slow
def test_a_curve_falls_where_a_policy_stops_to_see_the_fire(swept: Path):
    frame = pd.read_csv(swept / "curves.csv")
    left = frame[(frame["model"] == "dread") & (frame["choice"] == "left")].set_index("value")
    assert left["share"].to_dict() == {2: 1, 4: 1, 6: 0, 8: 0} and (left["seeds"] == 3).all()
    assert set(frame[frame["model"] == "scripted/random"]["choice"]) >= {"left", "stay", "up"}
    assert (swept / "plots" / "curves_fires_0_distance.png").exists()


@pytest.mark.slow
def test_steepness_is_the_slope_within_moments(swept: Path):
    frame = pd.read_csv(swept / "steepness.csv").set_index(["model", "kind", "choice"])
    x, y = np.array([2, 4, 6, 8]), np.array([1, 1, 0, 0])
    expected = np.polyfit(x, y, 1)[0]
    assert frame.loc[("dread", "action", "left"), "slope"] == pytest.approx(expected)
    assert frame.loc[("dread", "action", "stay"), "slope"] == pytest.approx(-expected)
    blind = frame.loc["scripted/random"]
    assert (blind["slope"] == 0).all() and blind["p"].isna().all()
    assert "fires.0.distance=2" not in set(pd.read_csv(swept / "edits.csv")["edit"])
