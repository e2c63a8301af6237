"""Counts the project's files whose code runs in one 2D round and one 3D decision, and the calls between these files.

    python benchmarks/round_files.py [--files]

A scripted model plays each world through `foundry.episode`, and the records are written as in a run. The script skips
the first rounds, which load and build things, observes ten rounds, and shows the round in which the code of the most
files runs. The same code gives the same counts.
"""

import argparse
import asyncio
import contextlib
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

from measuring import print_table, scratch

from foundry.composing.compose import compose
from foundry.composing.preflight import check
from foundry.episode import play
from foundry.errors import Interrupted
from foundry.expansion import expand
from foundry.running.build import asker_of, build
from foundry.storing.run_writer import RunWriter
from foundry.storing.store import SweepFolder

ROOT = Path(__file__).resolve().parent.parent
OWN = tuple(f"{ROOT / package}/" for package in ("foundry", "analysis", "hydra_plugins"))
SENTENCE = "I turn left 40 degrees, look down 5 degrees, and walk 1.5 m forward."
ROUNDS = {
    "2D round": ("world=cafe_library", "model=scripted/random", "seed=0"),
    "3D decision": ("world=office", "model=scripted/mumbler", f"model.sentences=['{SENTENCE}']", "seed=0"),
}
FIRST, OBSERVED = 3, 10
"""The first observed round, after the rounds that load and build things, and the number of observed rounds."""


@dataclass
class RoundCounts:
    """Calls in one round, by file, and the number of calls from one file into another."""

    calls: Counter[str] = field(default_factory=Counter)
    switches: int = 0


class Observer:
    """Counts the calls of each round while an episode is played."""

    def __init__(self) -> None:
        self.rounds: list[RoundCounts] = []

    def stopping(self) -> bool:
        """Count the next round, or stop the episode after the last one; the episode calls this before every round."""
        self.rounds.append(RoundCounts())
        is_over = len(self.rounds) == FIRST + OBSERVED
        sys.setprofile(self._observe if len(self.rounds) >= FIRST and not is_over else None)
        return is_over

    def widest(self) -> RoundCounts:
        """Return the first of the rounds in which the code of the most files ran."""
        return max(self.rounds, key=lambda counts: len(counts.calls))

    def _observe(self, frame: FrameType, event: str, _: Any) -> None:
        if event != "call" or not _is_own(frame):
            return
        counts, caller = self.rounds[-1], _own_caller(frame)
        counts.calls[frame.f_code.co_filename] += 1
        counts.switches += caller is not None and caller.f_code.co_filename != frame.f_code.co_filename


def _is_own(frame: FrameType) -> bool:
    return frame.f_code.co_filename.startswith(OWN)


def _own_caller(frame: FrameType) -> FrameType | None:
    caller = frame.f_back
    while caller is not None and not _is_own(caller):
        caller = caller.f_back
    return caller


def observed(overrides: Sequence[str], folder: Path) -> RoundCounts:
    """Play a run up to the last observed round; return the round with the most files."""
    composed = compose([*overrides, f"output.dir={folder}", f"cache.path='{folder}.sqlite'"])
    assert composed is not None
    sweep = expand(composed.asked, composed.conditions)
    (info,) = check(sweep).values()
    (run,) = SweepFolder.create(folder, sweep, dict(composed.settings), []).runs()
    config = run.config()
    scenario = build(config["world"])
    asker = asker_of(config, scenario, build(config["prompt"]), build(config["model"]), info)
    observer, writer = Observer(), RunWriter(run, "")
    with contextlib.closing(writer), contextlib.suppress(Interrupted):
        asyncio.run(play(scenario.start(config["seed"]), asker, writer, stopping=observer.stopping))
    return observer.widest()


def rows(rounds: dict[str, RoundCounts]) -> Iterator[list[str]]:
    """Yield a row per round and file; files with the most calls come first."""
    for name, counts in rounds.items():
        for file, calls in sorted(counts.calls.items(), key=lambda item: (-item[1], item[0])):
            yield [name, Path(file).relative_to(ROOT).as_posix(), f"{calls:,}"]


def main() -> None:
    """Observe both rounds and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--files", action="store_true", help="list the files with their numbers of calls")
    with_files = parser.parse_args().files
    with scratch() as folder:
        rounds = {name: observed(overrides, folder / name.split()[0]) for name, overrides in ROUNDS.items()}
    totals = [
        [name, str(len(counts.calls)), str(counts.switches), str(counts.calls.total())]
        for name, counts in rounds.items()
    ]
    print_table(["round", "files", "switches", "calls"], totals)
    if with_files:
        print_table(["round", "file", "calls"], list(rows(rounds)))


if __name__ == "__main__":
    main()
