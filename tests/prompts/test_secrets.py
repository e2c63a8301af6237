"""Prompts show what an agent may know, and nothing more."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from foundry import paths
from foundry.worlds.usd.sight import SECRET


@pytest.mark.parametrize("file", sorted((paths.conf_dir() / "prompt").glob("*.yaml")), ids=lambda file: file.stem)
def test_no_prompt_shows_what_only_scripted_models_may_read(file: Path):
    text = file.read_text(encoding="utf-8")
    expressions = " ".join(re.findall(r"\{[{%].*?[}%]\}", text))
    assert [key for key in SECRET if re.search(rf"\b{key}\b", expressions)] == []
