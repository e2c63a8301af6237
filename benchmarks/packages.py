"""Prints the folders of code with their files and lines, the imports between packages, and cycles of imports.

    python benchmarks/packages.py [ROOT]

Reads the source below ROOT, also imports inside functions and for type checkers, and runs nothing.
"""

import argparse
import ast
import statistics
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import networkx

ROOTS = ("foundry", "analysis", "hydra_plugins")


@dataclass(frozen=True)
class Module:
    """A Python file: its full name, its folder, its number of lines, and the project's modules that it imports."""

    name: str
    folder: str
    lines: int
    imports: frozenset[str]


def read(root: Path) -> list[Module]:
    """Return all modules of the project."""
    files = {_name(file, root): file for package in ROOTS for file in sorted((root / package).rglob("*.py"))}
    modules = []
    for name, file in files.items():
        text = file.read_text(encoding="utf-8")
        imports = frozenset(_imported(ast.parse(text), files)) - {name}
        modules.append(Module(name, file.parent.relative_to(root).as_posix(), len(text.splitlines()), imports))
    return modules


def _name(file: Path, root: Path) -> str:
    parts = file.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(tree: ast.AST, known: dict[str, Path]) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            full_names = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in known else str(node.module) for name in full_names]
        else:
            continue
        yield from (name for name in names if name in known)


def _package(module: str) -> str:
    """Return the package that contains a module: a package directly below `foundry`, or a top-level package."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] == "foundry" else parts[0]


def print_folders(modules: list[Module]) -> None:
    """Print a row per folder: its files, its lines, and the lines of its longest file."""
    by_folder: dict[str, list[int]] = defaultdict(list)
    for module in modules:
        by_folder[module.folder].append(module.lines)
    print(f"{'folder':44} files  lines  longest")
    for folder, lines in sorted(by_folder.items()):
        print(f"{folder:44} {len(lines):5}  {sum(lines):5}  {max(lines):7}")
    lines = [module.lines for module in modules if module.lines > 1]
    print(f"{'total':44} {len(modules):5}  {sum(lines):5}  {max(lines):7}   median {statistics.median(lines):.0f}")


def print_imports(modules: list[Module]) -> None:
    """Print the packages that each package imports from, with the number of imports."""
    imports: dict[str, Counter[str]] = defaultdict(Counter)
    for module in modules:
        imports[_package(module.name)].update(map(_package, module.imports))
    print("\nimports")
    for package, counts in sorted(imports.items()):
        most_first = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
        others = ", ".join(f"{other} {count}" for other, count in most_first if other != package)
        print(f"{package:28} {others or '-'}")


def print_cycles(modules: list[Module]) -> None:
    """Print the groups of modules that import each other in a cycle."""
    graph = networkx.DiGraph([(module.name, other) for module in modules for other in module.imports])
    cycles = sorted(sorted(names) for names in networkx.strongly_connected_components(graph) if len(names) > 1)
    print(f"\ncycles of imports: {len(cycles)}, with {sum(map(len, cycles))} modules")
    for names in cycles:
        print(f"  {', '.join(names)}")


def main() -> None:
    """Read the command line and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).parents[1])
    modules = read(parser.parse_args().root)
    print_folders(modules)
    print_imports(modules)
    print_cycles(modules)


if __name__ == "__main__":
    main()
