"""Runs of worlds of rounds as arrays, and what is shown of them, against plain loops over the records."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import made_up_rounds
from analysis.any.any_arrays import objects
from analysis.any.any_run import AnyRun
from analysis.arrays import OUTCOMES
from analysis.figures.shown import Shown
from analysis.form import form_of
from analysis.plots import draw
from analysis.rounds.rounds_figures import RoundsFigures
from analysis.rounds.rounds_run import NONE, RoundsRun
from analysis.signatures import measure
from foundry.declared import Actions, Declared
from foundry.records import Outcome

BAR = Actions(labels=("go", "stay"), idle="stay")
CATCH = Actions(low=0, high=10, idle=0)
ROWS = [  # step, agent, kind, action, readable
    (1, 0, "evening", "go", True),
    (1, 1, "evening", "stay", True),
    (1, 2, "evening", None, False),
    (1, 0, "catch", 4, True),
    (1, 1, "catch", None, False),
    (2, 0, "evening", "go", True),
    (2, 1, "evening", "go", True),
    (2, 1, "talk", None, True),
    (2, 0, "catch", 10, True),
]


def run(*, idle: bool = True, run_id: str = "r") -> RoundsRun:
    actions = {"evening": BAR if idle else Actions(labels=("go", "stay")), "catch": CATCH}
    step, agent, kind, action, readable = zip(*ROWS, strict=True)
    texts: Any = lambda values: np.fromiter(values, dtype=np.object_, count=len(ROWS))  # noqa: E731
    general = AnyRun(
        id=run_id,
        declared=Declared(form="rounds", actions=actions),
        step=np.array(step),
        agent=np.array(agent),
        kind=texts(kind),
        action=texts(one if isinstance(one, str) else None for one in action),
        number=np.array([math.nan if not isinstance(one, int) else one for one in action], dtype=np.float64),
        outcome=np.array([OUTCOMES.index(Outcome.CHOSEN if one else Outcome.UNREADABLE) for one in readable]),
        utility=np.full(len(ROWS), math.nan),
        said=texts(None for _ in ROWS),
        deliveries=np.zeros((0, 3), dtype=np.int64),
        agents=3,
        personas=({}, {}, {}),
    )
    return RoundsRun.of(general)


def test_the_form_rounds_is_found_by_its_name():
    assert form_of("rounds").run is RoundsRun


def test_decisions_stand_by_round_and_agent_with_the_keys_of_the_worlds_own():
    assert run().steps == 2
    assert run().choices("evening").tolist() == [[0, 1, 1], [0, 0, NONE]]
    assert run(idle=False).choices("evening").tolist() == [[0, 1, NONE], [0, 0, NONE]]
    np.testing.assert_array_equal(run().numbers("catch"), [[4, 0, np.nan], [10, np.nan, np.nan]])
    stocks = [7, None, *[0] * 7]
    found = replace(run(), columns={"stock": objects(stocks)})
    np.testing.assert_array_equal(found.column("evening", "stock"), [[7, np.nan, 0], [0, 0, np.nan]])
    found, readable = run(), run().only_readable()
    assert isinstance(readable, RoundsRun)
    np.testing.assert_allclose(found.shares("evening")["go"], [1 / 3, 1])
    np.testing.assert_allclose(readable.shares("evening")["go"], [1 / 2, 1])
    np.testing.assert_allclose(found.shares("evening")["stay"], [2 / 3, 0])
    np.testing.assert_allclose(found.means("catch"), [2, 10])
    np.testing.assert_allclose(readable.means("catch"), [4, 10])


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_the_pictures_are_one_by_round_and_one_by_agent_for_each_kind_that_decides(tmp_path):
    figures = RoundsFigures(seed=0)
    groups = [Shown(("a",), 0, False), Shown(("b",), 1, True)]
    for seed in range(3):
        for shown in groups:
            figures.add(shown, run(run_id=f"{shown.label}{seed}"), seed)
    pictures = figures.pictures(groups)
    assert [one.name for one in pictures] == [
        "evening_by_round",
        "evening_by_agent",
        "catch_by_round",
        "catch_by_agent",
    ]
    for picture in pictures:
        drawn = draw(picture, "svg", "png")
        assert drawn.png.startswith(b"\x89PNG") and drawn.svg == draw(picture, "svg").svg
    assert "evening: go (share)" in draw(pictures[0], "svg").svg


OWN = """
import numpy as np
from analysis.measure import Measure
from analysis.rounds.rounds_run import RoundsRun
NAME, MEASURES, HEADLINE = 'fishing', {'most': Measure('Greatest catch')}, ('most',)
def applies(run: RoundsRun) -> bool:
    return run.world.get('stock', 0) > 0
def measure(run: RoundsRun) -> dict[str, float]:
    return {'most': float(np.nanmax(run.numbers('catch')))}
"""


def test_a_signature_of_ones_own_measures_only_the_worlds_of_its_form_that_it_is_about(tmp_path, monkeypatch):
    (tmp_path / "mine" / "signatures").mkdir(parents=True)
    (tmp_path / "mine" / "signatures" / "fishing.py").write_text(OWN)
    monkeypatch.setenv("FOUNDRY_MINE", str(tmp_path / "mine"))
    found = measure(replace(run(), world={"stock": 100}))
    assert found["fishing.most"] == found["fishing.most_readable"] == 10
    assert not any(name.startswith("fishing.") for name in measure(run()))


def test_a_run_knows_its_worlds_settings_and_the_further_keys_and_files_that_it_wrote(tmp_path):
    (folder, _) = made_up_rounds.sweep(tmp_path / "sweep").runs()
    made_up_rounds.whole_run(folder)
    form = form_of("rounds")
    found = form.read(folder, folder.summary()).arrays(folder)
    assert found.world["name"] == "bar" and found.world["agents"] == found.agents
    assert list(found.columns) == ["crowd", "reasoning", "seats"] and len(found.columns["crowd"]) == found.decisions
    assert set(found.streams) == {"evenings", "house"}
    assert [line["step"] for line in found.streams["evenings"]] == [*range(1, found.steps + 1)]
    assert found.only_readable().streams == found.streams
