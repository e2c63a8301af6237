"""Runs and sweeps of walkers under the temporary folder of a test."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from analysis.any.any_run import AnyRun
from analysis.any.general import general_run
from analysis.grid.grid_run import GridRun
from analysis.load import read_records, read_run
from analysis.signatures import Signature
from foundry.expansion import Condition, expand
from foundry.storing.store import RunFolder, SweepFolder
from walkers import WORLD, Habits, Walk, make_condition, walk, write_run, write_sweep


@dataclass(frozen=True)
class Written:
    folder: RunFolder
    walk: Walk

    @property
    def run(self) -> GridRun:
        return read_run(self.folder, read_records(self.folder, self.folder.summary()))

    def view_of(self, signature: Signature) -> GridRun | AnyRun:
        """The run as the signature measures it: as its form has it, or as every form has it."""
        part = signature.part(GridRun)
        return self.run if part.run is GridRun else self.general

    @property
    def general(self) -> AnyRun:
        return general_run(self.folder, read_records(self.folder, self.folder.summary()))


@pytest.fixture
def recorded(tmp_path: Path) -> Callable[..., Written]:
    """Return a function that writes one run of changed settings and habits, or of given records."""

    def write(seed: int = 0, habits: Habits | None = None, records: Walk | None = None, **settings: Any) -> Written:
        world = {**WORLD, **settings}
        sweep = SweepFolder.create(
            tmp_path / f"one{seed}", expand([], [make_condition("walker", [seed], world=world)]), {}, []
        )
        made = records or walk(world, seed, habits or Habits())
        write_run(sweep.runs()[0], made)
        return Written(sweep.runs()[0], made)

    return write


@pytest.fixture
def make_sweep(tmp_path: Path) -> Callable[..., SweepFolder]:
    def make(
        conditions: Sequence[Condition], habits: dict[str, Habits] | None = None, name: str = "sweep"
    ) -> SweepFolder:
        return write_sweep(tmp_path / name, conditions, habits)

    return make
