"""The Python in the documentation runs as it stands."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from foundry import paths
from walkers import WORLD, make_condition, write_sweep

ROOT = paths.PACKAGE.parent
OTHERS = "publish.md"
"""Its snippets need other people's libraries: tests/exporting runs them."""
PAGES = [page for folder in (ROOT / "docs", ROOT) for page in sorted(folder.glob("*.md")) if page.name != OTHERS]
FENCED = re.compile(r"(?ms)^```(\w*)\n(.*?)^```")
INDENTED = re.compile(r"(?m)(?:^    .*\n(?:[ \t]*\n(?=    ))*)+")
PYTHON = re.compile(r"\s*(from \w|import \w|>>> |with open|async def |def )")


def snippets(text: str) -> Iterator[str]:
    """Yield the pieces of Python of a page: fenced as such, or indented and beginning like Python."""
    yield from (code for language, code in FENCED.findall(text) if language == "python")
    for block in INDENTED.findall(FENCED.sub("", text)):
        if PYTHON.match(block):
            yield re.sub(r"(?m)^    ", "", block)


FOUND = [(page.name, code) for page in PAGES for code in snippets(page.read_text(encoding="utf-8"))]


def test_snippets_are_found():
    assert list(snippets("A:\n\n    from a import b\n\n    b()\n\nText\n\n    foundry plan\n")) == [
        "from a import b\n\nb()\n"
    ]
    assert list(snippets("```python\nprint()\n```\n")) == ["print()\n"]
    assert "python.md" in [name for name, _ in FOUND]


@pytest.mark.slow
@pytest.mark.parametrize(("page", "code"), FOUND, ids=[name for name, _ in FOUND])
def test_a_snippet_runs_in_a_folder_with_a_sweep(page, code, workspace):
    world = {**WORLD, "agents": 3, "steps": 6}
    write_sweep(Path("outputs/pilot"), [make_condition(model, range(2), world=world) for model in ("a", "b")])
    exec(compile(code, page, "exec"), {"__file__": page, "__name__": "snippet"})
