"""Measures the viewer with a run of 1,000 agents over 500 steps, and with sweeps of 2,000, 10,000 and 100,000 runs."""

import resource
import shutil
import statistics
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
from loky import ProcessPoolExecutor
from measuring import at_least, at_most, cost_of, print_table, print_title, scratch
from playwright.sync_api import Page, sync_playwright
from synthetic import PROMPT, summary, sweep, write_run, write_signatures

from foundry.records import Counts
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder
from foundry.viewer.catalog import Catalog
from foundry.viewer.resources import Resources
from foundry.viewer.server import serving
from foundry.viewer.underway import underway

AGENTS, STEPS, RUNS, MOST_RUNS = 1000, 500, 2000, 100_000
LISTED, SHOWN_MEASURES = 20_000, 10
UNDERWAY, OPEN, LOOKS = 10_000, 64, 25
LONG_MB = 1.0
PLAY_S = 6
TOGETHER_S, TOGETHER_STEPS = 10, 200
MEMORY_S = 300
"""Seconds of playing at 30 steps per second, after which the memory of the page must not have grown."""
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
FIRST_ROWS = """
new MutationObserver((_, watching) => {
  if (!document.querySelector('tbody tr[data-run]')) return;
  watching.disconnect();
  requestAnimationFrame(() => requestAnimationFrame(() => { window.firstRows = performance.now() / 1000; }));
}).observe(document, {childList: true, subtree: true});
"""
OPENED = """async () => {
  document.querySelectorAll('details.call').forEach((one) => { one.open = true; });
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
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
    """Return the time of a new server for each kind of request, and the length of its answer."""
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


def last_decisions(made: SweepFolder) -> float:
    """Return the CPU seconds that a new server needs to send the decisions at the end of a run."""
    resources = Resources(made.path)
    address = f"run/{resources.catalog.overview()[0]['id']}/{made.runs()[0].id}"
    cost = cost_of(lambda: resources.get(f"{address}/decisions/{STEPS // 10 - 1}/7"))
    resources.close()
    return cost.cpu_s


def frames(page: Page, made: SweepFolder) -> dict[str, float]:
    """Return frames per second while a run plays."""
    with serving(made.path) as server:
        page.goto(f"{server.url}#/run/{server.resources.catalog.overview()[0]['id']}/{made.runs()[0].id}")
        page.wait_for_function(READY, timeout=60_000)
        page.wait_for_function("() => Foundry.page.data.marked === Foundry.page.data.done", timeout=60_000)
        measured: dict[str, float] = page.evaluate(FRAMES, PLAY_S)
        measured["heap_mb"] = page.evaluate("() => performance.memory.usedJSHeapSize / 1e6")
    return measured


TOGETHER = """async (seconds) => {
  const {clock, overlay} = Foundry.page, draw = overlay.redraw.bind(overlay);
  let frames = 0, drawn = 0, drawing = 0;
  overlay.redraw = () => { const from = performance.now(); draw(); drawing += performance.now() - from; drawn += 1; };
  clock.speed = 30;
  clock.seek(1);
  const from = performance.now();
  let before = 1, steps = 0;
  while (performance.now() - from < 1000 * seconds) {
    clock.play(); // from the beginning again behind the last step
    await new Promise(requestAnimationFrame);
    frames += 1;
    steps += Math.max(0, clock.position - before);
    before = clock.position;
  }
  clock.pause();
  delete overlay.redraw;
  return {fps: frames / seconds, draw_ms: drawing / drawn, steps};
}"""
STEPPED = """async (steps) => {
  const {clock} = Foundry.page;
  for (let step = 0; step < steps; step += 1) {
    const wanted = 1 + step % clock.steps;
    while (!clock.isReady(wanted)) await new Promise(requestAnimationFrame);
    clock.seek(wanted);
    if (step % 10 === 0) await new Promise(requestAnimationFrame);
  }
}"""


def together(page: Page, folder: Path, agents: int, steps: int) -> dict[str, float]:
    """Return frames per second while two runs play on one heat map, and the page's memory before and after."""
    made = sweep(folder / "together", agents=agents, steps=steps, models=2)
    for run in made.runs():
        write_run(run)
    with serving(made.path) as server:
        sweep_id = server.resources.catalog.overview()[0]["id"]
        page.goto(f"{server.url}#/compare/{sweep_id}/{'/'.join(run.id for run in made.runs())}")
        page.get_by_role("checkbox", name="all on one map").check(timeout=60_000)
        page.wait_for_function("() => window.Foundry?.page?.overlay?.spots?.length", timeout=60_000)
        page.select_option("[aria-label='Steps drawn as']", "-1")
        page.wait_for_function("() => Foundry.page.overlay.ways[1].size", timeout=60_000)
        page.evaluate(STEPPED, steps)  # once through, so that nothing is met for the first time
        measured: dict[str, float] = page.evaluate(TOGETHER, TOGETHER_S)
        before = _heap_mb(page)
        page.evaluate(STEPPED, MEMORY_S * 30)
        return measured | {"before_mb": before, "after_mb": _heap_mb(page)}


def _heap_mb(page: Page) -> float:
    """Return the memory of the page, MB, after garbage collection."""
    page.context.new_cdp_session(page).send("HeapProfiler.collectGarbage")
    return float(page.evaluate("() => performance.memory.usedJSHeapSize / 1e6"))


def many_runs(folder: Path, runs: int) -> SweepFolder:
    """Write a sweep of many short runs, with the tables of an analysis."""
    made = sweep(folder / f"many-{runs}", agents=2, steps=2, models=4, seeds=runs // 4)
    _end(made.runs())
    write_signatures(made, 150)
    return made


def listed_mb(folder: Path) -> float:
    """Return the greatest memory, MB, of a server that lists many runs with their measures."""
    made = many_runs(folder, LISTED)
    with ProcessPoolExecutor(max_workers=1) as pool:
        return pool.submit(_peak_mb, made.path).result()


def _peak_mb(path: Path) -> float:
    resources = Resources(path)
    address = f"sweep/{resources.catalog.overview()[0]['id']}"
    head = msgspec.json.decode(resources.get(address).content)
    pages = -(-head["runs"] // head["rows_per_page"])
    parts = ["groups", "underway", *(f"rows/{page}" for page in range(pages))]
    for part in [*parts, *(f"measure/{number}" for number in range(SHOWN_MEASURES))]:
        resources.get(f"{address}/{part}")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def overview(page: Page, folder: Path, runs: int) -> dict[str, float]:
    """Return the seconds until the page shows the first run, until it shows all runs, and to sort the runs."""
    with serving(many_runs(folder, runs).path) as server:
        page.add_init_script(FIRST_ROWS)
        started = time.perf_counter()
        page.goto(server.url)
        page.wait_for_function("() => window.firstRows")
        page.wait_for_function(
            f"() => document.querySelector('.shown')?.textContent.startsWith('{runs} of')", timeout=120_000
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
        first = page.evaluate("() => window.firstRows")
    return {"first": float(first), "shown": shown, "sort": float(sort)}


def looks(folder: Path) -> float:
    """Return the median seconds of later requests for the progress of a large sweep that is half complete."""
    made = sweep(folder / "underway", agents=2, steps=6, models=4, seeds=UNDERWAY // 4)
    ended, opened = made.runs()[: UNDERWAY // 2], made.runs()[UNDERWAY // 2 :][:OPEN]
    _end(ended)
    for run in opened:
        RunWriter(run, "{}").close()
    made.start_progress()
    report = {"open": [run.id for run in opened], "most": {}, "counts": {}, "models": {}}
    made.progress_file("0-0").write_bytes(msgspec.json.encode(report))
    shown = Catalog(made.path).sweeps()[0]
    while sum(underway(shown)["counts"].values()) < UNDERWAY:
        pass
    return statistics.median(cost_of(lambda: underway(shown)).wall_s for _ in range(LOOKS))


def long_texts(page: Page, folder: Path, size_mb: float) -> float:
    """Return the seconds from opening a decision until the page shows its two prompts of the given size."""
    made = sweep(folder / f"long-{size_mb}", agents=2, steps=1)
    write_run(made.runs()[0], PROMPT + int(1e6 * size_mb / 50) * "A line of a prompt is about as long as this one.\n\n")
    with serving(made.path) as server:
        page.goto("about:blank")
        started = time.perf_counter()
        page.goto(f"{server.url}#/run/{server.resources.catalog.overview()[0]['id']}/{made.runs()[0].id}?agent=0")
        page.wait_for_selector("details[data-kind=action]", timeout=60_000)
        page.evaluate(OPENED)
        return time.perf_counter() - started


def _end(runs: Sequence[RunFolder]) -> None:
    for run in runs:
        RunWriter(run, "{}").close()
        write_run_summary(run, summary(run, Counts(outcomes={"chosen": 4})))


def drawn(what: str, seen: Mapping[str, float], least: float) -> list[str]:
    """Return the table row for a page's frames per second, with the required minimum."""
    return [
        f"frames/s, {what}",
        f"{seen['fps']:.0f} (drawing {seen['draw_ms']:.1f} ms)",
        *at_least(seen["fps"], least, ""),
    ]


def main() -> None:
    print_title(
        "Viewer",
        f"{AGENTS} agents x {STEPS} steps, {RUNS}, {UNDERWAY} and {MOST_RUNS} runs; Chromium draws in software, beside "
        "the server.",
    )
    with scratch() as folder, browser() as page:
        written = cost_of(lambda: big_run(folder, AGENTS, STEPS)).wall_s
        made = SweepFolder.open(folder / f"run-{AGENTS}-{STEPS}")
        sizes = [f"{path.name} {path.stat().st_size / 1e6:,.0f} MB" for path in sorted(made.runs()[0].path.iterdir())]
        print(f"Written in {written:.0f} s: {', '.join(sizes)}\n", flush=True)
        print_table(["question", "ms", "kB before compression"], answers(made))
        last_s = last_decisions(made)
        large, small = frames(page, made), frames(page, big_run(folder, 20, 50))
        short_s, long_s = (long_texts(page, folder, size_mb) for size_mb in (LONG_MB / 4, LONG_MB))
        both = together(page, folder, AGENTS, TOGETHER_STEPS)
        many, most, look_s = overview(page, folder, RUNS), overview(page, folder, MOST_RUNS), looks(folder)
        server_mb = listed_mb(folder)
    judged = [
        [f"decisions at step {STEPS}, the first question", f"{last_s:.2f} s of CPU", *at_most(last_s, 0.3, "s")],
        drawn(f"{AGENTS} agents", large, 30),
        drawn("20 agents", small, 30),
        [
            f"steps played in {PLAY_S} s at 8 a second",
            f"{large['steps']:.0f}",
            *at_least(large["steps"], 0.9 * 8 * PLAY_S, ""),
        ],
        drawn(f"two runs of {AGENTS} agents on one map with heat, 30 steps/s", both, 60),
        [
            f"steps played there in {TOGETHER_S} s",
            f"{both['steps']:.0f}",
            *at_least(both["steps"], 0.9 * 30 * TOGETHER_S, ""),
        ],
        [
            f"memory of that page after {MEMORY_S * 30} steps",
            f"{both['before_mb']:.0f} MB, then {both['after_mb']:.0f} MB",
            *at_most(both["after_mb"], 1.05 * both["before_mb"], "MB"),
        ],
        ["memory of the page", f"{large['heap_mb']:.0f} MB", *at_most(large["heap_mb"], 300, "MB")],
        [
            f"prompts of {LONG_MB:.0f} MB opened",
            f"{long_s:.2f} s",
            *at_most(long_s, 4 * short_s, "s, 4 times a quarter"),
        ],
        [f"{LISTED} runs listed", f"{server_mb:.0f} MB of the server", *at_most(server_mb, 1000, "MB")],
        [f"{RUNS} runs shown", f"{many['shown']:.1f} s", *at_most(many["shown"], 5, "s")],
        [f"what {UNDERWAY} runs are doing", f"{1e3 * look_s:.0f} ms a look", *at_most(look_s, 0.05, "s")],
        [f"{RUNS} runs sorted", f"{many['sort']:.2f} s", *at_most(many["sort"], 0.5, "s")],
        [f"first of {MOST_RUNS} runs painted", f"{most['first']:.2f} s", *at_most(most["first"], 0.3, "s")],
        [f"{MOST_RUNS} runs shown", f"{most['shown']:.1f} s", *at_most(most["shown"], 5, "s")],
        [f"{MOST_RUNS} runs sorted", f"{most['sort']:.2f} s", *at_most(most["sort"], 0.5, "s")],
    ]
    print_table(["viewer", "measured", "target", ""], judged)


if __name__ == "__main__":
    sys.exit(main())
