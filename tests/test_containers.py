"""What stands beside the package, for containers and for those who cite it, says what the package says."""

from __future__ import annotations

import importlib.util
import re
import shlex

import yaml

from foundry import __version__, paths

ROOT = paths.PACKAGE.parent


def test_the_citation_names_this_version():
    found = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (found["version"], found["license"], found["type"]) == (__version__, "Apache-2.0", "software")


def test_the_image_has_what_draws_scenes_and_extras_that_exist():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    spec = importlib.util.spec_from_file_location("tasks", ROOT / "tasks.py")
    assert spec is not None and spec.loader is not None
    tasks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tasks)
    assert set(tasks.GL_PACKAGES) <= set(shlex.split(text, comments=True))
    (extras,) = re.findall(r'"/src\[([\w,]+)\]"', text)
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert all(re.search(rf"^{extra} = \[", project, re.MULTILINE) for extra in extras.split(","))


def test_foundry_asks_the_ollama_that_is_started_beside_it():
    services = yaml.safe_load((ROOT / "compose.yaml").read_text(encoding="utf-8"))["services"]
    assert services["foundry"]["environment"]["OLLAMA_HOST"] == "http://ollama:11434"
    assert services["foundry"]["depends_on"]["ollama"]["condition"] == "service_healthy"
    assert services["foundry"]["volumes"] == ["./outputs:/work/outputs"], "where the image works"
