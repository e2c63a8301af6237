"""The direction of the imports, read from the source."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from foundry import paths

ROOT = paths.PACKAGE.parent
PACKAGES = ("foundry", "analysis", "viewer", "hydra_plugins")
LEAVES = {"foundry.errors", "foundry.paths", "foundry.seeding", "foundry.records", "foundry.texts"}
BASES = LEAVES | {"foundry", "foundry.worlds.base", "foundry.models.base"}


def modules(folder: str) -> list[Path]:
    return sorted((ROOT / folder).rglob("*.py"))


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            is_package = node.module in ("foundry", "foundry.worlds", "foundry.models")
            yield from names if is_package else [node.module or ""]
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def ours(path: Path) -> set[str]:
    return {name for name in imports(path) if name.split(".")[0] in PACKAGES}


def is_command(path: Path) -> bool:
    return path.parent == ROOT / "foundry" / "commands"


@pytest.mark.parametrize("name", ["errors", "paths", "seeding", "records", "texts"])
def test_leaves_import_nothing_of_ours(name: str):
    assert ours(ROOT / "foundry" / f"{name}.py") == set()


@pytest.mark.parametrize("layer", ["worlds", "models", "prompts"])
def test_worlds_models_and_prompts_never_import_each_other(layer: str):
    for path in modules(f"foundry/{layer}"):
        foreign = {name for name in ours(path) if name not in BASES and not name.startswith(f"foundry.{layer}")}
        allowed = {"foundry.store"} if path.name == "replay.py" else set()  # its answers are a recorded sweep's
        assert foreign <= allowed, f"{path} imports {foreign}"


def test_analysis_reads_records_and_the_store_only():
    reading = {*LEAVES, "foundry.store", "foundry.unread"}
    for path in modules("analysis"):
        foreign = {n for n in ours(path) if n.startswith("foundry") and n not in reading}
        assert foreign == set(), f"{path} imports {foreign}"


def test_the_viewer_reads_records_and_the_store_only():
    for path in modules("viewer"):
        foreign = {name for name in ours(path) if not name.startswith("viewer")} - {*LEAVES, "foundry.store"}
        assert foreign == set() or path.name == "scene_export.py", f"{path} imports {foreign}"


def test_only_commands_import_analysis_and_the_viewer_and_only_when_they_are_used():
    for path in modules("foundry"):
        names = {name for name in ours(path) if name.split(".")[0] in ("analysis", "viewer")}
        assert not names or is_command(path), f"{path} imports {names}"
        top = ast.parse(path.read_text(encoding="utf-8")).body
        assert not any(isinstance(n, ast.ImportFrom) and n.module in ("analysis", "viewer") for n in top)


def test_only_commands_print():
    for path in [path for folder in PACKAGES for path in modules(folder)]:
        calls = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Call)]
        printing = [node for node in calls if isinstance(node.func, ast.Name) and node.func.id == "print"]
        assert not printing or is_command(path), f"{path} prints"


@pytest.mark.parametrize("folder", PACKAGES)
def test_no_file_is_longer_than_500_lines(folder: str):
    long = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in modules(folder)}
    assert {name: lines for name, lines in long.items() if lines > 500} == {}
