"""The viewer with a run of 1,000 agents over 500 steps and with a sweep of 2,000 runs."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from measuring import at_least, at_most, cost_of, print_table, print_title, scratch
from playwright.sync_api import Page, sync_playwright
from synthetic import summary, sweep, write_run, write_signatures

from foundry.records import Counts
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import SweepFolder
from foundry.viewer.resources import Resources
from foundry.viewer.server import serving

AGENTS, STEPS, RUNS = 1000, 500, 2000
PLAY_S = 6
FRAMES = """async (seconds) => {
  const clock = Foundry.page.clock, grid = Foundry.page.grid, draw = grid.redraw.bind(grid);
  let frames = 0, drawing = 0;
  grid.redraw = () => { const from = performance.now(); draw(); drawing += performance.now() - from; frames += 1; };
  clock.speed = 8;
  clock.play();
  const from = performance.now(), first = clock.position;
  await new Promise((resolve) => setTimeout(resolve, seconds * 1000));
  clock.pause();
  grid.redraw = draw;
  return {fps: frames / ((performance.now() - from) / 1000), draw_ms: drawing / frames, steps: clock.position - first};
}"""
READY = "() => window.Foundry?.page?.clock?.steps > 0 && Foundry.page.grid.spots"


@contextmanager
def browser() -> Iterator[Page]:
    """Start Chromium without a window and without a graphics card."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-precise-memory-info"]
        )
        try:
            yield chromium.new_page(viewport={"width": 1440, "height": 900})
        finally:
            chromium.close()


def big_run(folder: Path, agents: int, steps: int) -> SweepFolder:
    """Write one large run."""
    made = sweep(folder / f"run-{agents}-{steps}", agents=agents, steps=steps)
    write_run(made.runs()[0])
    return made


def answers(made: SweepFolder) -> list[list[Any]]:
    """Return how long each kind of question takes a server that has just been started, and how long its answer is."""
    resources = Resources(made.path)
    address = f"run/{resources.catalog.overview()[0]['id']}/{made.runs()[0].id}"
    view = resources.view(*address.split("/")[1:])
    last = (STEPS - 1) // view.steps_per_chunk
    asked = {
        "progress, the first time": "progress", "progress": "progress",
        "first frames": "frames/0", "last frames": f"frames/{last}",
        "marks of 100 steps": "marks/0", "way of an agent": "track/500", "texts of a chunk": "texts/5",
        "decisions at the start": "decisions/0/7", "decisions in the middle": "decisions/25/7",
        "decisions at the end": "decisions/49/7",
        "decisions, back at the start": "decisions/1/8",
    }  # fmt: skip
    rows = []
    for what, part in asked.items():
        started = time.perf_counter()
        content = resources.get(f"{address}/{part}").content
        rows.append([what, f"{1e3 * (time.perf_counter() - started):,.0f}", f"{len(content) / 1e3:,.0f}"])
    resources.close()
    return rows


def frames(page: Page, made: SweepFolder) -> dict[str, float]:
    """Return frames per second while a run plays."""
    with serving(made.path) as server:
        page.goto(f"{server.url}#/run/{server.resources.catalog.overview()[0]['id']}/{made.runs()[0].id}")
        page.wait_for_function(READY, timeout=60_000)
        page.wait_for_function("() => Foundry.page.data.marked === Foundry.page.data.done", timeout=60_000)
        found: dict[str, float] = page.evaluate(FRAMES, PLAY_S)
        found["heap_mb"] = page.evaluate("() => performance.memory.usedJSHeapSize / 1e6")
    return found


def overview(page: Page, folder: Path) -> dict[str, float]:
    """Return seconds until a sweep of many runs is shown, and to sort it."""
    made = sweep(folder / "many", agents=2, steps=2, models=4, seeds=RUNS // 4)
    for run in made.runs():
        RunWriter(run, "{}").close()
        write_run_summary(run, summary(run, Counts(outcomes={"chosen": 4})))
    write_signatures(made, 150)
    with serving(made.path) as server:
        started = time.perf_counter()
        page.goto(server.url)
        page.wait_for_function(
            f"() => document.querySelector('.shown')?.textContent.startsWith('{RUNS} of')", timeout=60_000
        )
        page.wait_for_selector("[data-sort^=signature_0]")
        shown = time.perf_counter() - started
        sort = page.evaluate(
            """async () => {
              const from = performance.now();
              document.querySelector('[data-sort^=signature_0]').click();
              await new Promise(requestAnimationFrame);
              return (performance.now() - from) / 1000;
            }"""
        )
    return {"shown": shown, "sort": float(sort)}


def main() -> None:
    print_title(
        "Viewer", f"{AGENTS} agents x {STEPS} steps, {RUNS} runs; Chromium draws in software, beside the server."
    )
    with scratch() as folder, browser() as page:
        written = cost_of(lambda: big_run(folder, AGENTS, STEPS)).wall_s
        made = SweepFolder.open(folder / f"run-{AGENTS}-{STEPS}")
        sizes = [f"{path.name} {path.stat().st_size / 1e6:,.0f} MB" for path in sorted(made.runs()[0].path.iterdir())]
        print(f"Written in {written:.0f} s: {', '.join(sizes)}\n", flush=True)
        print_table(["question", "ms", "kB before compression"], answers(made))
        large, small = frames(page, made), frames(page, big_run(folder, 20, 50))
        many = overview(page, folder)
    judged = [
        [
            f"frames/s, {AGENTS} agents",
            f"{large['fps']:.0f} (drawing {large['draw_ms']:.1f} ms)",
            *at_least(large["fps"], 30, ""),
        ],
        [
            "frames/s, 20 agents",
            f"{small['fps']:.0f} (drawing {small['draw_ms']:.1f} ms)",
            *at_least(small["fps"], 30, ""),
        ],
        [
            f"steps played in {PLAY_S} s at 8 a second",
            f"{large['steps']:.0f}",
            *at_least(large["steps"], 0.9 * 8 * PLAY_S, ""),
        ],
        ["memory of the page", f"{large['heap_mb']:.0f} MB", *at_most(large["heap_mb"], 300, "MB")],
        [f"{RUNS} runs shown", f"{many['shown']:.1f} s", *at_most(many["shown"], 5, "s")],
        [f"{RUNS} runs sorted", f"{many['sort']:.2f} s", *at_most(many["sort"], 0.5, "s")],
    ]
    print_table(["viewer", "measured", "target", ""], judged)


if __name__ == "__main__":
    sys.exit(main())
