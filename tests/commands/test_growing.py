"""Sweeps that grow: more is asked into the same folder, and what is there stays as it is."""

import shutil
from pathlib import Path

import pytest

from commands import refusal, statuses, succeeds
from foundry.cli import run
from foundry.commands.sweeps import run_baselines
from foundry.storing.store import SweepFolder
from ollama_server import OllamaServer

TINY = ("world.agents=3", "world.steps=2", "analyze=false", "runner.workers=1")
INTO = (*TINY, "output.dir=s")
FOLLOWING = ("model=scripted/random", "world.history.memory=${seed}")
TWO = "model=scripted/random,scripted/avoid"


def grow(*argv: str) -> None:
    assert run(["-m", *argv, *INTO]) == 0


def files(folder: Path) -> dict[str, bytes]:
    runs = folder / "runs"
    return {str(path.relative_to(runs)): path.read_bytes() for path in runs.rglob("*") if path.is_file()}


def seeds(folder: str) -> dict[str, tuple[int, ...]]:
    return {
        str(condition.config["model"]["name"]): condition.seeds
        for condition in SweepFolder.open(folder).sweep.conditions
    }


def ids(folder: str) -> set[str]:
    return {run.id for run in SweepFolder.open(folder).runs()}


@pytest.mark.slow
def test_a_sweep_grows_again_and_again_into_what_one_asked_at_once_is_and_what_is_there_keeps_its_bytes(
    workspace: Path,
):
    for command, runs in (
        (("-m", TWO, "seed=0", "prompt=japanese", *INTO), 2),
        (("-m", TWO, "seed=0-1", "prompt=japanese", *INTO), 4),
        (("resume", "s", "seed=2"), 6),
    ):
        before = files(workspace / "s")
        assert run(command) == 0
        assert before.items() <= files(workspace / "s").items()
        assert statuses(workspace / "s") == ["complete"] * runs
    shutil.rmtree(SweepFolder.open("s").runs()[0].path)
    assert run(["resume", "s", "model=scripted/herd"]) == 0
    assert run(["-m", f"{TWO},scripted/herd", "seed=0-2", "prompt=japanese", *TINY, "output.dir=at_once"]) == 0
    assert ids("s") == ids("at_once") and statuses(Path("s")) == ["complete"] * 9
    history = SweepFolder.open("s").sweep.history
    assert [asked.runs for asked in history] == [2, 2, 2, 3] and history[1].overrides[2] == "seed=0-1"
    assert [asked.overrides for asked in history[2:]] == [("resume", "seed=2"), ("resume", "model=scripted/herd")]


def test_a_contradiction_is_told_before_a_server_is_asked(workspace: Path):
    grow("model=scripted/random", "seed=0")
    before = files(workspace / "s"), (workspace / "s" / "sweep.yaml").read_bytes()
    for command in ("plan", "-m"):
        argv = (command, "model=qwen3:4b", "seed=0", "world.agents=3", "output.dir=s")
        assert "world.steps was 2 and is 50 now" in refusal(*argv, cwd=workspace, OLLAMA_HOST="http://127.0.0.1:9")
    assert (files(workspace / "s"), (workspace / "s" / "sweep.yaml").read_bytes()) == before


@pytest.mark.slow
def test_plan_shows_what_is_old_and_what_is_new(workspace: Path, capsys: pytest.CaptureFixture[str]):
    grow("model=scripted/random", "seed=0-1")
    capsys.readouterr()
    assert run(["plan", "-m", TWO, "seed=1-2", *INTO]) == 0
    out = capsys.readouterr().out
    rows = [line.split() for line in out.splitlines() if line.startswith("scripted/")]
    assert [(row[0], row[3], " ".join(row[-2:])) for row in rows] == [
        ("scripted/random", "2", "1 new"), ("scripted/avoid", "1-2", "2 new"), ("scripted/random", "1", "1 complete"),
    ]  # fmt: skip
    assert "s has 2 runs; the command adds 3 runs" in out
    assert run(["plan", "-m", TWO, "seed=1-2", *TINY]) == 0
    assert " new" not in capsys.readouterr().out
    assert seeds("s") == {"scripted/random": (0, 1)}


@pytest.mark.slow
def test_baselines_grow_with_the_seeds_and_keep_the_prompt_they_began_with(workspace: Path):
    grow("model=scripted/avoid", "seed=0")
    assert run_baselines(Path("s")) == 0
    before = files(Path("s/baselines"))
    grow("model=scripted/avoid", "prompt=japanese", "seed=1")
    assert run_baselines(Path("s")) == 0
    beside = SweepFolder.open("s/baselines")
    assert before.items() <= files(beside.path).items() and statuses(beside.path) == ["complete"] * 6
    assert {condition.config["prompt"]["name"] for condition in beside.sweep.conditions} == {"paper"}
    assert set(seeds("s/baselines").values()) == {(0, 1)}


@pytest.mark.slow
def test_a_model_that_changed_since_is_neither_gone_on_with_nor_grown_by_and_others_are(workspace: Path):
    argv = ("-m", *INTO)
    with OllamaServer() as server:
        succeeds(*argv, "model=qwen3:4b", "seed=0", cwd=workspace, OLLAMA_HOST=server.url)
        server.models["qwen3:4b"].digest = "e5" * 32
        for command in (("resume", "s"), (*argv, "model=qwen3:4b", "seed=1")):
            assert "changed since this sweep began" in refusal(*command, cwd=workspace, OLLAMA_HOST=server.url)
        succeeds(*argv, "model=llama3.2", "seed=0", cwd=workspace, OLLAMA_HOST=server.url)
    assert [model["name"] for model in SweepFolder.open(workspace / "s").models] == ["qwen3:4b", "llama3.2"]
    assert seeds(str(workspace / "s")) == {"qwen3:4b": (0,), "llama3.2": (0,)}


@pytest.fixture(scope="module")
def there(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a sweep `s`, and one whose settings follow the seed."""
    place = tmp_path_factory.mktemp("there")
    for name, asked in {"s": ("model=scripted/random",), "follows": (*FOLLOWING, "seed=1")}.items():
        succeeds(*asked, *TINY, f"output.dir={name}", cwd=place)
    return place


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (("-m",), "foundry resume s seed=10-19"),
        (("seed=1", "output.dir=other"), "Leave out output.dir"),
        (("world.steps=9",), "world.steps was 2 and is 9 now"),
        (("model=scripted/hert",), "Did you mean 'scripted/herd'"),
    ],
)
def test_what_no_sweep_can_grow_by_is_told_in_one_line(overrides: tuple[str, ...], said: str, there: Path):
    assert said in refusal("resume", "s", *overrides, cwd=there)


@pytest.mark.slow
def test_settings_that_follow_the_seed_are_not_taken_for_further_seeds(there: Path):
    assert "depend on the seed" in refusal("resume", "follows", "seed=2", cwd=there)
    again = ("-m", *FOLLOWING, "seed=2-3", *TINY, "output.dir=follows")
    succeeds(*again, cwd=there)
    grown = SweepFolder.open(there / "follows")
    assert [run.config()["world"]["history"]["memory"] for run in grown.runs()] == [1, 2, 3]
    (grown.path / "multirun.yaml").unlink()
    assert "depend on the seed" in refusal("resume", "follows", "seed=4", cwd=there)


def test_forks_and_probes_grow_by_their_own_commands(workspace: Path):
    grow("model=scripted/random", "seed=0")
    only = str(SweepFolder.open("s").runs()[0].path)
    for sampled in ("sampling_seed=0-1", "sampling_seed=2"):
        assert run(["fork", only, "--at", "2", "-m", sampled, "output.dir=forks", "analyze=false"]) == 0
    assert statuses(workspace / "forks") == ["complete"] * 3
    assert "foundry fork ... output.dir=forks" in refusal("resume", "forks", "seed=1", cwd=workspace)
