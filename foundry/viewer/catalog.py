"""The sweeps below a folder and how their runs stand; what was read is kept until its file changes."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

from foundry.errors import RecordError, not_found
from foundry.records import RunSummary
from foundry.storing.store import RunFolder, SweepFolder, sweeps_in
from foundry.viewer.lines import StepLines
from foundry.viewer.run_view import UNDECIDED
from foundry.viewer.standing import COMPLETE, RUNNING, standing

ROWS_PER_PAGE = 500
LOOKED_AT_ONCE = 2_000
"""Runs that a head looks at which nobody has looked at: it is the first thing that a page waits for."""
_OWN_COLUMNS = ("sweep", "run", "world", "model", "prompt", "seed", "sampling_seed", "status", "baseline")
_SHOWN_AT_FIRST = 3


@dataclass
class CatalogedSweep:
    """One sweep and what was read of it.

    Attributes:
        id: its name in addresses.
        name: its folder, seen from the folder that is shown.
        folder: the sweep.
    """

    id: str
    name: str
    folder: SweepFolder
    _summaries: dict[str, RunSummary] = field(default_factory=dict)
    _lengths: dict[str, StepLines] = field(default_factory=dict)
    _measures: tuple[tuple[int, int], dict[str, list[float | None]]] = ((0, 0), {})
    _folders: dict[int, RunFolder] = field(default_factory=dict)
    _standings: dict[str, str] = field(default_factory=dict)

    def runs(self) -> list[RunFolder]:
        """Return every run, whether started or not."""
        return self._runs_of(range(len(self.folder.sweep.runs)))

    def run(self, name: str) -> RunFolder:
        """Return a run by its id, or raise InputError."""
        if name not in self._places:
            raise not_found("Run", name, list(self._places)[:20])
        return self._runs_of([self._places[name]])[0]

    @cached_property
    def _places(self) -> dict[str, int]:
        """The place of each run in the definition, by its id."""
        return {run.id: place for place, run in enumerate(self.folder.sweep.runs)}

    def _runs_of(self, places: Sequence[int]) -> list[RunFolder]:
        """Return the runs at some places; they are made when they are first looked at, for there may be very many."""
        fresh = [place for place in places if place not in self._folders]
        self._folders |= zip(fresh, self.folder.runs_of(fresh), strict=True)
        return [self._folders[place] for place in places]

    def summary(self, folder: RunFolder) -> RunSummary | None:
        """Return how a run ended; the summary of a complete run never changes."""
        kept = self._summaries.get(folder.id)
        if kept is not None and kept.status == COMPLETE and folder.ended:
            return kept
        found = folder.summary()
        if found is not None:
            self._summaries[folder.id] = found
        return found

    def open_runs(self) -> set[str]:
        """Return the ids of the runs that a worker is playing."""
        return {run for report in self.folder.progress().values() for run in report["open"]}

    def head(self) -> dict[str, Any]:
        """Return what the page shows above the table.

        How runs stand is counted over those that were looked at so far, as `counts` says by its sum: all of a sweep
        that is not very large.
        """
        self._look_further()
        counts = Counter(self._standings.values())
        measures = list(self.measures())
        return {
            "id": self.id,
            "name": self.name,
            "asked": self.folder.sweep.asked,
            "runs": len(self.folder.sweep.runs),
            "rows_per_page": ROWS_PER_PAGE,
            "counts": counts,
            "working": bool(self.folder.progress()),
            "factors": self._factors(),
            "measures": measures,
            "shown": _first_of_each_signature(measures)[:_SHOWN_AT_FIRST],
            "links": list(self._links()),
        }

    def rows(self, first: int, last: int) -> list[dict[str, Any]]:
        """Return the rows of the table from `first` up to but without `last`."""
        opened = self.open_runs()
        return [
            self._row(folder, folder.id in opened)
            for folder in self._runs_of(range(len(self.folder.sweep.runs))[first:last])
        ]

    def _look_further(self) -> None:
        """See how the runs stand that may have changed, and some more of those that nobody has looked at."""
        known, places = self._standings, self._places
        unseen = (place for name, place in places.items() if name not in known)
        fresh = islice(unseen, LOOKED_AT_ONCE if len(known) < len(places) else 0)
        few = len(places) <= LOOKED_AT_ONCE  # whose complete runs are looked at again, too: one may be started anew
        again = (places[name] for name, status in known.items() if few or status != COMPLETE)
        opened = self.open_runs()
        for folder in self._runs_of([*again, *fresh]):
            self._standing(folder, self.summary(folder), folder.id in opened)

    def _standing(self, folder: RunFolder, summary: RunSummary | None, running: bool) -> str:
        found = standing(folder, summary, running=running)
        self._standings[folder.id] = found
        return found

    def measures(self) -> dict[str, list[float | None]]:
        """Return each signature's measures, one value per run in the order of the runs; None where there is none."""
        try:
            found = self.folder.signatures_path.stat()
        except FileNotFoundError:
            return {}
        mark = (found.st_mtime_ns, found.st_size)
        if self._measures[0] != mark:
            self._measures = mark, self._read_measures()
        return self._measures[1]

    def _read_measures(self) -> dict[str, list[float | None]]:
        with self.folder.signatures_path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            by_run = {row["run"]: row for row in reader}
            known = {*_OWN_COLUMNS, *self._factors()}
            names = [name for name in reader.fieldnames or () if name not in known]
        rows = [by_run.get(run.id, {}) for run in self.folder.sweep.runs]
        return {name: [_number(row.get(name)) for row in rows] for name in names}

    def _row(self, folder: RunFolder, running: bool) -> dict[str, Any]:
        config, summary = folder.config(), self.summary(folder)
        status = self._standing(folder, summary, running)
        outcomes = summary.counts.outcomes if summary else {}
        return {
            "run": folder.id,
            "world": config["world"]["name"],
            "model": config["model"]["name"],
            "prompt": config["prompt"]["name"],
            "form": folder.declared.form,
            "seed": config["seed"],
            "status": status,
            "error": summary.error if summary else None,
            "planned": config["world"].get("steps"),
            "done": self._done(folder) if status == RUNNING else None,
            "decisions": sum(outcomes.values()) if summary else None,
            "undecided": sum(outcomes.get(one, 0) for one in UNDECIDED) if summary else None,
            "factors": [str(folder.factors.get(name, "")) for name in self._factors()],
        }

    def _done(self, folder: RunFolder) -> int:
        lines = self._lengths.setdefault(folder.id + folder.beginning, StepLines(folder.stream_path("steps")))
        lines.grow()
        return lines.last[0]

    def _factors(self) -> list[str]:
        names = dict.fromkeys(name for one in self.folder.sweep.conditions for name in one.factors)
        return [name for name in names if name not in _OWN_COLUMNS]

    def _links(self) -> Iterator[dict[str, str]]:
        """Yield the report, the plots and the tables that are there, by their path in the sweep's folder."""
        found = [self.folder.report_file, *sorted(self.folder.analysis_dir.rglob("*"))]
        for path in found:
            if path.is_file() and path.suffix in (".html", ".png", ".svg", ".csv", ".md"):
                yield {
                    "label": path.stem,
                    "kind": path.suffix[1:],
                    "path": path.relative_to(self.folder.path).as_posix(),
                }


class Catalog:
    """Every sweep below a folder, newest first.

    Args:
        root: a sweep's folder, or a folder of sweeps.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._kept: dict[Path, CatalogedSweep] = {}
        self.sweeps()

    @property
    def unreadable(self) -> list[str]:
        """Why sweeps that are there cannot be shown, one line each."""
        return list(self._unreadable.values())

    def sweeps(self) -> list[CatalogedSweep]:
        """Return the sweeps that are there now.

        Raises:
            InputError: there is none.
            RecordError: none of them can be read.
        """
        paths = sweeps_in(self.root)
        self._unreadable: dict[Path, str] = {}
        for path in paths:
            if path not in self._kept:
                self._open(path)
        readable = [self._kept[path] for path in paths if path in self._kept]
        if not readable:
            raise RecordError(self.unreadable[0])
        return readable

    def _open(self, path: Path) -> None:
        try:
            folder = SweepFolder.open(path)
        except RecordError as error:
            self._unreadable[path] = str(error)
        else:
            self._kept[path] = CatalogedSweep(self._free_id(path), self._name(path), folder)

    def sweep(self, name: str) -> CatalogedSweep:
        """Return a sweep by its id, or raise InputError."""
        for sweep in self._kept.values():
            if sweep.id == name:
                return sweep
        raise not_found("Sweep", name, [sweep.id for sweep in self._kept.values()])

    def overview(self) -> list[dict[str, Any]]:
        """Return one row per sweep."""
        return [
            {"id": one.id, "name": one.name, "runs": len(one.folder.sweep.runs), "asked": one.folder.sweep.asked}
            for one in self.sweeps()
        ]

    def _name(self, path: Path) -> str:
        root = self.root.resolve()
        return path.resolve().relative_to(root.parent if path == self.root else root).as_posix()

    def _free_id(self, path: Path) -> str:
        base, taken = _address(self._name(path)), {one.id for one in self._kept.values()}
        names = (base, *(f"{base}-{number}" for number in range(2, len(taken) + 3)))
        return next(name for name in names if name not in taken)


def _address(name: str) -> str:
    """Return a name that needs no escaping in an address and is no longer than a file's name may be."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[-80:].strip("-") or "sweep"


def _first_of_each_signature(measures: list[str]) -> list[str]:
    """Return each signature's first measure, the one that stands for it."""
    return list({name.partition(".")[0]: name for name in reversed(measures)}.values())[::-1]


def _number(text: str | None) -> float | None:
    try:
        value = float(text or "nan")
    except ValueError:
        value = {"True": 1.0, "False": 0.0}.get(text or "", math.nan)
    return value if math.isfinite(value) else None
