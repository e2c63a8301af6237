"""El Farol, a world of one's own outside the package, the whole way; the tutorial that leads through it."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]
import pytest
import yaml

import foundry as public
from commands import foundry, kill, started, wait_until
from foundry import own_code, paths
from foundry.storing.store import SweepFolder

ROOT = paths.PACKAGE.parent
EXAMPLE = ROOT / "examples" / "el_farol"
MINE = str(EXAMPLE / "mine")
TRUSTED = ("--trust-targets", "el_farol", "--config-dir", MINE)
TUTORIAL = ROOT / "docs" / "tutorial.md"
MODELS = "model=scripted/random,scripted/stay,mine/mixing"
FILES = ("steps.jsonl", "messages.jsonl", "calls.jsonl.zst")


def said(*arguments: str, cwd: Path) -> str:
    """Run a command that must end well; return what it said."""
    done = foundry(*arguments, cwd=cwd)
    assert done.returncode == 0, f"foundry {' '.join(arguments)}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a sweep of the example, made in it."""
    folder = tmp_path_factory.mktemp("el_farol")
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("FOUNDRY_WORKERS", "1")
        said("-m", "--config-dir", MINE, "world=el_farol", MODELS, "seed=0-7", "output.dir=s", "analyze=false", cwd=folder)
    return folder


def run_of(place: Path, model: str, seed: int = 0) -> str:
    folders = (place / "s" / "runs").glob(f"*{model}-s{seed}-*")
    return str(next(folders).relative_to(place))


def test_the_example_is_short():
    lines = [line for file in EXAMPLE.rglob("*.py") for line in file.read_text(encoding="utf-8").splitlines()]
    assert len(lines) <= 120


def test_it_runs_with_random_stay_and_a_policy_of_its_own(place: Path):
    assert said("status", "s", cwd=place).count("1,600") == 3
    found = public.load(place / "s").steps
    assert set(found["kind"]) == {"evening"} and set(found["action"]) == {"go", "stay"}
    first = found[(found["model"] == "scripted/random") & (found["seed"] == 0) & (found["step"] == 1)]
    went = int((first["action"] == "go").sum())
    pays = {"go": 10 if went <= 6 else 0, "stay": 5}
    assert [pays[action] for action in first["action"]] == first["utility"].tolist()


def test_the_prompt_tells_how_many_went_to_whom_it_is_told(place: Path):
    asked = ("world=el_farol", "model=mine/mixing", "--step", "3", "--agent", "0", "--kind", "evening")
    for reports, told in (("explicit", 2), ("implicit", None)):
        text = said("prompt", "--config-dir", MINE, f"world.reports={reports}", *asked, cwd=place)
        evenings = [line for line in text.splitlines() if re.match(r"\d\. You ", line)]
        expected = told if told is not None else sum("You went" in line for line in evenings)
        assert sum("of 10 went." in line for line in evenings) == expected


def test_every_run_is_verified_and_continued_where_its_code_is_named(place: Path):
    assert "24 identical" in said("verify", "s", "--workers", "1", *TRUSTED, cwd=place)
    assert "24 of 24 runs complete" in said("resume", "s", *TRUSTED, cwd=place)
    said("fork", run_of(place, "random"), "--at", "9", "model=mine/mixing", "output.dir=f", "analyze=false", *TRUSTED, cwd=place)
    assert "1 identical" in said("verify", "f", "--workers", "1", *TRUSTED, cwd=place)
    shared = [(place / folder / "steps.jsonl").read_bytes().splitlines()[: 8 * 10] for folder in
              (run_of(place, "random"), next((place / "f" / "runs").iterdir()))]  # fmt: skip
    assert shared[0] == shared[1]
    assert SweepFolder.open(place / "f").sweep.conditions[0].config["baselines"][-1] == "mine/mixing"


def test_where_its_code_is_not_named_or_not_trusted_one_line_says_so(place: Path):
    refused = foundry("verify", "s", "--config-dir", MINE, cwd=place)
    assert refused.returncode == 2 and "allow it with --trust-targets el_farol" in refused.stderr
    absent = foundry("resume", "s", "--trust-targets", "el_farol", cwd=place)
    assert absent.returncode == 2 and "name its folder with --config-dir" in absent.stderr
    assert refused.stderr.count("\n") == absent.stderr.count("\n") == 1


def test_two_runs_are_compared_and_each_is_drawn_again(place: Path):
    assert "first other state: steps.jsonl" in said("diff", run_of(place, "random"), run_of(place, "stay"), cwd=place)
    said("replay", run_of(place, "random"), "--steps", "0,20", "--out", "pictures", "--workers", "1", *TRUSTED, cwd=place)
    assert [file.read_bytes()[:4] for file in (place / "pictures").iterdir()] == [b"\x89PNG"] * 2


def test_it_is_handed_on_in_one_file(place: Path):
    said("bundle", "s", "s.tar.zst", cwd=place)
    said("unbundle", "s.tar.zst", "again", cwd=place)
    assert "24 identical" in said("verify", "again", "--workers", "1", *TRUSTED, cwd=place)


def test_its_signature_is_measured_and_claims_rest_on_it_where_that_is_declared(place: Path):
    text = said("analyze", "s", "--config-dir", MINE, "--family", "attendance.score", cwd=place)
    assert "in a family of 3" in text
    table = pq.read_table(place / "s" / "analysis" / "signatures.parquet").to_pandas()
    score = table.groupby("model")["attendance.score"].mean()
    assert score["scripted/stay"] == pytest.approx(0)
    assert score["scripted/random"] == pytest.approx(75.4, abs=6) and score["mine/mixing"] == pytest.approx(80, abs=6)
    sources = (place / "s" / "analysis" / "sources.csv").read_text(encoding="utf-8")
    assert "rounds,attendance,mine/signatures/attendance.py" in sources


def test_what_the_signature_says_is_what_plain_loops_say(place: Path):
    lines = [json.loads(line) for line in (place / run_of(place, "mixing") / "steps.jsonl").read_text().splitlines()]
    went = Counter(line["step"] for line in lines if line["action"] == "go")
    shares = [went[evening] / 10 for evening in range(1, 21)]
    said("analyze", "s", "--config-dir", MINE, "--family", "attendance.score", cwd=place)
    table = pq.read_table(place / "s" / "analysis" / "signatures.parquet").to_pandas().set_index("run")
    row = table.loc[Path(run_of(place, "mixing")).name]
    assert row["attendance.score"] == pytest.approx(100 * (0.6 - np.mean([abs(one - 0.6) for one in shares])) / 0.6)
    assert row["attendance.volatility"] == pytest.approx(np.var([10 * one for one in shares]) / 2.5)
    assert row["attendance.n_evenings"] == 20


def test_its_report_shows_what_agents_did_and_what_all_did(place: Path):
    said("report", "s", "--config-dir", MINE, cwd=place)
    page = (place / "s" / "report.html").read_text(encoding="utf-8")
    assert "evening: go (share)" in page and "Nearness to the capacity" in page
    assert {"evening_by_agent.png", "evening_by_round.png"} <= {
        file.name for file in (place / "s" / "analysis" / "plots").iterdir()
    }


def test_its_pages_are_written(place: Path):
    said("view", "s", "--export", "pages", "--no-browser", *TRUSTED[2:], cwd=place)
    assert (place / "pages" / "index.html").exists()


def test_its_baselines_are_those_that_its_file_names(place: Path):
    one = ("--config-dir", MINE, "world=el_farol", "model=scripted/random", "world.steps=3", "analyze=false")
    said(*one, "output.dir=b", cwd=place)
    said("analyze", "b", "--baselines", *TRUSTED, cwd=place)
    beside = SweepFolder.open(SweepFolder.open(place / "b").baselines_dir)
    assert [one.config["model"]["name"] for one in beside.sweep.conditions] == ["scripted/stay", "mine/mixing"]


@pytest.mark.parametrize(("names", "told"), [
    ("[mine/mixin]", "Baseline 'mine/mixin' not found. Did you mean 'mine/mixing'?"),
    ("[scripted/seek]", "'scripted/seek' is no baseline of world 'el_farol', which asks evening"),
    ("[../mine/mixing]", "not found"),
    ("[ollama]", "no baseline"),
    ("scripted/random", "is no list of policies"),
])  # fmt: skip
def test_a_baseline_that_is_none_is_told_in_one_line(place: Path, names: str, told: str):
    one = ("--config-dir", MINE, "world=el_farol", "model=scripted/random", "world.steps=2", "analyze=false")
    done = foundry(*one, f"baselines={names}", "output.dir=w", cwd=place)
    if done.returncode == 0:
        done = foundry("analyze", "w", "--baselines", *TRUSTED, cwd=place)
        shutil.rmtree(place / "w")
    assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1


def test_its_replies_can_be_held_to_its_schema():
    schema = yaml.safe_load((Path(MINE) / "schema" / "el_farol.yaml").read_text(encoding="utf-8"))
    own_code.importable([Path(MINE)])
    from el_farol import ElFarol  # type: ignore[import-not-found]

    assert set(schema) == set(ElFarol.kinds)
    assert tuple(schema["evening"]["properties"]["action"]["enum"]) == ("go", "stay")


def test_a_served_model_is_given_the_schema_that_the_world_chose(place: Path):
    asked = ("--config-dir", MINE, "world=el_farol", "model=qwen3:4b", "--cfg", "job", "--package", "model.schemas")
    found = yaml.safe_load(said(*asked, "--resolve", cwd=place))
    assert list(found["evening"]["properties"]) == ["action", "reasoning"]


def test_a_killed_sweep_goes_on_and_its_records_are_the_same_to_the_byte(tmp_path: Path):
    asked = ("-m", "--config-dir", MINE, "world=el_farol", "model=mine/mixing", "seed=0-29", "world.steps=200")
    ended = ("analyze=false", "runner.workers=1")
    with started(*asked, *ended, "output.dir=killed", cwd=tmp_path, FOUNDRY_WORKERS="1") as process:
        runs = tmp_path / "killed" / "runs"
        wait_until(lambda: len(list(runs.glob("*/run.json"))) > 2, "runs have ended")
        kill(process.pid)
    left = len(list(runs.glob("*/run.json")))
    assert left < 30
    said("resume", "killed", *TRUSTED, cwd=tmp_path)
    said(*asked, *ended, "output.dir=whole", cwd=tmp_path)
    for whole in (tmp_path / "whole" / "runs").iterdir():
        assert all((runs / whole.name / name).read_bytes() == (whole / name).read_bytes() for name in FILES[:2])


def test_every_command_of_the_tutorial_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    shutil.copytree(EXAMPLE, tmp_path / "examples" / "el_farol", ignore=shutil.ignore_patterns("__pycache__"))
    text = TUTORIAL.read_text(encoding="utf-8")
    commands = re.findall(r"^    foundry (.+)$", text.replace(" \\\n        ", " "), re.MULTILINE)
    assert len(re.findall(r"^## \d+\. ", text, re.MULTILINE)) == 10 and len(commands) >= 10
    for command in commands:
        name = next((one.name for one in tmp_path.glob("bar/runs/*random-s0-*")), "")
        said(*shlex.split(command.partition("  #")[0].replace("RUN", f"bar/runs/{name}")), cwd=tmp_path)
