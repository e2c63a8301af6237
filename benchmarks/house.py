"""Draws the house: its rooms with their files and lines, who imports whom, and what imports itself by way of others.

    python benchmarks/house.py [ROOT]

Everything is read from the source below ROOT, imports inside functions and for type checkers included; nothing is run.
"""

import argparse
import ast
import statistics
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import networkx

PACKAGES = ("foundry", "analysis", "viewer", "hydra_plugins")


@dataclass(frozen=True)
class Module:
    """One file: its full name, its room, its lines, and the modules of ours that it names in imports."""

    name: str
    room: str
    lines: int
    imports: frozenset[str]


def read(root: Path) -> list[Module]:
    """Return the modules of the house."""
    files = {_name(file, root): file for package in PACKAGES for file in sorted((root / package).rglob("*.py"))}
    found = []
    for name, file in files.items():
        text = file.read_text(encoding="utf-8")
        imports = frozenset(one for one in _imported(ast.parse(text), files) if one != name)
        found.append(Module(name, file.parent.relative_to(root).as_posix(), len(text.splitlines()), imports))
    return found


def _name(file: Path, root: Path) -> str:
    parts = file.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(tree: ast.AST, known: dict[str, Path]) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            full = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [one if one in known else str(node.module) for one in full]
        else:
            continue
        yield from (one for one in names if one in known)


def _wing(name: str) -> str:
    """Return the part of the house that a module is in: a package, or a room right below `foundry`."""
    parts = name.split(".")
    return ".".join(parts[:2]) if parts[0] == "foundry" else parts[0]


def print_rooms(modules: list[Module]) -> None:
    """Print a line a room: files, lines, and the longest file."""
    rooms: dict[str, list[Module]] = defaultdict(list)
    for one in modules:
        rooms[one.room].append(one)
    print(f"{'room':44} files  lines  longest")
    for room, inside in sorted(rooms.items()):
        print(f"{room:44} {len(inside):5}  {sum(one.lines for one in inside):5}  {max(one.lines for one in inside):7}")
    lines = [one.lines for one in modules if one.lines > 1]
    print(f"{'in all':44} {len(modules):5}  {sum(lines):5}  {max(lines):7}   median {statistics.median(lines):.0f}")


def print_imports(modules: list[Module]) -> None:
    """Print which wings each wing imports of, with the number of imports."""
    wings: dict[str, Counter[str]] = defaultdict(Counter)
    for one in modules:
        wings[_wing(one.name)].update(_wing(other) for other in one.imports)
    print("\nimports")
    for wing, others in sorted(wings.items()):
        outside = ", ".join(f"{other} {count}" for other, count in others.most_common() if other != wing)
        print(f"{wing:28} {outside or '-'}")


def print_circles(modules: list[Module]) -> None:
    """Print the modules that import themselves by way of others."""
    graph = networkx.DiGraph([(one.name, other) for one in modules for other in one.imports])
    circles = sorted(sorted(circle) for circle in networkx.strongly_connected_components(graph) if len(circle) > 1)
    print(f"\ncircles: {len(circles)}, of {sum(map(len, circles))} modules")
    for circle in circles:
        print(f"  {', '.join(circle)}")


def main() -> None:
    """Read the command line and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).parents[1])
    modules = read(parser.parse_args().root)
    print_rooms(modules)
    print_imports(modules)
    print_circles(modules)


if __name__ == "__main__":
    main()
