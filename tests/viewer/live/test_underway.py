"""What a sweep is doing just now, and how much of it is read for that."""

import json
from pathlib import Path
from typing import Any

import pytest

from foundry.storing.store import RunFolder, SweepFolder
from foundry.viewer import catalog
from foundry.viewer.catalog import Catalog, CatalogedSweep
from foundry.viewer.underway import underway
from made_up_runs import Playing, sweep, whole_run


def report(made: SweepFolder, *opened: RunFolder, **more: Any) -> None:
    told = {"open": [run.id for run in opened], "models": {}, **more}
    made.progress_file("0-1").write_text(json.dumps(told), encoding="utf-8")


def shown(made: SweepFolder) -> CatalogedSweep:
    return Catalog(made.path).sweeps()[0]


def test_calls_left_are_those_of_open_runs_and_as_many_as_ended_ones_made_for_the_others(tmp_path: Path):
    made = sweep(tmp_path / "left", models=("first",), seeds=(0, 1, 2, 3))
    whole_run(made.runs()[0])
    made.start_progress()
    opened = made.runs()[1]
    so_far = {"most": {opened.id: 48}, "counts": {opened.id: {"calls": 8}}}
    report(made, opened, **so_far, models={"first": {"complete": 1, "calls": 28, "spared": 28}})
    found = underway(shown(made))
    assert found["left"] == (48 - 8) + 2 * 20
    report(made, **so_far)
    told = underway(shown(made))
    assert (told["left"], told["unknown"]) == (None, ["first"]), "nothing says how long a run is"


def test_nothing_is_said_of_what_is_left_before_all_runs_were_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(catalog, "LOOKED_AT_ONCE", 1)
    made = sweep(tmp_path / "large", models=("first",), seeds=(0, 1))
    whole_run(made.runs()[0])
    made.start_progress()
    report(made, models={"first": {"complete": 1, "calls": 48}})
    cataloged_sweep = shown(made)
    told = [underway(cataloged_sweep) for _ in range(2)]
    assert [one["left"] for one in told] == [None, 48]


def test_a_model_of_which_nothing_is_known_is_named_and_left_out_of_the_calls_left(tmp_path: Path):
    made = sweep(tmp_path / "later", models=("first", "second"), seeds=(0, 1))
    whole_run(made.runs()[0])
    made.start_progress()
    report(made, models={"first": {"complete": 1, "calls": 48}})
    told = underway(shown(made))
    assert (told["left"], told["unknown"]) == (48, ["second"])


def test_a_run_that_begins_fails_and_is_played_again_is_seen_so_at_the_next_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(catalog, "FEW", 0)
    made = sweep(tmp_path / "again", models=("first",), seeds=(0, 1, 2))
    first, second, _ = made.runs()
    whole_run(first)
    cataloged_sweep = shown(made)
    made.start_progress()
    report(made)
    assert underway(cataloged_sweep)["counts"] == {"complete": 1, "waiting": 2}
    report(made, second)
    playing = Playing(second)
    assert underway(cataloged_sweep)["counts"] == {"complete": 1, "running": 1, "waiting": 1}
    playing.end("the server is gone")
    report(made)
    assert underway(cataloged_sweep)["failures"][0]["runs"] == [second.id]
    second.forget_failure()
    assert underway(cataloged_sweep)["counts"] == {"complete": 1, "unfinished": 1, "waiting": 1}
    whole_run(second)
    assert (
        underway(cataloged_sweep)["counts"] == {"complete": 2, "waiting": 1}
        and not underway(cataloged_sweep)["failures"]
    )
