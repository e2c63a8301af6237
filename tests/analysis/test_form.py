"""What depends on a form is found by its name; runs of rounds as arrays, and what is shown of them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

import made_up_rounds
from analysis import signatures
from analysis.any.any_arrays import objects
from analysis.any.any_records import read_records
from analysis.any.any_run import AnyRun
from analysis.any.general import choices, general_run
from analysis.arrays import OUTCOMES
from analysis.camera.camera_run import CameraRun
from analysis.figures.shown import ShownGroup
from analysis.form import FormAnalysis, form_of
from analysis.grid.grid_run import GridRun
from analysis.measuring.steps_file import joined
from analysis.plots import draw
from analysis.plots.saving import styled
from analysis.rounds.rounds_figures import RoundsFigures
from analysis.rounds.rounds_run import NONE, RoundsRun
from any_records import BAR, any_folder, line
from foundry.declared import Actions, Declared
from foundry.errors import InputError
from foundry.own_code import VARIABLE
from foundry.records import Outcome


def test_a_form_is_found_by_its_name_and_what_it_leaves_out_is_that_of_every_form():
    shipped = {"grid": GridRun, "camera": CameraRun, "rounds": RoundsRun, "any": AnyRun}
    assert {name: form_of(name).run for name in shipped} == shipped
    assert [form_of(name).name for name in shipped] == list(shipped)
    unknown = form_of("stats")
    assert (unknown.name, unknown.run, unknown.figures) == ("stats", AnyRun, None)
    own = FormAnalysis("own", AnyRun, read_records)
    assert unknown.schema(BAR) == own.schema(BAR) == form_of("any").schema(BAR) and own.labelled(own, None) is own
    assert own.words.notes(None, []) == own.words.methods([]) == own.words.limits([]) == own.events(None) == ()


def test_a_form_of_ones_own_with_the_name_of_a_shipped_one_is_refused(tmp_path, monkeypatch):
    (tmp_path / "mine" / "forms").mkdir(parents=True)
    (tmp_path / "mine" / "forms" / "grid.py").write_text("from analysis.camera import ANALYSIS")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    with pytest.raises(InputError, match=r"ANALYSIS in mine/forms/grid.py has the name 'grid'.* to 'grid_2'"):
        form_of("grid")


def test_the_module_of_a_form_measures_its_runs_where_one_of_every_form_has_its_name():
    (stability,) = (signature for signature in signatures.discover() if signature.name == "stability")
    assert [stability.part(one).run for one in (GridRun, CameraRun, AnyRun, dict)] == [
        GridRun, CameraRun, AnyRun, AnyRun,
    ]  # fmt: skip
    assert [
        signature.part(AnyRun) for signature in signatures.discover() if signature.name in ("clustering", "gaze")
    ] == [None, None]


def test_what_was_decided_is_there_by_kind_step_and_agent(tmp_path):
    lines = [line(1, 0), line(1, 1, action="stay"), line(1, 1, kind="bid", action=3), line(2, 1, outcome="empty")]
    folder = any_folder(tmp_path / "sweep", lines)
    found = choices(general_run(folder, read_records(folder, folder.summary())), {})
    assert list(found) == ["choice", "bid"]
    choice = found["choice"]
    readable, chosen = choice.readable[..., 0], choice.choice[0, :, 0]
    assert readable.tolist() == [[True, True], [False, False]] and chosen[0] != chosen[1]
    assert found["bid"].readable[..., 0].tolist() == [[False, True], [False, False]]
    assert found["bid"].choice[0, 1, 0] not in chosen


def test_a_column_that_two_forms_hold_in_ways_that_do_not_go_together_is_text():
    one = pa.schema([("step", pa.int32()), ("x", pa.int32()), ("tag", pa.int64())])
    other = pa.schema([("step", pa.int32()), ("x", pa.float64()), ("tag", pa.string()), ("more", pa.bool_())])
    found = joined([one, other])
    assert found.names == ["step", "x", "tag", "more"]
    assert [found.field(name).type for name in ("x", "tag")] == [pa.float64(), pa.string()]


EVENING = Actions(labels=("go", "stay"), idle="stay")
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
    actions = {"evening": EVENING if idle else Actions(labels=("go", "stay")), "catch": CATCH}
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


def test_decisions_stand_by_round_and_agent_with_the_keys_of_the_worlds_own():
    assert run().steps == 2
    assert run().choices("evening").tolist() == [[0, 1, 1], [0, 0, NONE]]
    assert run(idle=False).choices("evening").tolist() == [[0, 1, NONE], [0, 0, NONE]]
    np.testing.assert_array_equal(run().numbers("catch"), [[4, 0, np.nan], [10, np.nan, np.nan]])
    stocks = [7, None, *[0] * 7]
    rounds_run = replace(run(), columns={"stock": objects(stocks)})
    np.testing.assert_array_equal(rounds_run.column("evening", "stock"), [[7, np.nan, 0], [0, 0, np.nan]])
    rounds_run, readable = run(), run().only_readable()
    assert isinstance(readable, RoundsRun)
    np.testing.assert_allclose(rounds_run.shares("evening")["go"], [1 / 3, 1])
    np.testing.assert_allclose(readable.shares("evening")["go"], [1 / 2, 1])
    np.testing.assert_allclose(rounds_run.shares("evening")["stay"], [2 / 3, 0])
    np.testing.assert_allclose(rounds_run.means("catch"), [2, 10])
    np.testing.assert_allclose(readable.means("catch"), [4, 10])


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_the_pictures_are_one_by_round_and_one_by_agent_for_each_kind_that_decides(tmp_path):
    figures = RoundsFigures(seed=0)
    groups = [ShownGroup(("a",), 0, False), ShownGroup(("b",), 1, True)]
    for seed in range(3):
        for shown in groups:
            figures.add(shown, run(run_id=f"{shown.label}{seed}"), seed)
    pictures = figures.pictures(groups)
    names = [f"{kind}_by_{unit}" for kind in ("evening", "catch") for unit in ("round", "agent")]
    assert [picture.name for picture in pictures] == names
    with styled():
        assert all(picture.draw().axes for picture in pictures)
    drawn = draw(pictures[0], "svg", "png")
    assert drawn.png.startswith(b"\x89PNG") and drawn.svg == draw(pictures[0], "svg").svg
    assert "evening: go (share)" in drawn.svg and "catch (mean)" in draw(pictures[2], "svg").svg


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
