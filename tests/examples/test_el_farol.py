"""El Farol, a world of one's own outside the package, the whole way; the tutorial that leads through it."""

import json
import os
import pickle
import re
import shlex
import shutil
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]
import pytest
import yaml

import foundry as public
from commands import foundry, refusal, statuses, succeeds
from foundry import paths
from foundry.composing.compose import compose
from foundry.composing.preflight import declare
from foundry.expansion import expand, settings_key
from foundry.models.base import ModelInfo
from foundry.running.lane import LaneSpec, run_lane
from foundry.storing.store import SweepFolder

ROOT = paths.PACKAGE.parent
EXAMPLE = ROOT / "examples" / "el_farol"
MINE = "examples/el_farol/mine"
TRUSTED = ("--config-dir", MINE)
TUTORIAL = (ROOT / "docs" / "own_world.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^    foundry (.+)$", TUTORIAL.replace(" \\\n        ", " "), re.MULTILINE)


def said(*arguments: str, cwd: Path) -> str:
    """Run a command that must end well; return what it said."""
    done = succeeds(*arguments, cwd=cwd)
    return done.stdout


@dataclass(frozen=True)
class Led:
    """Where the tutorial leads: a folder, and what each of its commands said in it."""

    place: Path
    said: dict[str, str]

    def run(self, model: str, sweep: str = "bar") -> str:
        """Return the folder of a run with seed 0."""
        runs = public.load(self.place / sweep).runs
        return f"{sweep}/runs/{runs[(runs['model'] == model) & (runs['seed'] == 0)]['run'].iloc[0]}"


@pytest.fixture(scope="module")
def led(tmp_path_factory: pytest.TempPathFactory) -> Led:
    """Do all that the tutorial says, in a folder that has the example and nothing else."""
    place = tmp_path_factory.mktemp("tutorial")
    shutil.copytree(EXAMPLE, place / "examples" / "el_farol", ignore=shutil.ignore_patterns("__pycache__"))
    led = Led(place, {})
    for command in COMMANDS:
        run = led.run("scripted/random") if "RUN" in command else ""
        led.said[command] = said(*shlex.split(command.replace("RUN", run)), cwd=place)
    return led


def the(led: Led, start: str) -> str:
    """Return what the command that begins so said."""
    return next(text for command, text in led.said.items() if command.startswith(start))


@pytest.mark.slow
def test_the_tutorial_has_ten_steps_and_each_of_its_commands_ends_well(led: Led):
    assert len(re.findall(r"^## \d+\. ", TUTORIAL, re.MULTILINE)) == 10
    assert len(led.said) == len(COMMANDS) >= 15
    assert "12 of 12 runs complete in bar" in the(led, "-m --config-dir")
    assert "0 failed" in the(led, "check world=el_farol") and "0 failed" in the(led, "check attendance")
    assert "12 runs: 12 identical" in the(led, "verify bar")
    assert "at most 2,000 calls would be sent" in the(led, "plan -m")
    assert "first differing state: steps.jsonl" in the(led, "diff")
    (picture,) = (led.place / "bar" / "analysis" / "replay").rglob("*.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    page = (led.place / "bar" / "report.html").read_text(encoding="utf-8")
    assert "evening: go (share)" in page and "Nearness to the capacity" in page
    plots = {file.name for file in (led.place / "bar" / "analysis" / "plots").iterdir()}
    assert {"evening_by_agent.svg", "evening_by_round.svg"} <= plots
    assert (led.place / "pages" / "index.html").exists()
    beside = SweepFolder.open(SweepFolder.open(led.place / "bar").baselines_dir)
    assert [condition.config["model"]["name"] for condition in beside.sweep.conditions] == ["scripted/stay"]


@pytest.mark.slow
def test_who_goes_and_who_stays_gets_what_the_rules_say(led: Led):
    lines = steps_of(led.place / led.run("scripted/random"))
    for step in range(1, 21):
        evening = [line for line in lines if line["step"] == step]
        went = sum(line["action"] == "go" for line in evening)
        pays = {"go": 10 if went <= 6 else 0, "stay": 5}
        assert [line["utility"] for line in evening] == [pays[line["action"]] for line in evening]


def steps_of(run: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (run / "steps.jsonl").read_text(encoding="utf-8").splitlines()]


@pytest.mark.slow
def test_the_prompt_tells_how_many_went_to_whom_it_is_told(led: Led):
    asked = ("world=el_farol", "model=mine/mixing", "--step", "6", "--agent", "0", "--kind", "evening")
    implicit = said("plan", "--prompt", "--config-dir", MINE, "world.reports=implicit", *asked, cwd=led.place)
    assert the(led, "plan --prompt").count("of 10 went.") == 5
    assert implicit.count("of 10 went.") == implicit.count("You went") < 5


@pytest.mark.slow
def test_a_fork_shares_what_was_before_and_is_verified(led: Led):
    shared = [
        steps_of(led.place / run)[:90] for run in (led.run("scripted/random"), led.run("mine/mixing", sweep="forked"))
    ]
    assert shared[0] == shared[1]
    assert "1 identical" in said("verify", "forked", "--workers", "1", *TRUSTED, cwd=led.place)
    assert SweepFolder.open(led.place / "forked").sweep.conditions[0].config["baselines"][-1] == "mine/mixing"


@pytest.mark.slow
def test_where_its_code_is_not_named_or_not_trusted_one_line_says_so(led: Led):
    line = refusal("verify", "bar", cwd=led.place)
    assert "allow it with --trust-targets el_farol" in line
    assert "name its folder with --config-dir" in line
    command = [sys.executable, "-m", "foundry", "resume", "bar", "--trust-targets", "el_farol"]
    absent = subprocess.run(command, cwd=led.place, capture_output=True, text=True, check=False)
    assert absent.returncode == 2 and "name its folder with --config-dir" in absent.stderr
    assert line.count("\n") == absent.stderr.count("\n") == 1


@pytest.mark.slow
def test_its_signature_is_measured_as_plain_loops_say_and_claims_rest_on_it_where_that_is_declared(led: Led):
    assert "world el_farol" in the(led, "analyze")
    table = pq.read_table(led.place / "bar" / "analysis" / "signatures.parquet").to_pandas()
    score = table.groupby("model")["attendance.score"].mean()
    assert score["scripted/stay"] == pytest.approx(0)
    assert score["scripted/random"] == pytest.approx(75.4, abs=6) and score["mine/mixing"] == pytest.approx(80, abs=6)
    sources = (led.place / "bar" / "analysis" / "sources.csv").read_text(encoding="utf-8")
    assert "rounds,attendance,mine/signatures/attendance.py" in sources
    run = led.run("mine/mixing")
    went = Counter(line["step"] for line in steps_of(led.place / run) if line["action"] == "go")
    attended = [went[evening] for evening in range(1, 21)]
    row = table.set_index("run").loc[Path(run).name]
    assert row["attendance.score"] == pytest.approx(
        100 * (0.6 - np.mean([abs(one / 10 - 0.6) for one in attended])) / 0.6
    )
    assert row["attendance.volatility"] == pytest.approx(np.var(attended, ddof=1) / 2.5)
    assert row["attendance.n_evenings"] == 20


@pytest.mark.parametrize(("names", "told"), [
    ("[mine/mixin]", "Baseline 'mine/mixin' not found. Did you mean 'mine/mixing'?"),
    ("[scripted/seek]", "'scripted/seek' cannot be a baseline of world 'el_farol': it does not answer 'evening'"),
    ("[../mine/mixing]", "not found"),
    ("[ollama]", "must have a `name`, but no `defaults` and no references"),
    ("scripted/random", "must be a list of policies"),
])  # fmt: skip
@pytest.mark.slow
def test_a_baseline_that_is_none_is_told_in_one_line(led: Led, names: str, told: str):
    one = ("--config-dir", MINE, "world=el_farol", "model=scripted/random", "world.steps=2", "analyze=false")
    done = foundry(*one, f"baselines={names}", "output.dir=w", cwd=led.place)
    if done.returncode == 0:
        done = foundry("analyze", "w", "--baselines", *TRUSTED, cwd=led.place)
        shutil.rmtree(led.place / "w")
    assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.slow
def test_a_served_model_is_given_the_schema_that_the_world_chose(led: Led):
    asked = ("--config-dir", MINE, "world=el_farol", "model=qwen3:4b", "--cfg", "job", "--package", "model.schemas")
    found = yaml.safe_load(said(*asked, "--resolve", cwd=led.place))
    assert list(found) == ["evening"] and list(found["evening"]["properties"]) == ["action", "reasoning"]
    assert found["evening"]["properties"]["action"]["enum"] == ["go", "stay"]


@pytest.mark.slow
@pytest.mark.parametrize(("own", "status"), [((), "failed"), ((EXAMPLE / "mine",), "complete")])
def test_a_worker_that_knows_nothing_of_the_command_is_told_where_its_code_is(
    tmp_path: Path, own: tuple[Path, ...], status: str
):
    """As a cluster's workers are: started before, by someone else, without the variables of the command."""
    asked = ("--config-dir", str(EXAMPLE / "mine"), "world=el_farol", "model=mine/mixing", "world.steps=2")
    composed = compose(asked)
    sweep = declare(expand((), composed.conditions))
    infos = {settings_key(sweep.conditions[0].config["model"]): ModelInfo("mine/mixing")}
    folder = SweepFolder.create(tmp_path / "s", sweep, {"record": {"frames": False}}, [])
    folder.start_progress("0")
    runs = tuple(run.id for run in folder.runs())
    task = pickle.dumps((run_lane, LaneSpec("0", "0", folder, runs, infos, cache=str(tmp_path / "answers"), own=own)))
    worker = [sys.executable, "-P", "-m", "foundry.running.lane_process"]
    known = {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT)}
    subprocess.run(worker, input=task, env=known, cwd=tmp_path, capture_output=True, check=True)
    assert statuses(folder.path) == [status]
