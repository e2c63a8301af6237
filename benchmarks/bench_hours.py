"""Compares the hours that a plan prints with the hours that the sweep takes, on five simulated servers, in seconds."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from measuring import Server, print_table, print_title, run_sweep, scratch, serving

AGENTS, STEPS = 20, 5
CALLS_PER_RUN = 2 * AGENTS * STEPS


@dataclass(frozen=True)
class Kind:
    """A simulated server (settings of `slots_server.py`), and the runs of a sweep that calls it."""

    name: str
    settings: str
    runs: int


KINDS = (
    Kind("1 slot, even replies", "--slots=1 --mean=0.05 --spread=0", 2),
    Kind("4 slots, even replies", "--slots=4 --mean=0.1 --spread=0", 4),
    Kind("8 slots, uneven replies", "--slots=8 --mean=0.2 --spread=0.8", 4),
    Kind("4 slots, slow to read prompts", "--slots=4 --mean=0.03 --prompt-s=0.03", 4),
    Kind("4 slots, loads for 3 s", "--slots=4 --mean=0.1 --load=3", 4),
)


def asked(kind: Kind, to: Server) -> list[str]:
    sizes = [f"world.agents={AGENTS}", f"world.steps={STEPS}", f"seed=0-{kind.runs - 1}", "runner.workers=1"]
    return ["model=llama3.2", f"model.server.hosts='{to.url}'", *sizes]


def told_s(kind: Kind, folder: Path) -> float:
    """Return the seconds that a plan prints after its few calls to a new server."""
    with serving("slots_server.py", *kind.settings.split()) as to:
        command = [sys.executable, "-m", "foundry", "plan", "--time", "--json", "-m", *asked(kind, to)]
        done = subprocess.run(command, cwd=folder, check=True, capture_output=True)
    (timed,) = json.loads(done.stdout)["timed"]
    assert timed["calls"] == kind.runs * CALLS_PER_RUN
    return float(timed["calls"] * timed["per_call_s"])


def taken_s(kind: Kind, folder: Path) -> float:
    """Return the seconds that the sweep takes on a new server, with an empty cache and foundry's own limit."""
    with serving("slots_server.py", *kind.settings.split()) as to:
        return run_sweep(folder / "sweep", *asked(kind, to)).running.wall_s


def main() -> None:
    print_title(
        "Hours told",
        f"`foundry plan --time`, then the sweep: runs of {CALLS_PER_RUN} calls, each on a new server. The servers",
        "speak Ollama's API and run in processes of their own on this machine.",
    )
    rows = []
    for kind in KINDS:
        with scratch(in_memory=True) as folder:
            predicted, taken = told_s(kind, folder), taken_s(kind, folder)
        rows.append(
            [
                kind.name,
                kind.runs * CALLS_PER_RUN,
                f"{predicted:.1f}",
                f"{taken:.1f}",
                f"{predicted / taken:.2f}",
            ]
        )
    print_table(["server", "calls", "s told", "s taken", "told over taken"], rows)


if __name__ == "__main__":
    main()
