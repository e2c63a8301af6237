"""The resources of the page by address, for both the server and the export.

`foundry/viewer/README.md` documents the addresses and the keys of results.
"""

import datetime
import itertools
import re
import secrets
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, not_found
from foundry.storing.notes import Note, add_note, notes_of
from foundry.storing.store import RunFolder
from foundry.texts import counted
from foundry.viewer.analysed import AnalysedRuns
from foundry.viewer.catalog import ROWS_PER_PAGE, Catalog, CatalogedSweep
from foundry.viewer.forms import scripts_of, view_of
from foundry.viewer.probe.probe_view import ProbeView
from foundry.viewer.run_view import MARKS_PER_BLOCK, IsWarning, Resource, RunView, parts_of
from foundry.viewer.search import Query, TextSearch
from foundry.viewer.underway import underway


class _Written(msgspec.Struct, forbid_unknown_fields=True):
    """A request of the page: a new note, or new content for an existing note."""

    who: str
    run: str
    step: int | None
    agent: int | None
    text: str
    tags: tuple[str, ...]
    moment: int | None = None
    note: str | None = None
    deleted: bool = False


def take_note(sweep: CatalogedSweep, content: bytes, moment_of: Callable[[int], tuple[str, int, int]]) -> None:
    """Add a note, or change one.

    Args:
        sweep: the sweep.
        content: the page's request.
        moment_of: returns run, step and agent of a moment of the probe by the moment's number.

    Raises:
        InputError: the note is empty or invalid, or there is no such run, moment or note.
    """
    try:
        written = msgspec.json.decode(content, type=_Written)
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        named = {"note": written.note or secrets.token_hex(6), "when": now}
        note = msgspec.convert({**msgspec.to_builtins(written), **named}, Note)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(f"The note cannot be read: {error}") from error
    if note.moment is None:
        sweep.run(note.run)
    elif (place := moment_of(note.moment)) != (note.run, note.step, note.agent):
        run, step, agent = place
        raise InputError(f"A note on moment {note.moment} must name run '{run}', step {step} and agent {agent}.")
    known = [note.note for note in notes_of(sweep.folder.path).notes]
    if written.note is not None and written.note not in known:
        raise not_found("Note", written.note, known)
    if not (note.text.strip() or note.tags or note.deleted):
        raise InputError("The note is empty. Write a text or a tag.")
    add_note(sweep.folder.path, note)


MOST_PARTINGS = 11
"""Maximum number of different decisions that the page of compared runs lists."""
_OPEN_RUNS = 12
_NUMBER = re.compile(r"\d{1,9}")
_ENCODE = msgspec.json.Encoder().encode


def open_view(folder: RunFolder, is_warning: IsWarning | None = None, **settings: Any) -> RunView:
    """Return the view of a run; its class depends on the run's form. `settings` are arguments of `RunView`."""
    view = view_of(folder.declared.form).run(folder, **settings)
    view.is_warning = is_warning
    return view


class Resources:
    """Returns the resources of the sweeps in a folder; safe to use from several threads.

    Args:
        root: a sweep's folder, or a folder of sweeps.
        decisions_per_chunk: number of steps in one chunk of decisions.
        trusted: further packages that may contain classes of worlds, for redrawing pictures.
        is_warning: tells warnings from other texts, to show how far warnings reach; None if unknown.
    """

    def __init__(
        self,
        root: Path,
        *,
        decisions_per_chunk: int = 10,
        trusted: Sequence[str] = (),
        is_warning: IsWarning | None = None,
    ) -> None:
        self.catalog = Catalog(root)
        self._decisions_per_chunk = decisions_per_chunk
        self._trusted = trusted
        self._is_warning = is_warning
        self._views: OrderedDict[tuple[str, str], tuple[str, RunView]] = OrderedDict()
        self._probes: dict[str, ProbeView] = {}
        self._searches: dict[str, TextSearch] = {}
        self._analysed: dict[str, AnalysedRuns] = {}
        self._lock = threading.RLock()

    def close(self) -> None:
        """Free cached data."""
        with self._lock:
            for _, view in self._views.values():
                view.close()
            self._views.clear()
            for search in self._searches.values():
                search.close()
            self._searches.clear()

    def get(self, address: str) -> Resource:
        """Return the resource at an address, or raise InputError if there is none."""
        kind, *rest = address.split("/")
        if kind == "sweeps" and not rest:
            with self._lock:
                sweeps = self.catalog.overview()
                return Resource(_ENCODE({"sweeps": sweeps, "unreadable": self.catalog.unreadable}))
        if kind == "sweep" and rest[1:2] == ["search"] and len(rest) > 2:
            return Resource(_ENCODE(self._search(rest[0], "/".join(rest[2:]))))
        if kind == "sweep" and rest[1:2] == ["partings"] and len(rest) == 4:
            return Resource(_ENCODE(self._partings(rest[0], *rest[2:])))
        if kind == "sweep" and rest:
            with self._lock:
                return Resource(_ENCODE(_of_sweep(self.catalog.sweep(rest[0]), rest[1:])))
        if kind == "probe" and len(rest) >= 2:
            return self.probe(rest[0]).get(rest[1], _numbers(rest[2:]))
        if kind == "run" and len(rest) >= 3:
            view = self.view(rest[0], rest[1])
            if rest[2:] == ["progress"]:
                running = rest[1] in self._sweep(rest[0]).open_runs()
                return Resource(_ENCODE(view.progress(running=running)))
            if rest[2:] == ["about"]:
                return Resource(_ENCODE(_about(view, self._sweep(rest[0]))))
            if rest[2:] == ["analysis"]:
                return Resource(_ENCODE(self._analysis(*rest[:2])))
            return _of_run(view, rest[2], _numbers(rest[3:]))
        raise InputError(f"There is nothing at '{address}'.")

    def _sweep(self, name: str) -> CatalogedSweep:
        """Return a sweep, while a lock keeps other threads from adding sweeps to the catalog."""
        with self._lock:
            return self.catalog.sweep(name)

    def take_note(self, sweep: str, content: bytes) -> None:
        """Add a note to a sweep, or change one; see the function `take_note`."""
        with self._lock:
            sweep_found = self.catalog.sweep(sweep)
        take_note(sweep_found, content, lambda number: self.probe(sweep).place(number))

    def probe(self, sweep: str) -> ProbeView:
        """Return the view of a probe, or raise InputError if the sweep is not a probe."""
        with self._lock:
            if sweep not in self._probes:
                sweep_found = self.catalog.sweep(sweep)
                if not sweep_found.is_probe:
                    raise InputError(f"'{sweep_found.name}' is not a probe: it has runs, but no moments.")
                self._probes[sweep] = ProbeView(sweep_found.folder, self._trusted)
            return self._probes[sweep]

    def _search(self, name: str, asked: str) -> dict[str, Any]:
        """Return the texts that match a search; the search is given as JSON."""
        try:
            query = msgspec.json.decode(asked, type=Query)
        except msgspec.DecodeError as error:
            raise InputError(f"'{asked}' is not a valid search ({error}). Write a kind and words as JSON.") from error
        with self._lock:
            sweep = self.catalog.sweep(name)
            search = self._searches.setdefault(name, TextSearch(sweep.folder))
            runs = sweep.runs_of_mask(query.runs) if query.runs else None
        return search.find(query, runs)

    def _analysis(self, sweep: str, run: str) -> dict[str, Any]:
        with self._lock:
            analysed = self._analysed.setdefault(sweep, AnalysedRuns(self.catalog.sweep(sweep)))
            return analysed.of(run)

    def _partings(self, name: str, *runs: str) -> dict[str, Any]:
        """Return the first questions that were equal in two runs but were decided differently."""
        from analysis.findings.moments import partings

        with self._lock:
            sweep = self.catalog.sweep(name)
            first, second = (sweep.run(run) for run in runs)
        listed = itertools.islice(partings(first, second), MOST_PARTINGS)
        return {"partings": [[parting.step, parting.agent, parting.question, parting.asked] for parting in listed]}

    def view(self, sweep: str, run: str) -> RunView:
        """Return the view of a run. If the run was started anew, its view is made anew too."""
        with self._lock:
            folder = self.catalog.sweep(sweep).run(run)
            cached = self._views.pop((sweep, run), None)
            if cached is not None and cached[0] != folder.beginning:
                cached[1].close()
                cached = None
            if cached is None:
                settings = {"decisions_per_chunk": self._decisions_per_chunk, "trusted": self._trusted}
                cached = folder.beginning, open_view(folder, self._is_warning, **settings)
            self._views[sweep, run] = cached
            while len(self._views) > _OPEN_RUNS:
                self._views.popitem(last=False)[1][1].close()
            return cached[1]


def _of_sweep(sweep: CatalogedSweep, rest: list[str]) -> Any:
    if not rest:
        return sweep.head()
    what, numbers = rest[0], _numbers(rest[1:])
    if what == "rows" and len(numbers) == 1:
        return {"rows": sweep.rows(numbers[0] * ROWS_PER_PAGE, (numbers[0] + 1) * ROWS_PER_PAGE)}
    if what == "underway" and not numbers:
        return underway(sweep)
    if what == "notes" and not numbers:
        return notes_of(sweep.folder.path)
    if what == "groups" and not numbers:
        return sweep.summary_of_groups()
    measures = sweep.measures()
    if what == "measure" and len(numbers) == 1 and numbers[0] < len(measures):
        name = measures[numbers[0]]
        return {"name": name, "values": sweep.measure(name)}
    raise InputError(f"A sweep has no data at the address '{'/'.join(rest)}'.")


def _numbers(texts: list[str]) -> list[int]:
    if not all(_NUMBER.fullmatch(text) for text in texts):
        raise InputError(f"The part '{'/'.join(texts)}' of the address must consist of whole numbers.")
    return [int(text) for text in texts]


def _frames(view: RunView, chunk: int) -> Any:
    return view.frames(*view.chunk(chunk, view.steps_per_chunk))


def _marks(view: RunView, block: int) -> Any:
    first, last = view.chunk(block, MARKS_PER_BLOCK)
    return {"first": first, "last": last, "marks": view.marks(first, last)}


def _by_step(view: RunView, block: int) -> Any:
    first, last = view.chunk(block, MARKS_PER_BLOCK)
    return {"first": first, "last": last, "values": view.by_step(first, last)}


def _texts(view: RunView, chunk: int) -> Any:
    first, last = view.chunk(chunk, view.steps_per_chunk)
    return {"first": first, "last": last, "texts": view.texts(first, last)}


def _decisions(view: RunView, chunk: int, agent: int) -> Any:
    return view.decisions(agent, *view.chunk(chunk, view.decisions_per_chunk))


def _track(view: RunView, agent: int) -> Any:
    view.steps.grow()
    return view.track(agent)


def _about(view: RunView, sweep: CatalogedSweep) -> dict[str, Any]:
    page = [script.told for script in scripts_of(view.folder.declared.form)]
    run = view.folder.id
    beside = {"seeds": sweep.seeds_of(run), "models": sweep.models_beside(run)}
    return {**view.about(), "models": sweep.folder.sweep.model_names(), "page": page, "beside": beside}


_OF_RUN: Mapping[tuple[str, int], Callable[..., Any]] = {
    ("frames", 1): _frames,
    ("marks", 1): _marks,
    ("by_step", 1): _by_step,
    ("texts", 1): _texts,
    ("decisions", 2): _decisions,
    ("track", 1): _track,
    ("agents", 0): RunView.totals,
}


def _of_run(view: RunView, what: str, numbers: list[int]) -> Resource:
    answer = {**_OF_RUN, **view.parts}.get((what, len(numbers)))
    if answer is None:
        raise InputError(f"A run has no data at an address with '{what}' and {counted(len(numbers), 'number')}.")
    resource = answer(view, *numbers)
    return resource if isinstance(resource, Resource) else Resource(_ENCODE(resource))


def addresses_of_run(view: RunView) -> Iterator[str]:
    """Yield the addresses of data that runs of all forms have; the data of single agents are not among them."""
    view.steps.grow()
    yield from ("about", "progress", "analysis", "agents")
    yield from (
        f"{what}/{chunk}" for what in ("frames", "texts") for chunk in range(parts_of(view.done, view.steps_per_chunk))
    )
    blocks = range(parts_of(view.done, MARKS_PER_BLOCK))
    yield from (f"{what}/{block}" for what in ("marks", "by_step") for block in blocks)


def resources_of_agents(view: RunView) -> Iterator[tuple[str, Resource]]:
    """Yield the data of each agent, with their addresses. The records are read only once for all agents."""
    view.steps.grow()
    for agent, track in view.all_tracks():
        yield f"track/{agent}", Resource(_ENCODE(track))
    for chunk in range(parts_of(view.done, view.decisions_per_chunk)):
        for agent, decisions in view.all_decisions(*view.chunk(chunk, view.decisions_per_chunk)):
            yield f"decisions/{chunk}/{agent}", Resource(_ENCODE(decisions))
