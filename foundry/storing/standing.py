"""The progress of a sweep: counts for each model, failed runs, and unreadable replies."""

import contextlib
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from foundry.errors import RecordError
from foundry.records import Call, Counts, Outcome, RunSummary, reused_share
from foundry.storing.matching import place_of, with_calls
from foundry.storing.run_files import count_call
from foundry.storing.store import RunFolder, SweepFolder, lines_of
from foundry.texts import one_line, visible, without_secrets
from foundry.worlds.base import QuestionKey

LEAST_SHARE = 0.02
"""If the share of unreadable replies of a model is at least this, foundry reports it."""
_UNREAD = {
    Outcome.UNREADABLE: "contain no decision",
    Outcome.EMPTY: "empty",
    Outcome.TRUNCATED: "truncated",
    Outcome.FAILED: "aborted by the server",
}
_SCHEMA_HELPS = (Outcome.UNREADABLE, Outcome.EMPTY)
_EXAMPLES = 3
_SHOWN = 160
"""Maximum length of an example of an unreadable reply, characters."""
_OUTCOME = "outcome"
_PARTS = ("edit", "format")
"""Swept settings of a probe. Unreadable replies are counted separately for each edit and for each format."""


class Standing(msgspec.Struct, kw_only=True):
    """The progress of one model's runs in a sweep, with the calls of runs that have not ended.

    Attributes:
        runs: number of runs; each is complete, failed, running or waiting.
        calls: number of calls so far, including calls that the cache answered.
        cached: number of calls that foundry's cache answered.
        retries: number of repeated calls after an error.
        prompt_cache: share of prompt tokens that servers had in their own caches; None if no server reports it.
    """

    model: str
    runs: int = 0
    complete: int = 0
    failed: int = 0
    running: int = 0
    waiting: int = 0
    calls: int = 0
    cached: int = 0
    retries: int = 0
    prompt_cache: float | None = None


class Failure(msgspec.Struct, frozen=True):
    """A failed run and its error."""

    run: str
    error: str | None


def standings(folder: SweepFolder, summaries: Sequence[RunSummary | None]) -> list[Standing]:
    """Return the progress of a sweep for each model; `summaries` contains each run's `run.json`, in order."""
    reports = folder.progress().values()
    so_far = counts_so_far(folder, summaries, reports)
    opened = {run for report in reports for run in report["open"]}
    rows: dict[str, Counter[str]] = {}
    counted: dict[str, list[Counts]] = {}
    for run, summary, counts in zip(folder.runs(), summaries, so_far, strict=True):
        name = str(run.config()["model"]["name"])
        row = rows.setdefault(name, Counter())
        row["runs"] += 1
        row[summary.status if summary else "running" if run.id in opened else "waiting"] += 1
        row.update(calls=counts.calls, cached=counts.cached, retries=counts.retries)
        counted.setdefault(name, []).append(counts)
    return [Standing(model=name, **row, prompt_cache=reused_share(counted[name])) for name, row in rows.items()]


def counts_so_far(
    folder: SweepFolder, summaries: Sequence[RunSummary | None], reports: Iterable[Mapping[str, Any]]
) -> Iterator[Counts]:
    """Yield the counts of each run, in order, from each run's `run.json` and the progress reports of the workers.

    If a run has begun but not ended, its worker reports its counts. If it was interrupted, its log of calls is counted.
    """
    reported = {run: counts for report in reports for run, counts in report.get("counts", {}).items()}
    begun = folder.begun()
    for run, summary in zip(folder.runs(), summaries, strict=True):
        if summary is not None:
            yield summary.counts
        elif run.id in reported:
            yield msgspec.convert(reported[run.id], Counts)
        else:
            yield _logged(run) if run.id in begun else Counts()


def _logged(run: RunFolder) -> Counts:
    """Return the counts of a run's logged calls, up to the first damaged one."""
    counts = Counts()
    with contextlib.suppress(RecordError):
        for call in run.calls():
            count_call(counts, call)
    return counts


def failures(summaries: Iterable[RunSummary | None]) -> list[Failure]:
    """Return the runs that failed, with their errors; an unexpected error begins with its type."""
    failed = [summary for summary in summaries if summary is not None and summary.status != "complete"]
    return [
        Failure(summary.run, f"{summary.error_type}: {summary.error}" if summary.traceback else summary.error)
        for summary in failed
    ]


@dataclass
class UnreadableReplies:
    """The unreadable replies of a model.

    Attributes:
        outcomes: number of unreadable replies, by outcome.
        replies_by_part: for a probe, number of all replies, by edit and format, such as "edit no_fire".
        unread_by_part: for a probe, number of unreadable replies, by edit and format.
        examples: lines that show unreadable replies.
        schema: whether `model.format=schema` would force the server to reply in the requested form.
    """

    model: str
    replies: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    replies_by_part: Counter[str] = field(default_factory=Counter)
    unread_by_part: Counter[str] = field(default_factory=Counter)
    examples: list[str] = field(default_factory=list)
    schema: bool = False

    @property
    def share(self) -> float:
        """Share of unreadable replies, 0 to 1."""
        return self.outcomes.total() / self.replies if self.replies else 0.0

    @property
    def share_by_part(self) -> dict[str, float]:
        """Share of unreadable replies for each edit and format of a probe; the largest share comes first."""
        parts = {part: self.unread_by_part[part] / count for part, count in self.replies_by_part.items() if count}
        return dict(sorted(parts.items(), key=lambda item: -item[1]))

    def lines(self) -> list[str]:
        """Return the lines of a report; control characters in the replies are escaped."""
        kinds = ", ".join(f"{count:,} {_UNREAD[Outcome(outcome)]}" for outcome, count in self.outcomes.items())
        said = f"{visible(self.model)}: {self.share:.1%} of {self.replies:,} replies are unreadable ({kinds})"
        said += ". Examples:" if self.examples else ""
        shares = [f"{part}: {share:.1%}" for part, share in self.share_by_part.items()]
        parts = ["; ".join(shares)] if len(shares) > 1 else []
        hint = ["try model.format=schema to force valid JSON"] if self.schema else []
        return [said, *(f"  {line}" for line in (*parts, *self.examples, *hint))]


def unread(runs: Iterable[RunFolder]) -> list[UnreadableReplies]:
    """Return each model with at least the share LEAST_SHARE of unreadable replies, overall or under one edit."""
    by_model: dict[str, UnreadableReplies] = {}
    having: dict[str, list[RunFolder]] = {}
    for run in runs:
        summary = run.summary()
        if summary is None:
            continue
        unreadable = by_model.setdefault(summary.model, UnreadableReplies(summary.model))
        outcomes = Counter(summary.counts.outcomes) + Counter(summary.counts.message_outcomes)
        unreadable.replies += outcomes.total()
        if part := ", ".join(f"{name} {run.factors[name]}" for name in _PARTS if name in run.factors):
            unreadable.replies_by_part[part] += outcomes.total()
            unreadable.unread_by_part[part] += sum(outcomes[outcome] for outcome in _UNREAD)
        lost = Counter({outcome: outcomes[outcome] for outcome in _UNREAD if outcomes[outcome]})
        unreadable.outcomes += lost
        if lost:
            having.setdefault(summary.model, []).append(run)
    many = [
        unreadable
        for unreadable in by_model.values()
        if unreadable.outcomes and max([unreadable.share, *unreadable.share_by_part.values()]) >= LEAST_SHARE
    ]
    for unreadable in many:
        _illustrate(unreadable, having[unreadable.model])
    return many


def _illustrate(unread_replies: UnreadableReplies, runs: Iterable[RunFolder]) -> None:
    """Add different examples of unreadable replies, and whether `model.format=schema` can make them readable."""
    texts: set[str] = set()
    for run, outcome, call in itertools.chain.from_iterable(map(_unread_calls, runs)):
        text = text_of(call)
        if text in texts:
            continue
        texts.add(text)
        unread_replies.examples.append(
            f"{run.id}, step {call.step}, agent {call.agent}, {call.kind}: {_shortened(text)}"
        )
        unread_replies.schema = unread_replies.schema or (
            outcome in _SCHEMA_HELPS and _takes_schema(run.config()["model"], call.kind)
        )
        if len(texts) == _EXAMPLES:
            return


def text_of(call: Call) -> str:
    """Return the text of a reply; if it is empty, the error of the call's last try."""
    if call.text.strip():
        return call.text
    return without_secrets(call.attempts[-1].error) if call.attempts else "(no text)"


def _unread_calls(run: RunFolder) -> Iterator[tuple[RunFolder, str, Call]]:
    """Yield the run, the outcome and the call of each unreadable reply; stop at the first damaged record."""
    with contextlib.suppress(RecordError):
        for outcome, call in with_calls(_outcomes_in(run), run.calls()):
            if outcome in _UNREAD and call is not None:
                yield run, outcome, call


def is_unread(outcome: str) -> bool:
    """Return whether a reply with this outcome is unreadable."""
    return outcome in _UNREAD


def outcomes_by_place(run: RunFolder) -> dict[QuestionKey, list[str]]:
    """Return the outcomes of all replies to a question, for each question with an outcome other than `chosen`.

    A question is left out if it has more replies than calls, or fewer, since the match is unknown.
    """
    outcomes = list(_outcomes_in(run))
    places = {place for place, outcome in outcomes if outcome != Outcome.CHOSEN}
    if not places:
        return {}
    by_place: dict[QuestionKey, list[str]] = {place: [] for place in places}
    for place, outcome in outcomes:
        if place in places:
            by_place[place].append(outcome)
    calls = Counter(place for call in run.calls() if (place := place_of(call)) in places)
    return {place: known for place, known in by_place.items() if len(known) == calls[place]}


def _outcomes_in(run: RunFolder) -> Iterator[tuple[QuestionKey, str]]:
    """Yield the question (step, agent and kind) and the outcome of each reply of a run."""
    deciding = next(iter(run.declared.actions), "")
    for line in lines_of(run.steps_bytes(), dict[str, Any], run.stream_path("steps")):
        for name in line:
            if name.endswith(_OUTCOME):
                kind = name.removesuffix(_OUTCOME).rstrip("_") or line.get("kind", deciding)
                yield (line["step"], line["agent"], kind), str(line[name])


def _takes_schema(config: Mapping[str, Any], kind: str) -> bool:
    """Return whether a model or one of its members could use a schema for this kind of question, but does not."""
    if "format" in config and config["format"] is None and kind in (config.get("schemas") or {}):
        return True
    return any(_takes_schema(value, kind) for value in config.values() if isinstance(value, Mapping))


def _shortened(text: str) -> str:
    return one_line(visible(text[: _SHOWN * 4]), _SHOWN)
