"""Replays recorded runs from their recorded answers, without a server, and compares every byte."""

import asyncio
import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import msgspec

from foundry import provenance
from foundry.episode import play
from foundry.errors import ModelChangedError, RecordError, UnconfirmedError
from foundry.expansion import settings_key
from foundry.own_code import own_folders, use_only
from foundry.records import NOT_JSON, Call, Counts, Record, RunSummary, SeenImage
from foundry.running.build import build
from foundry.running.cores import share_cores
from foundry.running.recorded import (
    CALLS,
    NOTHING,
    Departed,
    Difference,
    NotRecorded,
    RecordedAsker,
    first_difference,
    wordings,
)
from foundry.storing.plain import check_folder
from foundry.storing.run_files import sha256_of
from foundry.storing.store import SWEEP_FILE, RunFolder, SweepFolder, frame_name, stored_picture
from foundry.texts import counted
from foundry.trust.manifest import NAME, bundled_runs
from foundry.trust.summaries import (
    COMPLETE,
    Renderers,
    check_config,
    check_declared,
    check_digests,
    check_summary,
    departed_note,
    is_of_pictures,
    renderers_of,
)

_ENCODE = msgspec.json.Encoder().encode
_AFTER_THE_END = frozenset((ModelChangedError.__name__, UnconfirmedError.__name__))
"""Errors with which a run can fail after its last step: other weights may have given its answers."""
_CHUNKS = 8
"""A worker gets its runs in about this number of groups, one after another."""


class Verdict(StrEnum):
    """The verdict on a run: whether its replay gives the recorded files."""

    IDENTICAL = "identical"
    DIFFERS = "differs"
    READ_OTHERWISE = "recorded with other readers"
    DRAWN_OTHERWISE = "drawn by another renderer"
    MISSING = "missing"
    NOT_ENDED = "not ended"
    NOT_STARTED = "not started"


@dataclass(frozen=True)
class VerifiedRun:
    """The result for one run.

    Attributes:
        verdict: whether the records follow from the recorded answers.
        lines: number of lines that were compared and are identical.
        calls: number of questions that were asked again and are identical.
        difference: the first difference; None if there is none.
        note: remark, such as that the run has not ended; "" if there is none.
    """

    run: str
    verdict: Verdict
    lines: int = 0
    calls: int = 0
    difference: Difference | None = None
    note: str = ""


class EndOfRecords(RecordError):
    """The replay has reached the end of the records of an unfinished run."""


class Comparer:
    """Compares the records of a replayed episode with the lines of the recorded files."""

    def __init__(self, run: RunFolder, *, ended: bool) -> None:
        """Read the files of a recorded run; if it has not ended, its last lines may be cut or missing."""
        self._run = run
        self._ended = ended
        self._lines = {name: _lines(run.stream_path(name), whole_only=not ended) for name in _streams(run)}
        self._next = dict.fromkeys(self._lines, 0)
        self.counts = Counts()
        self.renderers: Renderers | None = None

    @property
    def compared(self) -> int:
        """Number of lines that were compared."""
        return sum(self._next.values())

    def append(self, records: Sequence[Record]) -> None:
        """Compare each record of the replay with the next recorded line of its file."""
        self._run.check_declared(record.stream for record in records)
        for record in records:
            record.tally(self.counts)
            if isinstance(record, SeenImage):
                self._compare_file(record.path, record.content)
            elif record.stream in self._lines:
                self._compare_line(record.stream, _ENCODE(record))

    def append_calls(self, calls: Sequence[Call]) -> None:
        """Count the calls and their tokens; `RecordedAsker` has already compared these calls with the recorded ones."""
        for call in calls:
            self.counts.calls += 1
            self.counts.add_tokens(call)

    def frame(self, step: int, png: bytes) -> None:
        """Compare a picture of the state after a step with the stored picture."""
        self._compare_file(frame_name(step), png)

    def check_end(self) -> None:
        """Raise an error if the recorded files have more lines than the replay wrote."""
        for name, lines in self._lines.items():
            at = self._next[name]
            if at < len(lines):
                raise Departed(Difference(f"{name}.jsonl", at + 1, "", lines[at].decode("utf-8", "replace"), NOTHING))

    def _compare_line(self, stream: str, now: bytes) -> None:
        at, lines = self._next[stream], self._lines[stream]
        recorded = lines[at] if at < len(lines) else None
        if recorded is None and not self._ended:
            raise EndOfRecords(f"{stream}.jsonl has {at} lines")
        if recorded != now and not self._drawn_otherwise(recorded, now):
            raise Departed(_line_difference(f"{stream}.jsonl", at + 1, recorded, now))
        self._next[stream] = at + 1

    def _drawn_otherwise(self, recorded: bytes | None, now: bytes) -> bool:
        """Return whether two recorded lines differ only in the name of the renderer; such a difference is no error."""
        renderers = renderers_of(recorded, now)
        self.renderers = self.renderers or renderers
        return renderers is not None

    def _compare_file(self, name: str, now: bytes) -> None:
        recorded = stored_picture(self._run.path, name)
        if recorded != now:
            then = NOTHING if recorded is None else sha256_of(recorded)
            raise Departed(Difference(name, None, "SHA-256", then, sha256_of(now)))


def verify(
    folder: SweepFolder, runs: Sequence[RunFolder], *, workers: int, frames: bool = False
) -> Iterator[VerifiedRun]:
    """Yield the result for each run, as soon as it is known; `frames` says whether to draw stored frames again."""
    bundled = bundled_runs(folder.path)
    for verified in _in_workers(folder, runs, workers, frames):
        yield _unless_missing(verified) if verified.run in bundled else verified


def _unless_missing(verified: VerifiedRun) -> VerifiedRun:
    if verified.verdict not in (Verdict.NOT_STARTED, Verdict.NOT_ENDED):
        return verified
    note = f"is missing: {NAME} says that it has ended, but its run.json is not in the folder"
    return replace(verified, verdict=Verdict.MISSING, note=note)


def _in_workers(folder: SweepFolder, runs: Sequence[RunFolder], workers: int, frames: bool) -> Iterator[VerifiedRun]:
    if workers == 1:
        yield from _verify_all(runs, frames)
        return
    from joblib import Parallel, delayed

    ids = [run.id for run in runs]
    size = max(1, len(ids) // (workers * _CHUNKS))
    portions = [ids[start : start + size] for start in range(0, len(ids), size)]
    jobs = (
        delayed(_verify_portion)(folder.path.absolute(), portion, frames, workers, own_folders())
        for portion in portions
    )
    for results in Parallel(n_jobs=workers, return_as="generator_unordered")(jobs):
        yield from results


def _verify_portion(
    path: Path, ids: Sequence[str], frames: bool, workers: int, own: Sequence[Path]
) -> list[VerifiedRun]:
    use_only(own)
    share_cores(workers)
    wanted = set(ids)
    return list(_verify_all([run for run in SweepFolder.open(path).runs() if run.id in wanted], frames))


def _verify_all(runs: Sequence[RunFolder], frames: bool) -> Iterator[VerifiedRun]:
    scenarios: dict[str, Any] = {}
    for run in runs:
        config = run.config()
        key = settings_key(config["world"])
        if run.path.exists() and key not in scenarios:
            scenarios[key] = build(config["world"])
        yield _verify_run(run, config, scenarios.get(key), frames)


def _verify_run(run: RunFolder, config: Mapping[str, Any], scenario: Any, frames: bool) -> VerifiedRun:
    if not run.path.exists():
        return VerifiedRun(run.id, Verdict.NOT_STARTED)
    check_folder(run.path)
    file = "run.json"
    try:
        summary = run.summary()
        file = CALLS
        asker = RecordedAsker(run.calls(), wordings(config))
    except RecordError as error:
        damage = Difference(file, None, "", f"damaged: {error.__cause__ or error}", "readable")
        return VerifiedRun(run.id, Verdict.DIFFERS, difference=damage)
    comparer = Comparer(run, ended=summary is not None)
    every = int(config.get("record", {}).get("frames", False)) if frames else 0
    try:
        check_declared(run, scenario.declared(), summary)
        note = _replay(scenario.start(config["seed"]), asker, comparer, summary, every)
        check_digests(run, summary)
        check_summary(config, summary, comparer.counts, asker.calls)
        check_config(run, run.recorded_config(), summary)
    except Departed as departed:
        verified = _departed(run, summary, departed.difference, comparer.compared, asker.used)
        return _drawn(run, verified, comparer.renderers, scenario, config)
    drew = comparer.renderers
    note = note or (f"was drawn by {drew.then}. Here, {drew.now} draws the same pixels" if drew else "")
    verdict = Verdict.NOT_ENDED if summary is None else Verdict.IDENTICAL
    return VerifiedRun(run.id, verdict, comparer.compared, asker.used, note=note)


def _drawn(
    run: RunFolder, verified: VerifiedRun, drew: Renderers | None, scenario: Any, config: Mapping[str, Any]
) -> VerifiedRun:
    """Return the result for a run that differs from its replay.

    If only another renderer drew the pictures, the verdict says so.
    """
    if drew is None or verified.difference is None or not is_of_pictures(verified.difference):
        return verified
    questions = scenario.start(config["seed"]).pending()
    note = departed_note(run, drew, verified.difference, (image for question in questions for image in question.images))
    if note is None:
        return verified
    return replace(verified, verdict=Verdict.DRAWN_OTHERWISE, difference=None, note=note)


def _departed(
    run: RunFolder, summary: RunSummary | None, difference: Difference, lines: int, calls: int
) -> VerifiedRun:
    """Return the result for a run that differs from its replay.

    The verdict says whether the cause can be that another version of foundry read the replies of the run.
    """
    readers = _other_readers(summary)
    may_follow = (*(f"{name}.jsonl" for name in run.streams), CALLS, SWEEP_FILE)  # from another reading of replies
    if not readers or difference.file not in may_follow:
        return VerifiedRun(run.id, Verdict.DIFFERS, lines, calls, difference)
    try:
        check_digests(run, summary)
    except Departed as departed:
        return VerifiedRun(run.id, Verdict.DIFFERS, lines, calls, departed.difference)
    note = (
        f"was recorded with {readers}. These versions read replies differently, so the run cannot be verified here. "
        "The run's files have not changed since the run ended. The first reply that is read differently: "
        f"{difference.line()}"
    )
    return VerifiedRun(run.id, Verdict.READ_OTHERWISE, lines, calls, note=note)


def _other_readers(summary: RunSummary | None) -> str:
    """Return a text with the recorded and the present version of the code that reads replies; "" if they are equal."""
    if summary is None:
        return ""
    mending = provenance.MENDING
    then, now = summary.packages.get(mending), provenance.versions()[mending]
    if summary.readers != provenance.READERS:
        return f"readers {summary.readers} of foundry {summary.foundry_version} (readers {provenance.READERS} here)"
    return "" if then == now else f"{mending} {then} ({now} here)"


def _replay(world: Any, asker: RecordedAsker, comparer: Comparer, summary: RunSummary | None, every: int) -> str:
    """Replay an episode and compare it with its records; return a remark if the run is not complete, else ""."""
    complete = summary is not None and summary.status == COMPLETE
    try:
        asyncio.run(play(world, asker, comparer, frame_every=every))
        comparer.check_end()
        _check_status(summary)
    except EndOfRecords:
        return _note(world, summary)
    except NotRecorded as end:
        if complete:
            raise Departed(Difference(CALLS, None, "", NOTHING, "a question", place=end.place)) from end
        comparer.check_end()
    except Departed:
        raise
    except Exception as error:  # noqa: BLE001 - the boundary: a run that failed here must fail here again
        _check_failure(error, summary)
        comparer.check_end()
    if complete and asker.used < asker.recorded:
        raise Departed(Difference(CALLS, None, "number of calls", asker.recorded, asker.used))
    return _note(world, summary)


def _check_status(summary: RunSummary | None) -> None:
    """Raise an error if the replay reached the end of the episode, but the record says that the run failed earlier."""
    if summary is not None and summary.error_type in _AFTER_THE_END:
        return
    # A worker may have crashed at the very end, before it recorded the digests of its files.
    if summary is not None and summary.status != COMPLETE and summary.records_sha256:
        raise Departed(Difference("run.json", None, "status", summary.status, COMPLETE))


def _check_failure(error: Exception, summary: RunSummary | None) -> None:
    now = (type(error).__name__, str(error) or type(error).__name__)
    then = (summary.error_type, summary.error) if summary is not None else (None, None)
    if now != then:
        recorded = NOTHING if then[0] is None else f"{then[0]}: {then[1]}"
        raise Departed(Difference("run.json", None, "error", recorded, f"{now[0]}: {now[1]}")) from error


def _note(world: Any, summary: RunSummary | None) -> str:
    if summary is None:
        return f"has not ended: its records reach {counted(world.step, 'step')}"
    if summary.status != COMPLETE:
        return f"failed after {world.step} steps: {summary.error}"
    return ""


def _streams(run: RunFolder) -> tuple[str, ...]:
    """Return the names of the record files to compare; the first versions of foundry had no file of agents."""
    summary = run.summary()
    knew_agents = run.stream_path("agents").exists() if summary is None else summary.readers > 1
    return tuple(name for name in run.streams if knew_agents or name != "agents")


def _lines(path: Path, *, whole_only: bool) -> list[bytes]:
    content = path.read_bytes() if path.exists() else b""
    if whole_only:
        content = content[: content.rfind(b"\n") + 1]
    lines = content.split(b"\n")
    return lines[:-1] if not lines[-1] else lines


def _line_difference(file: str, number: int, recorded: bytes | None, now: bytes) -> Difference:
    """Return the first difference of two lines, or the whole lines if one is missing or not JSON."""
    fresh = msgspec.json.decode(now)
    place = (fresh["step"], fresh["agent"], fresh.get("kind", "record")) if {"step", "agent"} <= fresh.keys() else None
    difference = None
    with contextlib.suppress(*NOT_JSON):
        difference = None if recorded is None else first_difference(msgspec.json.decode(recorded), fresh)
    then = NOTHING if recorded is None else recorded.decode("utf-8", "replace")
    field, recorded_value, value_now = difference or ("", then, now.decode())
    return Difference(file, number, field, recorded_value, value_now, place)
