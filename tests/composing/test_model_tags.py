"""Names of models that no file lists, for every backend that takes them."""

from pathlib import Path

import pytest
import yaml

from commands import foundry, succeeds
from foundry import paths
from foundry.cli import run
from foundry.storing.store import SweepFolder
from hydra_plugins.foundry_plugins.sources import open_key
from ollama_cases import FakeModel
from ollama_server import OllamaServer

FILES = (paths.conf_dir() / "model").glob("*.yaml")
BACKENDS = sorted(file.stem for file in FILES if open_key(file.stem) != "name")


def test_some_backends_have_names_of_their_own_and_every_other_name_goes_to_the_default_one():
    assert {"hf", "openai"} <= set(BACKENDS)
    assert open_key("ollama") == "name"


@pytest.mark.parametrize(
    ("backend", "rest"),
    [
        *((name, "a") for name in BACKENDS),
        *((BACKENDS[0], rest) for rest in ("owner/model-1B", "/an/absolute/path", "../beside")),
        ("openai", "a:latest"),
    ],
)
def test_what_follows_a_backend_fills_the_setting_that_its_file_leaves_open(
    backend: str, rest: str, capsys: pytest.CaptureFixture[str]
):
    assert run([f"model={backend}/{rest}", "--cfg", "job", "--resolve"]) == 0
    model = yaml.safe_load(capsys.readouterr().out)["model"]
    assert model[open_key(backend)] == rest


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_backend_without_a_name_gets_one_line_that_says_what_is_missing(
    backend: str, capsys: pytest.CaptureFixture[str]
):
    for tag in (backend, f"{backend}/"):
        assert run([f"model={tag}"]) == 2
        said = capsys.readouterr().err
        assert f"<{open_key(backend)}>" in said and said.count("\n") == 1


@pytest.mark.slow
def test_a_model_is_the_same_with_the_default_tag_and_without(workspace: Path):
    names = "tiny,tiny:latest,ollama/tiny:latest,hf.co/owner/tiny:latest,hf.co/owner/tiny"
    with OllamaServer(models=[FakeModel("tiny:latest"), FakeModel("hf.co/owner/tiny:latest")]) as server:
        done = foundry("plan", "-m", f"model={names}", "seed=0", cwd=workspace, OLLAMA_HOST=server.url)
    rows = [line.split() for line in done.stdout.splitlines()]
    assert [row[0] for row in rows[1:3]] == ["tiny", "hf.co/owner/tiny"]
    assert "2 runs, 0 complete" in done.stdout


def test_a_sweep_that_was_recorded_with_the_default_tag_is_resumed_under_its_own_name(workspace: Path):
    small = ("world.agents=2", "world.steps=1", "analyze=false")
    asked = ("model=tiny", "model.name=tiny:latest", "output.dir=out", *small)
    with OllamaServer(models=[FakeModel("tiny:latest")]) as server:
        succeeds(*asked, cwd=workspace, OLLAMA_HOST=server.url)
        (only,) = SweepFolder.open(workspace / "out").runs()
        (only.path / "run.json").unlink()
        succeeds("resume", "out", cwd=workspace, OLLAMA_HOST=server.url)
    summary = only.summary()
    assert summary and (summary.model, summary.counts.cached) == ("tiny:latest", 4)
    assert set(server.answered.values()) == {1}
