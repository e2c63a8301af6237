"""Names of models that no file lists, for every backend that takes them."""

from __future__ import annotations

import pytest
import yaml

from foundry import paths
from foundry.cli import run
from hydra_plugins.foundry_plugins.sources import open_key

FILES = (paths.conf_dir() / "model").glob("*.yaml")
BACKENDS = sorted(file.stem for file in FILES if open_key(file.stem) != "name")


def test_there_are_backends_with_names_of_their_own():
    assert {"hf", "openai"} <= set(BACKENDS)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("rest", ["a", "owner/model-1B", "/an/absolute/path", "../beside"])
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


def test_every_other_name_goes_to_the_default_backend():
    assert open_key("ollama") == "name"
