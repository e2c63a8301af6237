"""A worker, called lane in the code: it plays several runs at once in one event loop, and reports its progress."""

import asyncio
import contextlib
import datetime
import logging
import os
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from foundry import own_code, provenance
from foundry.episode import play
from foundry.errors import (
    FoundryError,
    InputError,
    Interrupted,
    ModelChangedError,
    ServerError,
    StorageError,
    TransientError,
    UnconfirmedError,
)
from foundry.expansion import settings_key
from foundry.models.answers.answers import Answers
from foundry.models.answers.opening import open_answers
from foundry.models.base import Model, ModelInfo
from foundry.models.serving import RUN
from foundry.records import Counts, RunSummary
from foundry.running.build import asker_of, build, model_stack
from foundry.running.cores import garbage_sought_seldom, share_cores
from foundry.running.recorded import forked, origin_of
from foundry.running.sharing import Shared
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder, cannot_write, write_atomically
from foundry.storing.sweep_file import to_yaml
from foundry.texts import without_secrets

REPORT_EVERY_S = 0.25
RETRY_CLAIM_S = 0.25
WAITING = "waiting: another process is playing the remaining runs of %s; press Ctrl-C to stop waiting"
MOST_NOTES = 20
MOST_OPEN = 64
"""Maximum number of runs that a worker plays at once to keep a server busy; each run keeps a few files open."""


@dataclass(frozen=True)
class LaneSpec:
    """The settings of a worker.

    Attributes:
        name: name of the worker, by which its progress report is named.
        session: session of its command; a command stops only the workers of its own session.
        runs: ids of the runs that it may play, in order; it skips runs that other workers play.
        infos: facts about each model from its server, by `expansion.settings_key`.
        cache: file or database with the cache of answers.
        suspects: ids of runs that were open when a worker died; it plays these first, one at a time.
        frame_every: n, to store a picture of every n-th step; 0 stores none.
        open_runs: number of runs that it plays at once; it plays more if a server has room for more calls.
        ahead: whether foundry asks an agent early if no unanswered question can affect it.
        workers: number of workers that begin together; they divide each limit on calls in flight.
        apart: whether workers cannot read each other's reports, so that their parts of a limit do not change.
        parent: id of the process that waits for the worker, which ends without it; None if it is this process.
        own: the user's own folders, with code that the sweep may need.
    """

    name: str
    session: str
    folder: SweepFolder
    runs: tuple[str, ...]
    infos: Mapping[str, ModelInfo]
    cache: str
    suspects: tuple[str, ...] = ()
    frame_every: int = 0
    open_runs: int = 1
    ahead: bool = True
    workers: int = 1
    apart: bool = False
    parent: int | None = None
    own: tuple[Path, ...] = ()

    def is_of_session(self, name: str) -> bool:
        """Return whether a worker with this name belongs to the same command as this worker."""
        return name.startswith(f"{self.session}-")


@dataclass
class Tally:
    """The progress of a worker with one model; `spared` is the number of calls that ended runs did not need."""

    complete: int = 0
    failed: int = 0
    calls: int = 0
    cached: int = 0
    retries: int = 0
    prompt_tokens: int = 0
    output_tokens: int = 0
    spared: int = 0

    def add(self, counts: Counts) -> None:
        """Add the numbers of calls, retries and tokens of a run."""
        self.calls += counts.calls
        self.cached += counts.cached
        self.retries += counts.retries
        self.prompt_tokens += counts.prompt_tokens
        self.output_tokens += counts.output_tokens

    def end(self, summary: RunSummary, most: int = 0) -> None:
        """Add a run that ended; `most` is the maximum number of calls that it could have made."""
        self.complete += summary.status == "complete"
        self.failed += summary.status != "complete"
        self.add(summary.counts)
        self.spared += max(0, most - summary.counts.calls)


class Notes(logging.Handler):
    """Keeps the messages of a worker for its report, since printing them would disturb the progress bars."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message, unless the same message is already kept."""
        line = record.getMessage()
        if line not in self.lines:
            self.lines.append(line)


@dataclass(frozen=True)
class Played:
    """A run that this worker has played to its end, or had begun when the worker was stopped.

    Attributes:
        started: time of the start, ISO 8601, UTC.
        seconds: wall time, seconds.
    """

    folder: RunFolder
    writer: RunWriter
    started: str
    seconds: float


@dataclass
class Lane:
    """A worker that plays runs.

    Attributes:
        fatal: the cause that must end the sweep, or None.
        stopping: whether it stops after the current step of its runs.
    """

    spec: LaneSpec
    notes: Notes = field(default_factory=Notes)
    fatal: str | None = None
    stopping: bool = False
    _tallies: dict[str, Tally] = field(default_factory=dict)
    _open: dict[str, tuple[str, RunWriter]] = field(default_factory=dict)
    _most: dict[str, int] = field(default_factory=dict)
    _limits: Shared = field(init=False)
    _parts: dict[str, Any] = field(default_factory=dict)
    _heard: dict[str, dict[str, Any]] | None = None
    _more: int = 0
    _built: dict[str, Any] = field(default_factory=dict)
    _models: dict[str, Model] = field(default_factory=dict)
    _texts: dict[int, str] = field(default_factory=dict)
    _answers: Answers | None = None
    _stopped: list[Played] = field(default_factory=list)
    _changes: list[ModelChangedError] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._limits = Shared(self.spec.name, self.spec.workers, apart=self.spec.apart)

    def run(self) -> str | None:
        """Play runs until none is left; return the cause that must end the sweep, or None."""
        self.stopping = self.spec.folder.stop_asked(self.spec.session)
        stop_reporting = threading.Event()
        reporter = threading.Thread(target=self._report_until, args=(stop_reporting,), daemon=True)
        reporter.start()
        try:
            with garbage_sought_seldom():
                asyncio.run(self._work())
        finally:
            stop_reporting.set()
            reporter.join()
            self._report()
            if self._answers is not None:
                self._answers.close()
        return self.fatal

    async def _work(self) -> None:
        folders = {folder.id: folder for folder in self.spec.folder.runs()}
        try:
            await self._take([folders[run] for run in self.spec.suspects], at_once=1)
            await self._take([folders[run] for run in self.spec.runs], at_once=self.spec.open_runs)
            await self._confirm()
            self._fail_spoiled()
        finally:
            self._parts = {}
            for model in self._models.values():
                await model.close()

    def _exchange(self) -> None:
        """Update the limits on calls from the other workers' reports, if this worker has read new reports."""
        reports, self._heard = self._heard, None
        if reports is not None:
            self._limits.exchange({name: report.get("limits", {}) for name, report in reports.items()})
            self._parts = self._limits.report()
            if self._limits.have_room():
                self._more = min(MOST_OPEN, 1 + self._more + len(self._open) // 8)

    async def _confirm(self) -> None:
        for model in self._models.values():
            try:
                await model.confirm()
            except ServerError as error:
                self._stop(error)
            except TransientError as error:
                logging.getLogger("foundry").warning("%s", error)

    def _fail_spoiled(self) -> None:
        """Record a stopped run as failed if it used answers that may come from other weights."""
        for played in self._stopped:
            if any(self._is_spoiled(played.folder, change) for change in self._changes):
                with played.folder.claim() as mine:
                    if mine and not played.folder.ended:
                        self._end(played, self._changes[0])

    @staticmethod
    def _is_spoiled(folder: RunFolder, change: ModelChangedError) -> bool:
        return any(call.key in change.keys for call in folder.calls())

    async def _take(self, folders: Iterable[RunFolder], *, at_once: int) -> None:
        waiting, elsewhere = deque(folders), deque[RunFolder]()
        tasks: dict[asyncio.Task[bool], RunFolder] = {}
        while (waiting or elsewhere or tasks) and not (self.stopping and not tasks):
            while waiting and len(tasks) < self._open_runs(at_once) and not self.stopping:
                folder = waiting.popleft()
                if not folder.ended:
                    tasks[asyncio.create_task(self._settle(folder))] = folder
            if tasks:
                done, _ = await asyncio.wait(tasks, timeout=REPORT_EVERY_S, return_when=asyncio.FIRST_COMPLETED)
                settled = {tasks.pop(task): task.result() for task in done}
                elsewhere.extend(folder for folder, mine in settled.items() if not mine)
            elif elsewhere:
                self._say_whether_waiting(elsewhere)
                await asyncio.sleep(RETRY_CLAIM_S)
                waiting, elsewhere = elsewhere, deque()
            self._exchange()

    def _say_whether_waiting(self, elsewhere: Iterable[RunFolder]) -> None:
        """Say, once in a session, that this worker waits because other commands are playing the remaining runs."""
        reports = self.spec.folder.progress(beside=self.spec.name).items()
        others = (report for name, report in reports if not self.spec.is_of_session(name))
        opened = {run for report in others for run in report["open"]}
        if any(run.id in opened for run in elsewhere) and self.spec.folder.told_first(self.spec.session):
            logging.getLogger("foundry").warning(WAITING, self.spec.folder.path)

    def _open_runs(self, least: int) -> int:
        """Return how many runs to play at once: `least`, or more if `least` is above 1 and a server has room."""
        return least if least == 1 else max(least, min(MOST_OPEN, least + self._more))

    async def _settle(self, folder: RunFolder) -> bool:
        """Play a run that has not ended; return False if another worker is playing it."""
        try:
            with folder.claim() as mine:
                if mine and not folder.ended:
                    await self._play(folder)
                return mine
        except StorageError as error:
            self._stop(error)
            return True

    async def _play(self, folder: RunFolder) -> None:
        RUN.set(folder.id)
        config = folder.config()
        name = str(config["model"]["name"])
        writer = RunWriter(folder, self._config_text(folder))
        self._open[folder.id] = name, writer
        self._report()
        started, clock = _now(), time.perf_counter()
        failure: Exception | None = None
        was_stopped = False
        try:
            await self._episode(folder, config, writer)
            await self._settle_answers(folder, self._model(config["model"]))
        except Interrupted:
            was_stopped = True
        except StorageError:
            raise
        except ServerError as error:
            failure = error
            self._stop(error)
        except Exception as error:  # noqa: BLE001 - the boundary: a run that fails is data, with its cause
            failure = error
        finally:
            del self._open[folder.id]
            writer.close()
        played = Played(folder, writer, started, time.perf_counter() - clock)
        if was_stopped:
            self._stopped.append(played)
        else:
            self._end(played, failure)

    async def _settle_answers(self, folder: RunFolder, model: Model) -> None:
        """Ask the server at the end of a run to confirm that it has the same weights; only then is the run complete.

        Raises:
            ModelChangedError: the run used answers that may come from other weights.
            UnconfirmedError: the server does not answer.
        """
        try:
            await model.confirm()
        except TransientError as error:
            raise UnconfirmedError(f"The run is over, but {error}") from error
        except ModelChangedError as error:
            self._stop(error)
            if self._is_spoiled(folder, error):
                raise

    def _end(self, played: Played, failure: Exception | None) -> None:
        summary = summarise(
            played.folder,
            self.spec.infos,
            played.writer,
            self._models.get(settings_key(played.folder.config()["model"])),
            started=played.started,
            seconds=played.seconds,
            error=failure,
        )
        write_run_summary(played.folder, summary)
        self._tallies.setdefault(summary.model, Tally()).end(summary, self._most.pop(played.folder.id, 0))

    async def _episode(self, folder: RunFolder, config: dict[str, Any], writer: RunWriter) -> None:
        scenario = self._shared(config["world"])
        self._most[folder.id] = scenario.count_calls()
        prompt = self._shared(config["prompt"])
        info = self.spec.infos[settings_key(config["model"])]
        asker = asker_of(config, scenario, prompt, self._model(config["model"]), info)
        writer.members = asker.model.roster()
        await play(
            scenario.start(config["seed"]),
            forked(asker, config, self.spec.folder),
            writer,
            frame_every=self.spec.frame_every,
            ahead=self.spec.ahead,
            stopping=lambda: self.stopping,
        )

    def _config_text(self, folder: RunFolder) -> str:
        """Return the configuration of a run as YAML; the runs of a condition only differ in the seed."""
        index = folder.run.condition
        if index not in self._texts:
            self._texts[index] = to_yaml(dict(self.spec.folder.sweep.conditions[index].config))
        return f"{self._texts[index]}seed: {folder.run.seed}\n"

    def _shared(self, config: Mapping[str, Any]) -> Any:
        key = settings_key(config)
        if key not in self._built:
            self._built[key] = build(config)
        return self._built[key]

    def _model(self, config: Mapping[str, Any]) -> Model:
        key = settings_key(config)
        if key not in self._models:
            limit = self._limits.maker(key)
            self._models[key] = model_stack(build(config), self._cache, self.spec.infos[key], limit)
        return self._models[key]

    def _cache(self) -> Answers:
        if self._answers is None:
            try:
                self._answers = open_answers(self.spec.cache)
            except InputError as error:
                raise StorageError(str(error)) from error
        return self._answers

    def _stop(self, error: FoundryError) -> None:
        """Stop the open runs and the sweep, because every further run would end with the same error."""
        self.fatal, self.stopping = self.fatal or str(error), True
        if isinstance(error, ModelChangedError) and error not in self._changes:
            self._changes.append(error)

    def _report_until(self, stop: threading.Event) -> None:
        while not stop.wait(REPORT_EVERY_S):
            if self.spec.parent is not None and os.getppid() != self.spec.parent:
                os._exit(1)
            self.stopping = self.stopping or self.spec.folder.stop_asked(self.spec.session)
            self._report()
            if self._limits.limits:
                with contextlib.suppress(OSError):  # some systems do not allow reading a file while it is replaced
                    self._heard = self.spec.folder.progress(beside=self.spec.name)

    def _report(self) -> None:
        models = {name: Tally(**vars(tally)) for name, tally in list(self._tallies.items())}
        opened, most = list(self._open.items()), dict(self._most)
        for _, (name, writer) in opened:
            models.setdefault(name, Tally()).add(writer.counts)
        report = {
            "pid": os.getpid(),
            "stopping": self.stopping,
            "open": [run for run, _ in opened],
            "most": {run: most[run] for run, _ in opened if run in most},
            "counts": {run: writer.counts for run, (_, writer) in opened},
            "models": models,
            "limits": self._parts,
            "in_flight": self._limits.together,
            "removed": sum(change.removed for change in list(self._changes)),
            "notes": self.notes.lines[-MOST_NOTES:],
        }
        try:
            write_atomically(self.spec.folder.progress_file(self.spec.name), msgspec.json.encode(report))
        except FileNotFoundError:  # this worker's command has ended its session
            return
        except OSError as error:
            self._stop(cannot_write(self.spec.folder.path, error))


def run_lane(spec: LaneSpec) -> str | None:
    """Work as a worker in a process of its own, whose parent handles Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    own_code.use(spec.own)  # a worker on a cluster lacks the environment variables of its command
    share_cores(spec.workers)
    lane = Lane(spec)
    if sys.stderr.isatty():
        logging.getLogger("foundry").addHandler(lane.notes)
    return lane.run()


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")


def summarise(
    folder: RunFolder,
    infos: Mapping[str, ModelInfo],
    writer: RunWriter | None,
    model: Model | None = None,
    *,
    started: str,
    seconds: float,
    error: Exception | None,
) -> RunSummary:
    """Return the content of `run.json`; `writer` is None if the process that wrote the records has died."""
    config = folder.config()
    info = infos[settings_key(config["model"])]
    versions = provenance.versions()
    expected = isinstance(error, FoundryError)
    return RunSummary(
        run=folder.id,
        status="complete" if error is None else "failed",
        world=config["world"]["name"],
        model=config["model"]["name"],
        prompt=config["prompt"]["name"],
        seed=config["seed"],
        sampling_seed=config["sampling_seed"],
        foundry_version=versions["foundry"],
        python_version=versions["python"],
        packages={name: versions[name] for name in provenance.PACKAGES},
        git_commit=provenance.git_commit(),
        model_digest=info.digest,
        server_version=info.server_version,
        counts=writer.counts if writer else Counts(),
        started=started,
        ended=_now(),
        duration_s=round(seconds, 6),
        error=None if error is None else without_secrets(str(error)) or type(error).__name__,
        error_type=None if error is None else type(error).__name__,
        traceback=None if error is None or expected else without_secrets("".join(traceback.format_exception(error))),
        records_sha256=writer.digests() if writer else {},
        members=writer.members if writer else (),
        origin=origin_of(config),
        readers=provenance.READERS,
        form=folder.declared.form,
        canaries=model.canaries() if model else (),
    )
