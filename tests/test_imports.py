"""The direction of the imports, read from the source: those inside functions and those for type checkers too."""

import ast
import graphlib
import symtable
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from foundry import paths

ROOT = paths.PACKAGE.parent
PACKAGES = ("foundry", "analysis", "hydra_plugins")
LAYERS = {
    "leaves": ("errors", "paths", "seeding", "records", "texts", "naming", "declared", "own_code", "leaving",
               "version", "palette", "canary", "certainty"),
    "parts": ("worlds", "models", "prompts"),
    "episode": ("episode",),
    "storing": ("expansion", "storing", "provenance"),
    "running": ("running",),
    "using": ("composing", "display", "labels", "trust", "doctor", "replay", "viewer", "conformance", "calling",
              "new_parts", "validating", "probing", "exporting"),
    "commands": ("commands", "cli", "__main__"),
}  # fmt: skip
"""Modules and packages of foundry, each of which imports of its own layer or of one further up in this list."""
MOST_FILES, MOST_LINES = 20, 500
"""What a folder and a file hold at most."""
FRONT = "foundry"
"""The package itself: it names what programs use, and imports each name when it is first asked for."""
MEASURING = {
    FRONT,
    "foundry.conformance.signatures",
    "foundry.new_parts.signature.signatures.part_name",
    "foundry.validating.playing",
}
"""What else may import the analysis when it is used: checks of signatures, and what a signature begins with."""
BASES = {"foundry.worlds.base", "foundry.models.base"}
LEAVES = {f"foundry.{name}" for name in (*LAYERS["leaves"], "palette.fonts", "seeding.positions")}


def files(folder: str) -> list[Path]:
    return sorted((ROOT / folder).rglob("*.py"))


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for folder in PACKAGES for path in files(folder)}


def called(node: ast.Call) -> str:
    return str(getattr(node.func, "attr", getattr(node.func, "id", "")))


def named(node: ast.AST) -> Iterator[str]:
    """Yield what a statement imports, a module of ours by its full name."""
    if isinstance(node, ast.ImportFrom):
        assert node.level == 0, "imports are written in full, which is what is read here"
        for alias in node.names:
            full = f"{node.module}.{alias.name}"
            yield full if full in MODULES else str(node.module)
    elif isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.Call) and called(node) in ("import_module", "resolve_name", "__import__"):
        yield from (str(arg.value) for arg in node.args if isinstance(arg, ast.Constant))


def ours(nodes: Iterator[ast.AST]) -> set[str]:
    return {name for node in nodes for name in named(node) if name.split(".")[0] in PACKAGES}


class Module(NamedTuple):
    """What the tests ask of a module; its tree is let go, because half a million nodes make each garbage search slow.

    Attributes:
        imports: what it imports of ours, inside functions too.
        at_once: what it imports of ours when it is imported.
    """

    imports: set[str]
    at_once: set[str]
    prints: bool


@cache
def modules() -> dict[str, Module]:
    """Return every module as it is written, read once and only where a test asks."""
    return {name: read(ast.parse(path.read_text(encoding="utf-8"))) for name, path in MODULES.items()}


def read(tree: ast.Module) -> Module:
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom | ast.Call)]
    prints = any(isinstance(node, ast.Call) and getattr(node.func, "id", "") == "print" for node in nodes)
    return Module(ours(iter(nodes)), ours(at_the_top(tree.body)), prints)


def imports() -> dict[str, set[str]]:
    return {name: module.imports for name, module in modules().items()}


def imports_of(package: str) -> dict[str, set[str]]:
    """Return what each module of a package imports of ours, at its top or anywhere in it."""
    return {name: texts for name, texts in imports().items() if is_in(name, package)}


def is_in(name: str, package: str) -> bool:
    return name == package or name.startswith(f"{package}.")


def layer_of(name: str) -> int:
    """Return the number of a module's layer; the longest name that holds it says."""
    places = [(len(one), number) for number, names in enumerate(LAYERS.values()) for one in names
              if is_in(name, f"foundry.{one}")]  # fmt: skip
    assert places, f"{name} stands in no layer: add it to LAYERS"
    return max(places)[1]


def at_the_top(nodes: list[ast.stmt]) -> Iterator[ast.AST]:
    """Yield what runs when a module is imported: nothing inside functions, nor what only type checkers see."""
    for node in nodes:
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            yield from at_the_top(node.orelse)
        elif not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node
            for inner in ("body", "orelse", "finalbody", "handlers"):
                yield from at_the_top(getattr(node, inner, []))


def storing(*names: str) -> set[str]:
    return {f"foundry.storing.{name}" for name in names}


READ = ("store", "standing", "matching", "preregistration", "probed")
CAMERA = {name for name in MODULES if is_in(name, "foundry.worlds.camera")}
ALLOWED = {
    **dict.fromkeys(sorted(LEAVES), {"foundry.errors"}),
    **dict.fromkeys(("foundry.records", "foundry.certainty"), {"foundry.errors", "foundry.canary"}),
    **{f"foundry.{part}": BASES | LEAVES for part in LAYERS["parts"]},
    "analysis": {
        *LEAVES,
        *storing(*READ, "determinism"),
        "foundry.worlds.compared",
        *(f"foundry.labels.{one}" for one in ("definition", "items", "sampling", "folder")),
        "foundry.labels",
    },  # fmt: skip
    "foundry.viewer": {*LEAVES, *storing(*READ, "notes")},
}
"""What a package imports beside itself: the analysis and the viewer read records and the store only."""
DRAWING = {
    "foundry.viewer.camera.scene_export": CAMERA,
    "foundry.viewer.camera.scenes": CAMERA,
    "foundry.viewer.camera.sights": {*CAMERA, "foundry.worlds.validation", "analysis.camera.sight_rule"},
    "foundry.viewer.any.drawing": {"foundry.replay.recording", "foundry.worlds.base"},
    "foundry.viewer.probe.probe_view": {"foundry.probing.seen"},
    "foundry.viewer.resources": {"analysis.findings.moments"},
}
"""What modules of the viewer import beside that."""


@pytest.mark.parametrize("package", ALLOWED)
def test_a_package_imports_itself_and_what_it_may(package: str):
    for name, texts in imports_of(package).items():
        foreign = {one for one in texts if not is_in(one, package)} - ALLOWED[package] - DRAWING.get(name, set())
        assert foreign == set(), f"{name} imports {foreign}"


def test_imports_within_foundry_point_down_only():
    up = {
        f"{name} imports {one}"
        for name, texts in imports_of("foundry").items()
        for one in texts
        if is_in(one, "foundry") and FRONT not in (one, name)
        if layer_of(one) > layer_of(name)
    }
    assert up == set()


def test_no_module_imports_itself_by_way_of_others():
    graph = {name: {one for one in texts if one in MODULES and one != name} for name, texts in imports().items()}
    graphlib.TopologicalSorter(graph).prepare()


def test_no_folder_holds_too_many_files_and_no_file_too_many_lines():
    files_by_folder = Counter(path.parent.relative_to(ROOT).as_posix() for path in MODULES.values())
    assert {folder for folder, number in files_by_folder.items() if number > MOST_FILES} == set()
    lines = {name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in MODULES.items()}
    assert {name for name, number in lines.items() if number > MOST_LINES} == set()


def is_upstairs(name: str) -> bool:
    """Return whether a module is none that a run needs."""
    return not is_in(name, "foundry") or is_in(name, "foundry.viewer")


def test_only_commands_import_analysis_and_the_viewer_and_only_when_they_are_used():
    for name, texts in imports_of("foundry").items():
        if is_in(name, "foundry.viewer"):
            continue
        upstairs = {one for one in texts if is_upstairs(one)}
        may = is_in(name, "foundry.commands") or name in MEASURING
        assert not upstairs or may, f"{name} imports {upstairs}"
        if is_in(name, "foundry.new_parts"):
            continue  # a user's own module, which is imported when it is used
        at_once = {our for our in modules()[name].at_once if is_upstairs(our)}
        assert at_once == set(), f"{name} imports {at_once} at its top"


def test_only_commands_print():
    for name, module in modules().items():
        assert not module.prints or is_in(name, "foundry.commands"), f"{name} prints"


def test_of_the_forms_the_analysis_knows_the_general_one_alone_and_forms_do_not_know_each_other():
    rooms = {name for name, path in MODULES.items() if is_in(name, "analysis") and "\nANALYSIS = " in path.read_text()}
    assert {"analysis.any", "analysis.camera", "analysis.grid", "analysis.rounds"} <= rooms
    for name, texts in imports_of("analysis").items():
        own = next((room for room in rooms if is_in(name, room)), None)
        others = rooms - {own, "analysis.any"}
        foreign = {one for one in texts if any(is_in(one, room) for room in others)}
        assert foreign == set(), f"{name} imports {foreign}"


@cache
def defined(module: str) -> set[str]:
    """Return what a module binds at its top, without importing it: some modules take seconds."""
    symbols = symtable.symtable(MODULES[module].read_text(encoding="utf-8"), module, "exec").get_symbols()
    return {symbol.get_name() for symbol in symbols if symbol.is_assigned() or symbol.is_imported()}


@pytest.mark.parametrize("script", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda script: script.stem)
def test_a_benchmark_imports_only_what_is_there(script: Path):
    for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (module := str(node.module)).partition(".")[0] in PACKAGES:
            lacking = {name.name for name in node.names if f"{module}.{name.name}" not in MODULES} - defined(module)
            assert lacking == set(), module


def test_no_two_modules_of_a_layer_have_one_name():
    plug_ins = {"signatures", "new_parts"}
    layers = [ROOT / "analysis", *(folder for folder in (ROOT / "foundry").iterdir() if folder.is_dir())]
    for layer in layers:
        modules = [file for file in layer.rglob("[!_]*.py") if not plug_ins.intersection(file.parts)]
        shared = [name for name, count in Counter(file.name for file in modules).items() if count > 1]
        assert shared == [], layer
