"""The sweeps in a folder, and the state of their runs. Data from a file stay in memory until this file changes."""

import base64
import re
from collections import Counter
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

from foundry.errors import InputError, RecordError, not_found
from foundry.records import Counts, RunSummary
from foundry.storing.notes import stamp_of_notes
from foundry.storing.store import RunFolder, SweepFolder, sweeps_in
from foundry.viewer.lines import StepLines
from foundry.viewer.run_view import COMPLETE, FAILED, RUNNING, UNDECIDED, WAITING, standing
from foundry.viewer.signature_table import SignatureTable
from foundry.viewer.summary import Summary, claimed_measures, summary_of

ROWS_PER_PAGE = 500
LOOKED_AT_ONCE = ROWS_PER_PAGE
"""Number of runs whose state is checked before the page shows a sweep for the first time."""
FEW = 2_000
"""Number of unchecked runs that each later request checks. A sweep with at most FEW runs is checked as a whole."""
_OWN_COLUMNS = ("sweep", "run", "world", "model", "prompt", "seed", "sampling_seed", "status", "baseline")


@dataclass
class CatalogedSweep:
    """A sweep that the viewer shows, with data that the viewer has already read from its files.

    Attributes:
        id: its name in addresses.
        name: the path of its folder, relative to the folder that is shown.
    """

    id: str
    name: str
    folder: SweepFolder
    _summaries: dict[str, tuple[str, RunSummary]] = field(default_factory=dict)
    _lengths: dict[str, StepLines] = field(default_factory=dict)
    _claimed: tuple[tuple[int, int], list[str]] = ((0, 0), [])
    _folders: dict[int, RunFolder] = field(default_factory=dict)
    _standings: dict[str, str] = field(default_factory=dict)

    @property
    def is_probe(self) -> bool:
        """True if the sweep is a probe."""
        return self.folder.moments_file.exists()

    def runs(self) -> list[RunFolder]:
        """Return all runs, also those that have not begun."""
        return self._runs_of(range(len(self.folder.sweep.runs)))

    def run(self, name: str) -> RunFolder:
        """Return a run by its id, or raise InputError."""
        if name not in self._places:
            raise not_found("Run", name, list(self._places)[:20])
        return self._runs_of([self._places[name]])[0]

    @cached_property
    def _places(self) -> dict[str, int]:
        """The index of each run in the sweep's definition, by the run's id."""
        return {run.id: place for place, run in enumerate(self.folder.sweep.runs)}

    def _runs_of(self, places: Sequence[int]) -> list[RunFolder]:
        """Return the runs with these indices. A run is read at its first use, since a sweep may have very many runs."""
        if fresh := [place for place in places if place not in self._folders]:
            self._folders |= zip(fresh, self.folder.runs_of(fresh), strict=True)
        return [self._folders[place] for place in places]

    def summary(self, folder: RunFolder) -> RunSummary | None:
        """Return the summary of a run that has ended, or None."""
        ending = folder.ending
        cached = self._summaries.get(folder.id)
        if cached is not None and cached[0] == ending:
            return cached[1]
        summary = folder.summary() if ending else None
        if summary is not None:
            self._summaries[folder.id] = ending, summary
        return summary

    def open_runs(self) -> set[str]:
        """Return the ids of the runs that a worker is playing."""
        return set(opened_in(self.folder.progress()))

    def head(self) -> dict[str, Any]:
        """Return the facts that the page shows above the table. `counts` only counts runs that were checked already."""
        reports = self.folder.progress()
        counts = self.look_further(set(opened_in(reports)))
        return {
            "id": self.id,
            "name": self.name,
            "history": self.folder.sweep.history,
            "runs": len(self.folder.sweep.runs),
            "rows_per_page": ROWS_PER_PAGE,
            "counts": counts,
            "working": bool(reports),
            "factors": self.factors(),
            "models": self.folder.sweep.model_names(),
            "measures": self.measures(),
            "claimed": self.claimed(),
            "links": list(self._links()),
            "notes": stamp_of_notes(self.folder.path),
        }

    def rows(self, first: int, last: int | None) -> list[dict[str, Any]]:
        """Return the rows of the table from index `first` up to, but not including, `last`."""
        opened = self.open_runs()
        return [
            self._row(folder, folder.id in opened)
            for folder in self._runs_of(range(len(self.folder.sweep.runs))[first:last])
        ]

    def look_further(self, opened: Container[str]) -> Counter[str]:
        """Check the state of runs that may have changed, and of a limited number of runs that were never checked.

        Args:
            opened: ids of the runs that a worker is playing.

        Returns:
            The number of runs in each state, of all runs that were checked so far.
        """
        known, places = self._standings, self._places
        begun = self.folder.begun() if known else places.keys()  # a page waits for the first check
        known |= dict.fromkeys(places.keys() - begun, WAITING)
        unseen = (place for name, place in places.items() if name not in known)
        fresh = islice(unseen, (FEW if known else LOOKED_AT_ONCE) if len(known) < len(places) else 0)
        few = len(places) <= FEW  # a complete run may be restarted, so it is checked too
        again = (places[name] for name, status in known.items() if name in begun and (few or status != COMPLETE))
        for folder in self._runs_of([*again, *fresh]):
            self._standing(folder, self.summary(folder), folder.id in opened)
        return Counter(known.values())

    def holds(self, run: str) -> bool:
        """Return whether this page knows the run; another command may have added runs since the page began."""
        return run in self._places

    @cached_property
    def models(self) -> dict[str, str]:
        """The name of the model of each run, by the run's id."""
        names = [str(condition.config["model"]["name"]) for condition in self.folder.sweep.conditions]
        return {run.id: names[run.condition] for run in self.folder.sweep.runs}

    def seeds_of(self, run: str) -> list[str]:
        """Return the ids of all runs with the same condition as `run`, in the order of their seeds."""
        runs = self.folder.sweep.runs
        condition = runs[self._places[run]].condition
        return [run.id for run in sorted(runs, key=lambda run: run.seed) if run.condition == condition]

    def models_beside(self, run: str) -> list[str]:
        """Return the ids of `run` and of all runs that differ from it only in the model, in the order of the sweep."""
        runs, conditions = self.folder.sweep.runs, self.folder.sweep.conditions
        own = runs[self._places[run]]
        swept = [
            {name: value for name, value in condition.factors.items() if name != "model"} for condition in conditions
        ]
        like = {place for place, settings in enumerate(swept) if settings == swept[own.condition]}
        return [run.id for run in runs if run.condition in like and run.seed == own.seed]

    def runs_of_mask(self, mask: str) -> list[str]:
        """Return the ids of the runs whose bit in a mask is 1; `places_in` describes masks."""
        runs = self.folder.sweep.runs
        return [runs[place].id for place in places_in(mask, len(runs))]

    def waiting(self) -> list[str]:
        """Return the ids of the runs that have not ended, as far as they were checked."""
        ended = (COMPLETE, FAILED)
        return [name for name in self._places if self._standings.get(name) not in ended]

    def failed(self) -> list[RunSummary]:
        """Return the summaries of the failed runs among the runs that were checked so far."""
        return [summary for name, (_, summary) in self._summaries.items() if self._standings.get(name) == FAILED]

    def _standing(self, folder: RunFolder, summary: RunSummary | None, running: bool) -> str:
        state = standing(folder, summary, running=running)
        self._standings[folder.id] = state
        return state

    @cached_property
    def table(self) -> SignatureTable:
        """The table with the measures of all runs."""
        return SignatureTable(self.folder.signatures_path)

    def measures(self) -> list[str]:
        """Return the names of all measures in the table."""
        known = {*_OWN_COLUMNS, *self.factors()}
        return [name for name in self.table.names() if name not in known]

    def measure(self, name: str) -> list[float | None]:
        """Return the value of a measure for each run, in the order of the runs; None if it has no value."""
        return self.table.numbers(name, list(self._places))

    def claimed(self) -> list[str]:
        """Return the measures on which claims rest, from the latest analysis."""
        mark = self.table.mark
        if self._claimed[0] != mark:
            self._claimed = mark, claimed_measures(self.folder, self.measures())
        return self._claimed[1]

    def summary_of_groups(self) -> Summary:
        """Return the groups of runs that the latest analysis compared, with the means of their measures."""
        return summary_of(self.folder, self.claimed(), self.table)

    def _row(self, folder: RunFolder, running: bool) -> dict[str, Any]:
        config, summary = folder.config(), self.summary(folder)
        status = self._standing(folder, summary, running)
        counts = summary.counts if summary else Counts()
        outcomes = Counter(counts.outcomes) + Counter(counts.message_outcomes)
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
            "done": self.steps_done(folder) if status == RUNNING else None,
            "replies": outcomes.total() if summary else None,
            "undecided": sum(outcomes[outcome] for outcome in UNDECIDED) if summary else None,
            "messages": summary.counts.messages if summary else None,
            "calls": summary.counts.calls if summary else None,
            "tokens": summary.counts.prompt_tokens + summary.counts.output_tokens if summary else None,
            "seconds": summary.duration_s if summary else None,
            "factors": [str(folder.factors.get(name, "")) for name in self.factors()],
        }

    def steps_done(self, folder: RunFolder) -> int:
        """Return the last step of a run of which at least one line is recorded."""
        lines = self._lengths.setdefault(folder.id + folder.beginning, StepLines(folder.stream_path("steps")))
        lines.grow()
        return lines.last[0]

    def factors(self) -> list[str]:
        """Return the names of the swept settings that have no column of their own."""
        names = dict.fromkeys(name for condition in self.folder.sweep.conditions for name in condition.factors)
        return [name for name in names if name not in _OWN_COLUMNS]

    def _links(self) -> Iterator[dict[str, str]]:
        """Yield the reports, the plots and the tables in the sweep's folder, as far as they exist."""
        joint = sorted(self.folder.path.glob("report_with_*.html"))
        tables = [self.folder.analysis_dir, *sorted(self.folder.path.glob("analysis_with_*"))]
        files = [(path, "") for path in (self.folder.report_file, *joint)]
        files += [(path, table.name[len("analysis") :]) for table in tables for path in sorted(table.rglob("*"))]
        for path, folders in files:
            if path.is_file() and path.suffix in (".html", ".pdf", ".png", ".svg", ".csv", ".md"):
                yield {
                    "label": path.stem + folders.replace("_", " "),
                    "kind": path.suffix[1:],
                    "path": path.relative_to(self.folder.path).as_posix(),
                }


def opened_in(reports: Mapping[str, Any]) -> list[str]:
    """Return the ids of the runs that workers are playing, according to their reports."""
    return [run for report in reports.values() for run in report["open"]]


def places_in(mask: str, runs: int) -> list[int]:
    """Return the indices of the runs whose bit in a mask is 1.

    Args:
        mask: URL-safe base64 with one bit per run; the highest bit of a byte is first.
        runs: number of runs of the sweep.
    """
    try:
        content = base64.b64decode(mask, altchars=b"-_", validate=True)
    except ValueError as error:
        raise InputError(f"'{mask[:40]}' is not a valid choice of runs ({error}).") from error
    if len(content) != -(-runs // 8):
        raise InputError(
            f"The page chose among {8 * len(content)} runs, but the sweep has {runs} runs. Reload the page."
        )
    return [place for place in range(runs) if content[place >> 3] & 128 >> (place & 7)]


class Catalog:
    """All sweeps below a folder, which may itself be a sweep's folder; the newest comes first."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._kept: dict[Path, CatalogedSweep] = {}
        self.sweeps()

    @property
    def unreadable(self) -> list[str]:
        """The reasons why sweeps cannot be shown, one line per sweep."""
        return list(self._unreadable.values())

    def sweeps(self) -> list[CatalogedSweep]:
        """Return the sweeps that can be read; raise InputError if there is none, RecordError if none can be read."""
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
        """Return the facts about each sweep that the list of sweeps shows."""
        return [
            {
                "id": sweep.id,
                "name": sweep.name,
                "runs": len(sweep.folder.sweep.runs),
                "asked": sweep.folder.sweep.asked,
                "when": sweep.folder.sweep.history[-1].when if sweep.folder.sweep.history else None,
                "working": bool(sweep.folder.progress()),
                "probe": sweep.is_probe,
            }
            for sweep in self.sweeps()
        ]

    def _name(self, path: Path) -> str:
        return self.root.resolve().name if path == self.root else path.relative_to(self.root).as_posix()

    def _free_id(self, path: Path) -> str:
        base, taken = _address(self._name(path)), {sweep.id for sweep in self._kept.values()}
        names = (base, *(f"{base}-{number}" for number in range(2, len(taken) + 3)))
        return next(name for name in names if name not in taken)


def _address(name: str) -> str:
    """Return a name that needs no escaping in a URL and is short enough for a file name."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[-80:].strip("-") or "sweep"
