"""Calls per second of a sweep whose answers are all in the cache, beside SQLite look-ups of the same keys alone."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from pathlib import Path

from measuring import Swept, at_least, cost_of, fastest, print_table, print_title, run_sweep, scratch, server

AGENTS, STEPS, RUNS = 20, 15, 40
REPEATS = 3


def sweep(folder: Path, url: str, workers: int) -> Swept:
    """Run the sweep into a fresh folder; the cache stands beside it."""
    return run_sweep(
        folder,
        f"model.server.hosts='{url}'",
        "model.server.in_flight={min: 64, max: 64, initial: 64}",
        f"world.agents={AGENTS}",
        f"world.steps={STEPS}",
        f"seed=0-{RUNS - 1}",
        f"runner.workers={workers}",
    )


def cached(folder: Path, url: str, workers: int) -> Swept:
    """Run the sweep with a warm cache several times; return the fastest."""
    done = [sweep(folder / f"cached-{workers}-{number}", url, workers) for number in range(REPEATS)]
    if any(one.cached != one.calls for one in done):
        raise RuntimeError("Calls went to the server although the cache is warm.")
    return min(done, key=lambda one: one.running.wall_s)


def lookups_per_s(path: Path, keys: Sequence[str], at_once: int) -> float:
    """Return how many replies a second SQLite gives for these keys, nothing else done with them."""
    database = sqlite3.connect(path)
    marks = ",".join("?" * at_once)
    query = f"SELECT key, reply FROM answers WHERE key IN ({marks})"

    def look_up() -> None:
        for start in range(0, len(keys), at_once):
            if len(database.execute(query, keys[start : start + at_once]).fetchall()) != at_once:
                raise RuntimeError("Answers are missing.")

    try:
        return len(keys) / fastest([cost_of(look_up) for _ in range(REPEATS)]).wall_s
    finally:
        database.close()


def row(name: str, calls: int, per_s: float, cpu_s: float | None, baseline: float) -> list[str]:
    per_cpu_s = "" if cpu_s is None else f"{calls / cpu_s:,.0f}"
    return [name, f"{calls:,}", f"{per_s:,.0f}", per_cpu_s, f"{per_s / baseline:.3f}"]


def main() -> None:
    print_title(
        "Cached sweeps",
        f"{RUNS} runs of {AGENTS} agents and {STEPS} steps: paid once (server without latency), then run again into",
        f"other folders. Best of {REPEATS}. Ratios are to SQLite alone with {AGENTS} keys at a time, as in a round.",
    )
    with scratch() as folder, server(0) as to:
        paid = sweep(folder / "paid", to.url, workers=1)
        one, two = cached(folder, to.url, workers=1), cached(folder, to.url, workers=2)
        keys = [call.key for run in one.folder.runs() for call in run.calls()]
        singly, together = (lookups_per_s(folder / "answers.sqlite", keys, at_once) for at_once in (1, AGENTS))
    per_s = one.calls / one.running.wall_s
    all_in, once_begun = two.calls / two.running.wall_s, two.per_s_once_begun(2)
    rows = [
        row("SQLite alone, one key at a time", len(keys), singly, None, together),
        row(f"SQLite alone, {AGENTS} keys at a time", len(keys), together, None, together),
        row("foundry, paid", paid.calls, paid.calls / paid.running.wall_s, paid.running.cpu_s, together),
        row("foundry, cached, 1 worker", one.calls, per_s, one.running.cpu_s, together),
        row("foundry, cached, 2 workers, their start included", two.calls, all_in, None, together),
        row("foundry, cached, 2 workers, once a first run has ended", two.calls, once_begun, None, together),
    ]
    print_table(["what", "calls", "calls/s", "calls per CPU second", "ratio"], rows)
    target = [["calls/s per core with 1 worker", f"{per_s:,.0f}", *at_least(per_s, 5000, "")]]
    print_table(["foundry, cached", "measured", "target", ""], target)


if __name__ == "__main__":
    main()
