"""A search of ten million words: how long the index takes, how large it is, how soon hits are there."""

from __future__ import annotations

import sys
import time

from measuring import at_most, print_table, print_title, scratch
from synthetic import sweep, write_run

from foundry.viewer.search import Query, TextSearch

RUNS, AGENTS, STEPS = 20, 10, 52
ASKED = [
    ("every", "nowhere", "a word that is not there"),
    ("every", "prompt", "a word of every prompt"),
    ("every", '"each line of a prompt"', "a phrase of every prompt"),
    ("message", "agent", "a word of every prompt, in messages alone"),
    ("reply", "step say", "two words of every message, in replies"),
    ("every", '"prompt each"', "words of every prompt that never follow each other"),
    ("memory", "prompt", "a word of every prompt, of no memory"),
    ("every", "pro*", "the beginning of a word"),
]


def main() -> None:
    with scratch() as folder:
        made = sweep(folder / "texts", agents=AGENTS, steps=STEPS, seeds=RUNS)
        for run in made.runs():
            write_run(run)
        words = sum(
            len(text.split())
            for run in made.runs()
            for one in run.calls()
            for text in (one.messages[0]["content"], one.text)
        )
        search, started = TextSearch(made), time.perf_counter()
        while (found := search.find(Query("every", "nowhere")))["indexed"] < found["runs"]:
            time.sleep(0.05)
        indexed = time.perf_counter() - started
        search.close()
        size = made.search_file.stat().st_size / 1e6
        print_title(
            "Search", f"{words / 1e6:.1f} million words in {RUNS} runs, indexed in {indexed:.0f} s, {size:,.0f} MB."
        )
        rows = []
        for kind, asked, what in ASKED:
            started = time.perf_counter()
            hits = search.find(Query(kind, asked))["count"]
            took = time.perf_counter() - started
            rows.append([what, f"{hits:,}", f"{took:.3f} s", *at_most(took, 1, "s")])
        print_table(["search", "hits", "took", "target", ""], rows)


if __name__ == "__main__":
    sys.exit(main())
