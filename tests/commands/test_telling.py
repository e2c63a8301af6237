"""What a command tells: JSON alone, results alone, or more than usual."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import msgspec
import pytest

from commands import foundry, refusal, succeeds
from foundry.storing.store import SweepFolder
from ollama_cases import refused
from ollama_server import OllamaServer

TINY = ("world.agents=3", "world.steps=2", "analyze=false")
ASKED = ("-m", "model=scripted/stay,scripted/random", "seed=0-2", *TINY)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a finished sweep `out`, and what the quiet command said."""
    folder = tmp_path_factory.mktemp("recorded")
    done = succeeds(*ASKED, "output.dir=out", "-q", cwd=folder)
    (folder / "said.txt").write_text(done.stdout + done.stderr)
    return folder


@pytest.fixture
def swept(recorded: Path, tmp_path: Path) -> Path:
    shutil.copytree(recorded, tmp_path, dirs_exist_ok=True)
    return tmp_path


def spoil(swept: Path) -> str:
    """Change what a run recorded; returns its id."""
    run = SweepFolder.open(swept / "out").runs()[0]
    file = run.stream_path("steps")
    file.write_bytes(file.read_bytes().replace(b'"action":"stay"', b'"action":"move"', 1))
    return run.id


def objects(done: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    """Return the one JSON object that is all of the standard output."""
    found = msgspec.json.decode(done.stdout)
    assert isinstance(found, dict)
    return found


def test_status_is_a_row_for_each_model_or_one_json_object(swept: Path):
    rows = [line.split()[:4] for line in foundry("status", "out", cwd=swept).stdout.splitlines()]
    assert rows[1:3] == [["scripted/stay", "3", "3", "0"], ["scripted/random", "3", "3", "0"]]
    found = objects(foundry("status", "out", "--json", cwd=swept))
    assert set(found) == {"sweep", "models", "failed", "unread", "determinism"}
    stay = found["models"][0]
    assert stay | {"calls": 0} == {
        "model": "scripted/stay", "runs": 3, "complete": 3, "failed": 0, "running": 0, "waiting": 0, "calls": 0,
        "cached": 0, "retries": 0, "prompt_cache": None,
    }  # fmt: skip
    assert stay["calls"] == 3 * 3 * 2 * 2
    assert found["failed"] == found["unread"] == found["determinism"] == []


def test_a_cause_of_failures_is_said_once_with_its_runs_and_by_status_in_json(tmp_path: Path):
    with OllamaServer(lambda body: refused(400, "this prompt is too much")) as server:
        asked = ("-m", "model=llama3.2", "seed=0-2", *TINY, "output.dir=out", "runner.workers=1")
        done = foundry(*asked, cwd=tmp_path, OLLAMA_HOST=server.url)
    for shown in (done.stdout, foundry("status", "out", cwd=tmp_path).stdout):
        assert shown.count("this prompt is too much") == 1
        assert all(run.id in shown for run in SweepFolder.open(tmp_path / "out").runs())
    failed = objects(foundry("status", "out", "--json", cwd=tmp_path))["failed"]
    assert done.returncode == 3 and len(failed) == 3
    assert all(one["run"].startswith("llama3") and "this prompt is too much" in one["error"] for one in failed)


def test_verify_is_one_line_or_one_json_object_or_names_each_run_and_its_exit_code_stays(swept: Path):
    verify = ("verify", "out", "--workers", "1")
    usual, verbose = foundry(*verify, cwd=swept), foundry("-v", *verify, cwd=swept)
    assert usual.stdout.count("\n") == 1 and verbose.stdout.count("identical: ") == 6
    spoiled = spoil(swept)
    bad = foundry(*verify, "--json", cwd=swept)
    assert (usual.returncode, verbose.returncode, bad.returncode) == (0, 0, 3)
    assert objects(bad)["verdicts"].items() >= {"identical": 5, "differs": 1}.items()
    runs = {one["run"]: one for one in objects(bad)["runs"]}
    assert len(runs) == 6 and runs[spoiled]["verdict"] == "differs"
    assert runs[spoiled]["difference"]["field"] == "action"


def test_plan_is_one_json_object_with_what_would_be_sent(swept: Path):
    found = objects(foundry("plan", *ASKED, "seed=0-3", "output.dir=out", "--json", cwd=swept))
    assert set(found) == {"runs", "to_send", "prompt_tokens", "cost", "timed", "determinism", "reach", "notes"}
    assert [one["complete"] for one in found["runs"]].count(False) == 2
    assert found["to_send"] == 0
    assert set(found["runs"][0]) == {
        "run", "model", "prompt", "world", "seed", "calls", "served", "cached", "new", "to_send", "complete",
    }  # fmt: skip


def test_plan_tells_the_cost_of_a_model_that_has_a_price(tmp_path: Path):
    asked = ("plan", "model=openai/a", "seed=0", "model.server.price={prompt: 1, reply: 2}")
    found = objects(foundry(*asked, "--json", cwd=tmp_path, OPENAI_BASE_URL="http://127.0.0.1:9/v1"))
    assert found["cost"]["prompts"] == pytest.approx(found["prompt_tokens"] / 1e6)
    assert found["cost"]["replies"] == pytest.approx(2 * 512 * found["to_send"] / 1e6)
    finished = foundry(*asked, "model.options.max_tokens=null", cwd=tmp_path, OPENAI_BASE_URL="http://127.0.0.1:9/v1")
    assert "for prompts, unknown for replies, since they have no limit" in finished.stdout


@pytest.mark.slow
def test_analyze_is_one_json_object_with_its_tables(swept: Path):
    done = foundry("analyze", "out", "--json", cwd=swept)
    found = objects(done)
    assert set(found) == {
        "path", "summary", "declared", "findings", "runs", "comparison", "contrasts", "variance", "retest",
        "equal_chances", "thresholds", "validation", "notes", "written",
    }  # fmt: skip
    assert len(found["runs"]) == 6
    assert found["findings"] == msgspec.json.decode((swept / "out" / "analysis" / "findings.json").read_text())
    difference = next(one for one in found["contrasts"] if one["measure"] == "idle_rate.chosen")
    assert isinstance(difference["difference"], float) and difference["n_pairs"] == 3
    assert found["path"] == "out/analysis" and "out/analysis/contrasts.csv" in found["written"]


@pytest.mark.exhaustive
def test_messages_beside_json_go_to_the_standard_error(swept: Path):
    done = foundry("analyze", "out", "--json", "--baselines", cwd=swept)
    assert "complete in out/baselines" in done.stderr and objects(done)["runs"]


@pytest.mark.parametrize(
    "command",
    [
        ("analyze", "--baselines", "--family=hazard"),
        ("analyze", "--margin=hazard.exposur=0.1"),
        ("report", "--family=hazard.exposur"),
        ("export", "eee", "--family=hazard.exposur"),
    ],
)
def test_a_measure_that_does_not_exist_is_refused_before_anything_is_played_or_measured(
    command: tuple[str, ...], swept: Path
):
    name, *options = command
    before = sorted((swept / "out").rglob("*"))
    assert "Did you mean 'hazard." in refusal(name, *options[:1], "out", *options[1:], cwd=swept)
    assert sorted((swept / "out").rglob("*")) == before


def test_a_sweep_in_which_nothing_is_left_to_play_says_so_and_plays_nothing(swept: Path):
    runs = SweepFolder.open(swept / "out").runs()
    ended = [run.summary() for run in runs]
    for command in (("resume", "out", "-v"), ("resume", "out", "seed=0"), (*ASKED, "output.dir=out")):
        done = succeeds(*command, cwd=swept)
        assert "Nothing to run: all runs are complete." in done.stdout, done.stderr
        assert " complete: " not in done.stdout
    assert [run.summary() for run in runs] == ended


def test_bad_input_leaves_the_output_empty_where_json_is_asked(tmp_path: Path):
    for command in ("status", "verify", "analyze"):
        done = foundry(command, "nowhere", "--json", cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "") and "nowhere" in done.stderr


def test_a_quiet_sweep_tells_its_result_alone_and_a_verbose_one_of_each_run_as_it_ends(swept: Path):
    said = (swept / "said.txt").read_text()
    assert said.startswith("6 of 6 runs complete in out, ") and said.count("\n") == 1
    done = foundry("-v", *ASKED, "seed=0-1", "output.dir=again", cwd=swept)
    told = [line.split(" complete: ")[0] for line in done.stdout.splitlines() if " complete: 12 calls" in line]
    assert sorted(told) == sorted(run.id for run in SweepFolder.open(swept / "again").runs())


def test_a_quiet_command_leaves_out_what_is_no_result_and_the_next_one_does_not(swept: Path):
    asked = ("plan", "--pilot", "out", "--measure", "idle_rate.chosen")
    quiet, usual = (foundry(*asked, *flag, cwd=swept) for flag in (("-q",), ()))
    assert "use cautious" in usual.stdout and "use cautious" not in quiet.stdout
    assert "idle_rate.chosen" in quiet.stdout and quiet.returncode == usual.returncode


def test_quiet_and_verbose_exclude_each_other(tmp_path: Path):
    assert "-q and -v cannot be used together" in refusal("status", "out", "-q", "-v", cwd=tmp_path)


def test_a_plan_ends_with_one_command_per_line_and_one_run_is_counted_as_one(tmp_path: Path):
    asked = ("world.agents=2", "world.steps=1", "analyze=false")
    planned = foundry("plan", "-m", "model=scripted/stay,scripted/random", "seed=0-7", *asked, cwd=tmp_path).stdout
    run, declare = planned.splitlines()[-2:]
    assert run.startswith("next: foundry -m ") and "preregister" not in run
    assert declare.startswith("to make a claim, first: foundry preregister -m ")
    one = foundry("model=scripted/stay", *asked, "output.dir=out", cwd=tmp_path).stdout
    assert "1 run in out\n" in one and "1 of 1 run complete in out, " in one
