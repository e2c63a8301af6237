"""Records of Every Eval Ever, held against its published schema."""

import json
import shutil
from pathlib import Path
from typing import Any

import msgspec
import pytest

from exporting.conftest import MADE_UP, exported
from foundry.commands.report import scores_of
from foundry.errors import RecordError
from foundry.exporting.every_eval_ever.eval_records import check, model_id, record
from foundry.exporting.writing import conditions, sampling
from foundry.storing.run_writer import write_run_summary
from foundry.storing.store import SweepFolder

FAMILY = ("outcome.readable", "outcome.failure_rate", "idle_rate.chosen")
OPTIONS = [option for name in FAMILY for option in ("--family", name)]


def records(sweep: SweepFolder) -> dict[str, Any]:
    found = [json.loads(file.read_bytes()) for file in sweep.export_dir("eee").glob("data/*/*/*/*.json")]
    return {one["model_info"]["id"]: one for one in found}


@pytest.fixture(scope="module")
def told(sweep: SweepFolder) -> str:
    return exported("eee", "out", *OPTIONS, cwd=sweep.path.parent)


def test_a_condition_is_a_record_with_its_means_and_their_uncertainty(sweep: SweepFolder, told: str):
    found = records(sweep)["ollama/qwen3:4b"]
    readable, failed = found["evaluation_results"]
    mean = scores_of(sweep, FAMILY).of_conditions[0]["outcome.readable"]
    assert (readable["evaluation_result_id"], failed["evaluation_result_id"]) == FAMILY[:2]
    assert readable["score_details"]["score"] == mean.mean == 1.0
    assert readable["score_details"]["uncertainty"]["num_samples"] == 2
    assert readable["generation_config"]["generation_args"] == {
        "temperature": 0.2, "top_p": 0.9, "top_k": 40, "max_tokens": 512,
    }  # fmt: skip
    ends = {one["evaluation_result_id"]: one["metric_config"]["lower_is_better"] for one in (readable, failed)}
    assert ends == {"outcome.readable": False, "outcome.failure_rate": True}
    assert (readable["metric_config"]["min_score"], readable["metric_config"]["max_score"]) == (0.0, 1.0)


def test_a_measure_without_bounds_says_so_and_has_its_interval(sweep: SweepFolder):
    found = record(conditions(sweep)[0], MADE_UP)
    check(found)
    (result,) = found["evaluation_results"]
    metric, details = result["metric_config"], result["score_details"]
    assert (metric["min_score"], metric["max_score"], metric["lower_is_better"]) == ("-Infinity", "Infinity", True)
    interval = {"lower": 1.0, "upper": 4.0, "confidence_level": 0.95, "method": "t"}
    assert details["uncertainty"] == {"num_samples": 1, "standard_deviation": 0.5, "confidence_interval": interval}


def test_a_condition_without_a_result_has_no_record_and_none_says_which_server_it_was(sweep: SweepFolder, told: str):
    assert set(records(sweep)) == {"ollama/qwen3:4b", "scripted/random"}
    assert (
        "cafe_library, llama3.2, paper: no record, because every declared measure lacks a value or a better direction"
        in told
    )
    host = str(next(sweep.runs()[0].calls()).host)
    assert host not in json.dumps(records(sweep))
    left = json.loads((sweep.export_dir("eee") / "left_out.json").read_bytes())
    assert list(left) == ["idle_rate.chosen"] and "no direction is better" in left["idle_rate.chosen"]
    assert "left out: 1 declared measure, because neither high nor low values are better" in told
    said = records(sweep)["scripted/random"]["source_metadata"]["additional_details"]["left_out"]
    assert said == '["idle_rate.chosen"]'


def test_runs_that_failed_or_have_not_ended_are_counted_and_are_in_no_mean(sweep: SweepFolder, tmp_path: Path):
    copy = SweepFolder.open(shutil.copytree(sweep.path, tmp_path / "out", ignore=shutil.ignore_patterns("analysis")))
    first, _, *refused, scripted, _ = copy.runs()
    for run in (first, *refused):
        (run.path / "run.json").unlink()
    write_run_summary(scripted, msgspec.structs.replace(scripted.summary(), status="failed", error="gone"))
    told = exported("eee", "out", *OPTIONS, cwd=tmp_path)
    assert "cafe_library, qwen3:4b, paper: 1 unfinished runs are left out" in told
    assert "cafe_library, llama3.2, paper: 2 unfinished runs are left out" in told
    assert told.count("unfinished runs are left out") == 2 and "2 files with 3 runs in" in told
    details = {name: one["evaluation_results"][0]["score_details"] for name, one in records(copy).items()}
    runs = {name: tuple(one["details"].values()) for name, one in details.items()}
    assert runs == {"ollama/qwen3:4b": ("2", "1"), "scripted/random": ("2", "1")}
    assert [detail["uncertainty"] for detail in details.values()] == [{"num_samples": 1}] * 2
    for run in copy.runs():
        (run.path / "run.json").unlink(missing_ok=True)
    assert "has ended, so nothing can be exported" in exported("eee", "out", cwd=tmp_path, code=2)


def test_a_folder_that_holds_files_is_refused(sweep: SweepFolder, tmp_path: Path):
    (tmp_path / "there").touch()
    assert "is not empty" in exported("eee", "out", str(tmp_path), cwd=sweep.path.parent, code=2)


def test_files_lie_where_the_datastore_has_them_and_are_the_same_every_time(sweep: SweepFolder, tmp_path: Path):
    exported("eee", "out", str(tmp_path / "again"), *OPTIONS, cwd=sweep.path.parent)
    exported("eee", "out", *OPTIONS, cwd=sweep.path.parent)
    once, again = (
        {file.relative_to(root).as_posix(): file.read_bytes() for file in root.rglob("*.json")}
        for root in (sweep.export_dir("eee"), tmp_path / "again")
    )
    assert once == again
    assert {name.rpartition("/")[0] for name in once} == {
        "", "data/foundry-worlds/ollama/qwen3_4b", "data/foundry-worlds/scripted/random",
    }  # fmt: skip


def test_what_the_schema_does_not_know_is_refused(sweep: SweepFolder, told: str):
    found = records(sweep)["scripted/random"]
    check(found)
    found["evaluation_results"][0]["metric_config"]["lower_is_better"] = "unknown"
    with pytest.raises(RecordError, match=r"evaluation_results\[0\].metric_config.lower_is_better: 'unknown' is not"):
        check(found)


def test_a_model_of_ones_own_has_its_module_in_front(sweep: SweepFolder):
    (condition, *_) = conditions(sweep)
    condition.config["model"] |= {"name": "left", "_target_": "policies.Left"}
    assert model_id(condition) == "policies/left"


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ({"options": {"num_predict": 512, "top_k": 40, "min_p": 0.0, "stop": None}}, {"max_tokens": 512, "top_k": 40}),
        ({"options": {"num_predict": -1}}, {}),
        ({"model": "gpt", "max_completion_tokens": 5, "stop": "x"}, {"max_tokens": 5, "stop": "x"}),
        ({"policy": "Random"}, {}),
    ],
)
def test_parameters_have_the_names_that_other_tools_know(parameters: dict[str, Any], expected: dict[str, Any]):
    assert sampling(parameters) == expected
