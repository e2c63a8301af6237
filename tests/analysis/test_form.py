"""What depends on a form is found by its name, and what a form leaves out is that of every form."""

from __future__ import annotations

import pyarrow as pa
import pytest

from analysis import signatures
from analysis.any.any_records import read_records
from analysis.any.any_run import AnyRun
from analysis.any.general import choices, general_run
from analysis.camera.camera_run import CameraRun
from analysis.form import FormAnalysis, form_of
from analysis.grid.grid_run import GridRun
from analysis.measuring.steps_file import joined
from any_records import BAR, any_folder, line
from foundry.errors import InputError
from foundry.own_code import VARIABLE


@pytest.mark.parametrize(("name", "run"), [("grid", GridRun), ("camera", CameraRun), ("any", AnyRun)])
def test_a_shipped_form_is_found_by_its_name(name, run):
    assert (form_of(name).name, form_of(name).run) == (name, run)


@pytest.mark.parametrize("name", ["bazaar", "stats", "pipeline", "os"])
def test_a_form_of_which_nothing_is_known_is_read_by_what_all_have(name):
    found = form_of(name)
    assert (found.name, found.run, found.figures) == (name, AnyRun, None) and found.schema(BAR) == form_of(
        "any"
    ).schema(BAR)


def test_a_form_of_ones_own_with_the_name_of_a_shipped_one_is_refused(tmp_path, monkeypatch):
    (tmp_path / "mine" / "forms").mkdir(parents=True)
    (tmp_path / "mine" / "forms" / "grid.py").write_text("from analysis.camera import ANALYSIS")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    with pytest.raises(InputError, match=r"ANALYSIS in mine/forms/grid.py has the name 'grid'.* to 'grid_2'"):
        form_of("grid")


def test_a_form_that_says_no_more_than_how_it_is_read_has_the_columns_and_words_of_all():
    found = FormAnalysis("own", AnyRun, read_records)
    assert found.schema(BAR) == form_of("any").schema(BAR) and found.labelled(found, None) is found
    assert found.words.notes(None, []) == found.words.methods([]) == found.words.limits([]) == ()


def test_the_module_of_a_form_measures_its_runs_where_one_of_every_form_has_its_name():
    (stability,) = (one for one in signatures.discover() if one.name == "stability")
    assert [stability.part(one).run for one in (GridRun, CameraRun, AnyRun, dict)] == [
        GridRun, CameraRun, AnyRun, AnyRun,
    ]  # fmt: skip
    assert [one.part(AnyRun) for one in signatures.discover() if one.name in ("clustering", "gaze")] == [None, None]


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
