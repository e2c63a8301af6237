"""What the documents say of the house is true: every file and folder of it that they name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from foundry import paths

ROOT = paths.PACKAGE.parent
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "tests" / "README.md"])
ROOMS = "foundry|analysis|conf|sweeps|assets|benchmarks|hydra_plugins|tests|docs|examples"
NAMED = re.compile(rf"`((?:{ROOMS})/[\w./-]*)`")
PATTERN = re.compile(rf"`((?:{ROOMS})/[\w./<>*-]*[<*][\w./<>*-]*)`")
WRITTEN = re.compile(r"analysis/[\w-]+\.(?:csv|json|sqlite|parquet|tex|md)|analysis/(?:plots|replay)/?")
"""Files that the analysis writes into a sweep's folder."""


@pytest.mark.parametrize("document", [one for one in DOCUMENTS if one.name != "CHANGELOG.md"], ids=lambda one: one.name)
def test_every_file_that_a_document_names_is_there(document: Path):
    text = document.read_text(encoding="utf-8")
    named = {name for name in NAMED.findall(text) if not WRITTEN.fullmatch(name)}
    assert {name for name in named if not (ROOT / name).exists()} == set()
    patterns = {re.sub(r"<\w+>", "*", one) for one in PATTERN.findall(text) if not WRITTEN.match(one)}
    assert {one for one in patterns if not any(ROOT.glob(one.rstrip("/")))} == set()


def test_the_architecture_names_every_room_and_every_file_at_the_top():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    house = ROOT / "foundry"
    rooms = [f"foundry/{one.relative_to(house)}/" for one in (*house.iterdir(), *(house / "worlds").iterdir())
             if any(one.glob("*.py"))]  # fmt: skip
    files = [one.name for one in house.glob("*.py") if not one.name.startswith("__")]
    missing = [one for one in (*rooms, *files) if one not in text]
    assert missing == []
