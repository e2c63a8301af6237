"""Long texts: what a page makes of them grows as they do, and no more."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from foundry.storing.store import SweepFolder
from foundry.viewer.server import serving
from made_up_runs import sweep, whole_run
from viewer_pages import go

pytestmark = pytest.mark.browser

LONG = 240_000
PARTS = ("smoke and fire ", "x\u00e9", "go\n", "=== WHAT IS NEAR ===\nNobody.\n", '[{"a": [')
"""Words, one endless word, lines, headings, brackets."""
MADE = """() => {
  const nodes = document.createTreeWalker(document.getElementById('main'), NodeFilter.SHOW_ALL);
  let count = 0, signs = 0, longest = 0;
  for (; nodes.nextNode(); count += 1) {
    if (nodes.currentNode.nodeType !== Node.TEXT_NODE) continue;
    signs += nodes.currentNode.data.length;
    longest = Math.max(longest, ...nodes.currentNode.data.split(/\\s/, 1000).map((word) => word.length));
  }
  return {count, signs, longest};
}"""


def made_of(folder: Path, size: int) -> SweepFolder:
    """Write two models whose prompts and replies are so long, and messages and memories a tenth of it."""
    text = "".join(part * (size // len(part) // len(PARTS)) for part in PARTS)
    made = sweep(folder / f"long{size}", seeds=(0,), agents=3, steps=2)
    for number, run in enumerate(made.runs()):
        said = text[: size // 10]
        whole_run(run, lambda step, agent, said=said: {"message": said, "memory": said}, f"{number}{text}", f" {text}")
    return made


def opened(page: Any, made: SweepFolder, address: str) -> dict[str, float]:
    """Open a page and every text on it; return nodes, signs and the longest word without a place to break it."""
    with serving(made.path) as server:
        go(page, server.url, f"{address}?step=2&agent=1")
        page.wait_for_selector("details[data-kind=action], [data-text]")
        page.evaluate("() => document.querySelectorAll('details.call > summary').forEach((one) => one.click())")
        page.wait_for_selector(".quote", state="attached")
        found: dict[str, float] = page.evaluate(MADE)
        page.goto("about:blank")
    return found


@pytest.mark.parametrize("what", ["run", "compare"])
def test_what_a_page_makes_of_a_text_grows_as_the_text_does(page: Any, tmp_path: Path, what: str):
    found = []
    for size in (LONG // 4, LONG):
        made = made_of(tmp_path, size)
        runs = [run.id for run in made.runs()]
        found.append(opened(page, made, "/".join([what, made.path.name, *runs[: 1 if what == "run" else 2]])))
    small, large = found
    assert large["signs"] > 4 * LONG, "prompts and replies of two questions"
    assert large["count"] <= 4.2 * small["count"]
    assert large["longest"] == 256, "finding the breaks of one long part takes seconds"
