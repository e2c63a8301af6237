"""What an export takes of a sweep, whatever its format."""

from __future__ import annotations

import shutil
import sys
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import pytest

from commands import succeeds
from exporting.conftest import MADE_UP, REFUSAL, exported
from foundry.commands.report import scores_of
from foundry.errors import InputError
from foundry.exporting.every_eval_ever.eval_records import record
from foundry.exporting.writing import conditions, named
from foundry.storing.run_writer import write_run_summary
from foundry.storing.store import SweepFolder


def test_a_condition_has_its_runs_keeps_its_names_and_says_nothing_of_the_server(sweep: SweepFolder):
    served, refused, _ = conditions(sweep)
    counted = {made.model: (made.asked, len(made.runs), made.complete) for made in conditions(sweep)}
    assert counted == {"qwen3:4b": (2, 2, 2), "llama3.2": (2, 2, 0), "scripted/random": (2, 2, 2)}
    assert REFUSAL in str(refused.runs[0].summary.error)
    call = next(served.runs[0].calls())
    assert call.host is None and next(sweep.runs()[0].calls()).host is not None
    assert served.config["model"]["server"]["hosts"] == "http://127.0.0.1"
    assert served.identity("task") == conditions(sweep)[0].identity("task")
    assert len({served.identity("task"), served.identity("run"), refused.identity("task")}) == 3
    assert named(["a", "b"]).version == 4 and named(["a", "b"]) != named(["ab"])


def test_a_record_lasts_from_the_first_start_that_is_known_to_the_last_end(sweep: SweepFolder, tmp_path: Path):
    copy = SweepFolder.open(shutil.copytree(sweep.path, tmp_path / "out"))
    times = [(1, 4), (2, 3), (0, 2), (0, 3), (2, 3), (1, 4)]  # 0: nobody knows, since the worker process died
    for run, (started, ended) in zip(copy.runs(), times, strict=True):
        known = {"started": time_of(started) if started else "", "ended": time_of(ended)}
        write_run_summary(run, msgspec.structs.replace(run.summary(), **known))
    made = [record(condition, MADE_UP) for condition in conditions(copy)]
    lasted = [(one["evaluation_timestamp"], one["retrieved_timestamp"]) for one in made]
    assert lasted == [("1", "4"), ("2", "3"), ("1", "4")]


def time_of(second: int) -> str:
    return datetime.fromtimestamp(second, UTC).isoformat()


def test_scores_are_those_of_the_runs_and_their_means_and_of_measures_that_exist(sweep: SweepFolder):
    names = ["outcome.readable", "idle_rate.chosen"]
    scores = scores_of(sweep, names)
    assert [measure.name for measure in scores.measures] == names
    ids = [run.id for run in sweep.runs()]
    values = [scores.of_runs[run].get("idle_rate.chosen") for run in ids]
    assert [value is None for value in values] == [False, False, True, True, False, False]
    mean = scores.of_conditions[2]["idle_rate.chosen"]
    assert mean.n == 2 and mean.mean == pytest.approx(sum(v for v in values[4:] if v is not None) / 2)
    with pytest.raises(InputError, match=r"Measure 'idle_rate.chsen' not found. Did you mean 'idle_rate.chosen'"):
        scores_of(sweep, ["idle_rate.chsen"])


@pytest.mark.slow
def test_what_was_declared_before_the_runs_is_what_is_exported(tmp_path: Path):
    asked = (
        "-m",
        "model=scripted/random,scripted/stay",
        "seed=0-5",
        "world.agents=2",
        "world.steps=2",
        "output.dir=out",
    )
    succeeds("preregister", "--family", "idle_rate.chosen", *asked, cwd=tmp_path)
    succeeds(*asked, "analyze=false", cwd=tmp_path)
    scores = scores_of(SweepFolder.open(tmp_path / "out"), None)
    assert [measure.name for measure in scores.measures] == ["idle_rate.chosen"]


def test_what_is_not_installed_is_named_with_its_command(sweep: SweepFolder, monkeypatch: pytest.MonkeyPatch):
    for name in [module for module in sys.modules if module.startswith("foundry.exporting.inspect.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "inspect_ai", None)
    monkeypatch.setitem(sys.modules, "inspect_ai.event", None)
    told = exported("inspect", "out", cwd=sweep.path.parent, code=2)
    assert told == "foundry: inspect_ai is not installed: pip install 'foundry-worlds[inspect]'\n"


def test_a_secret_in_a_reply_ends_the_export(sweep: SweepFolder, monkeypatch: pytest.MonkeyPatch):
    served = conditions(sweep)[0]
    monkeypatch.setenv("SOME_TOKEN", next(served.runs[0].calls()).text.split('"')[3])
    (again, *_) = conditions(sweep)
    with pytest.raises(InputError, match="holds the value of SOME_TOKEN: nothing was written"):
        list(again.runs[0].calls())


def test_a_probe_is_exported_without_scores_since_it_is_compared_by_moment(tmp_path: Path):
    small = ("model=scripted/random", "seed=0", "world.agents=2", "world.steps=2", "analyze=false")
    succeeds(*small, "output.dir=pilot", cwd=tmp_path)
    probe = ("probe", "pilot", "-m", "model=scripted/stay", "moments=2", "repeats=1", "analyze=false")
    succeeds(*probe, "output.dir=probed", cwd=tmp_path)
    probed = SweepFolder.open(tmp_path / "probed")
    assert scores_of(probed, None).measures == ()
    with pytest.raises(InputError, match="is a probe, which has no measures to export. Leave out --family"):
        scores_of(probed, ["outcome.readable"])
    told = exported("eee", "probed", cwd=tmp_path, code=2)
    assert "Every declared measure lacks a value or a better direction (high or low), so there is no record" in told
