"""Writes the logs of Inspect, one for each condition; this module needs the package `inspect_ai`."""

from __future__ import annotations

import base64
import functools
import itertools
import mimetypes
import operator
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from inspect_ai.event import Event, ModelEvent, SpanBeginEvent, SpanEndEvent
from inspect_ai.log import (
    EvalConfig,
    EvalDataset,
    EvalError,
    EvalLog,
    EvalMetric,
    EvalResults,
    EvalSample,
    EvalScore,
    EvalSpec,
    EvalStats,
    write_eval_log,
)
from inspect_ai.model import (
    ChatCompletionChoice,
    ChatMessage,
    ChatMessageAssistant,
    ChatMessageSystem,
    ChatMessageUser,
    Content,
    ContentData,
    ContentImage,
    ContentReasoning,
    ContentText,
    GenerateConfig,
    ModelOutput,
    ModelUsage,
)
from inspect_ai.scorer import Score

from foundry.exporting.writing import ExportedCondition, ExportedRun, Files, Mean, Measured, Scores, sampling
from foundry.records import Call
from foundry.trust.summaries import COMPLETE

_MESSAGES = {"system": ChatMessageSystem, "user": ChatMessageUser, "assistant": ChatMessageAssistant}
_ENDINGS = {"stop": "stop", "length": "max_tokens"}
_NO_PART = re.compile(r"[^A-Za-z0-9.]")
"""Characters that the task's name in a file name must not have, since Inspect splits file names at underscores."""
_NO_TIME = (1980, 1, 1, 0, 0, 0)
"""The time that all members of an archive get: the earliest time that the format allows."""


def events(run: ExportedRun) -> Iterator[Event]:
    """Yield the calls of a run in their order, as events of an Inspect log. Each step is a span of events.

    The time of every event is the start of the run, because the log of calls has no times.
    """
    times = {"timestamp": run.summary.started, "working_start": 0.0}
    calls = enumerate(run.calls())
    for number, (step, calls_of_step) in enumerate(itertools.groupby(calls, key=lambda numbered: numbered[1].step)):
        span = f"{run.folder.id}-span-{number}"
        ids = [f"{span}-begin", f"{span}-end"]
        yield SpanBeginEvent(id=span, span_id=span, uuid=ids[0], type="step", name=f"step {step}", **times)
        for index, call in calls_of_step:
            yield _event(run, call, uuid=f"{run.folder.id}-call-{index}", span_id=span, **times)
        yield SpanEndEvent(id=span, span_id=span, uuid=ids[1], **times)


def _event(run: ExportedRun, call: Call, **where: Any) -> ModelEvent:
    seconds = call.timings.get("latency", call.timings.get("total"))
    return ModelEvent(
        model=call.model,
        input=[_message(run, call, index, said) for index, said in enumerate(call.messages)],
        tools=[],
        tool_choice="none",
        config=_config(call),
        output=_output(call, seconds),
        retries=len(call.attempts) or None,
        cache="read" if call.cached else None,
        working_time=seconds,
        metadata=_metadata(call),
        **where,
    )


def _message(run: ExportedRun, call: Call, index: int, said: Mapping[str, Any]) -> ChatMessage:
    images = said.get("images_sha256", ())
    content = (
        [ContentText(text=said["content"]), *(_image(run, image) for image in images)] if images else said["content"]
    )
    return _MESSAGES[said["role"]](id=f"{call.key}-{index}", content=content)


def _image(run: ExportedRun, sha256: str) -> Content:
    """Return an image as it was sent. If the image was not recorded, return only its SHA-256."""
    stored = run.image(sha256)
    if stored is None:
        return ContentData(data={"image_sha256": sha256, "kept": False})
    name, content = stored
    kind = mimetypes.guess_type(name)[0]
    return ContentImage(image=f"data:{kind};base64,{base64.b64encode(content).decode()}")


def _config(call: Call) -> GenerateConfig:
    known = sampling(call.parameters)
    stop = known.pop("stop", None)
    return GenerateConfig(seed=call.seed, stop_seqs=[stop] if isinstance(stop, str) else stop, **known)


def _output(call: Call, seconds: float | None) -> ModelOutput:
    text = ContentText(text=call.text)
    content = call.text if call.thinking is None else [ContentReasoning(reasoning=call.thinking), text]
    message = ChatMessageAssistant(id=f"{call.key}-reply", content=content, source="generate", model=call.model)
    choice = ChatCompletionChoice(message=message, stop_reason=_ENDINGS.get(call.ending, "unknown"))
    return ModelOutput(model=call.served_model or call.model, choices=[choice], usage=usage(call), time=seconds)


def usage(call: Call) -> ModelUsage | None:
    """Return the numbers of tokens of a call; None if its server did not report them."""
    if call.prompt_tokens is None or call.output_tokens is None:
        return None
    return ModelUsage(
        input_tokens=call.prompt_tokens - (call.cached_tokens or 0),
        output_tokens=call.output_tokens,
        total_tokens=call.prompt_tokens + call.output_tokens,
        input_tokens_cache_read=call.cached_tokens,
    )


def _metadata(call: Call) -> dict[str, Any]:
    return {
        "step": call.step,
        "agent": call.agent,
        "kind": call.kind,
        "digest": call.digest,
        "key": call.key,
        "parameters": call.parameters,
        "ending": call.ending,
        "timings": call.timings,
        "attempts": [
            {"error": attempt.error, "elapsed_s": attempt.elapsed_s, "busy": attempt.busy} for attempt in call.attempts
        ],
        "server_version": call.server_version,
    }


def write(conditions: Sequence[ExportedCondition], scores: Scores, folder: Path) -> Files:
    """Write a log of each condition into a folder; the same runs always give the same bytes."""
    return Files(tuple(_written(eval_log(condition, scores), folder) for condition in conditions))


def _written(log: EvalLog, folder: Path) -> Path:
    time = log.eval.created.replace(":", "-")
    path = folder / f"{time}_{_NO_PART.sub('-', log.eval.task)}_{log.eval.task_id}.eval"
    write_eval_log(log, str(path))
    _forget_times(path)
    return path


def eval_log(condition: ExportedCondition, scores: Scores) -> EvalLog:
    """Return the log of a condition, with a sample per run, an event per call, and a score per measure."""
    samples = [_sample(run, scores) for run in condition.runs]
    return EvalLog(
        status="success" if len(samples) == condition.asked else "cancelled",
        eval=_spec(condition, scores),
        results=_results(condition, scores),
        stats=EvalStats(
            started_at=condition.started,
            completed_at=condition.ended,
            model_usage=_sums(item for sample in samples for item in sample.model_usage.items()),
        ),
        samples=samples,
    )


def _spec(condition: ExportedCondition, scores: Scores) -> EvalSpec:
    first = condition.runs[0].summary
    seeds = [run.summary.seed for run in condition.runs]
    return EvalSpec(
        eval_id=condition.identity("eval", *condition.recorded).hex,
        run_id=condition.identity("run", condition.sweep).hex,
        task_id=condition.identity("task").hex,
        created=condition.started,
        task=condition.world,
        task_args=condition.factors,
        dataset=EvalDataset(name=f"seeds of {condition.world}", samples=len(seeds), sample_ids=seeds, shuffled=False),
        model=condition.model,
        config=EvalConfig(fail_on_error=False),
        packages={"foundry-worlds": first.foundry_version, **first.packages},
        metadata={
            "prompt": condition.prompt,
            "sweep": condition.sweep,
            "model_digest": first.model_digest,
            "server_version": first.server_version,
            "git_commit": first.git_commit,
            "config": condition.config,
        },
        scorers=[{"name": measure.name, "metadata": _described(measure)} for measure in scores.measures],
    )


def _described(measure: Measured) -> dict[str, Any]:
    ends = {"low": measure.low, "high": measure.high}
    return {"label": measure.label, **{name: str(end) for name, end in ends.items()}, "null": measure.null or None}


def _sample(run: ExportedRun, scores: Scores) -> EvalSample:
    summary, run_events = run.summary, list(events(run))
    failed = summary.status != COMPLETE
    error = EvalError(message=summary.error or "", traceback=summary.traceback or "", traceback_ansi="")
    return EvalSample(
        id=summary.seed,
        epoch=1,
        input=f"{summary.world}, seed {summary.seed}",
        target="",
        scores=None if failed else _scores(scores.of_runs.get(summary.run, {}), scores.measures),
        metadata={
            "run": summary.run,
            "sampling_seed": summary.sampling_seed,
            "form": run.folder.declared.form,
            "agents_of_models": {member.model: list(member.agents) for member in summary.members},
            "records_sha256": summary.records_sha256,
        },
        events=run_events,
        model_usage=_sums(_usages(run_events)),
        started_at=summary.started,
        completed_at=summary.ended,
        total_time=summary.duration_s,
        uuid=f"{summary.run}-{summary.ended}",
        error=error if failed else None,
    )


def _scores(values: Mapping[str, float], measures: Iterable[Measured]) -> dict[str, Score]:
    """Return the scores of a run; an undefined measure gets a score that does not count in means."""
    return {
        measure.name: Score(value=values[measure.name])
        if values[measure.name] == values[measure.name]
        else Score.unscored(explanation="undefined in this run")
        for measure in measures
        if measure.name in values
    }


def _usages(all_events: Iterable[Event]) -> Iterable[tuple[str, ModelUsage]]:
    calls = (event for event in all_events if isinstance(event, ModelEvent))
    return ((call.model, call.output.usage) for call in calls if call.output.usage is not None)


def _sums(parts: Iterable[tuple[str, ModelUsage]]) -> dict[str, ModelUsage]:
    by_model: dict[str, list[ModelUsage]] = {}
    for model, usage in parts:
        by_model.setdefault(model, []).append(usage)
    return {model: functools.reduce(operator.add, usages) for model, usages in by_model.items()}


def _results(condition: ExportedCondition, scores: Scores) -> EvalResults:
    means = scores.of_conditions.get(condition.number, {})
    return EvalResults(
        total_samples=condition.asked,
        completed_samples=condition.complete,
        scores=[
            _score(measure, means[measure.name], condition.complete)
            for measure in scores.measures
            if measure.name in means and means[measure.name].n
        ],
    )


def _score(measure: Measured, mean: Mean, complete: int) -> EvalScore:
    ends = {"ci_low": mean.low, "ci_high": mean.high, "std": mean.sd}
    values = {"mean": mean.mean, **{name: value for name, value in ends.items() if value == value}}
    return EvalScore(
        name=measure.name,
        scorer=measure.name,
        scored_samples=mean.n,
        unscored_samples=complete - mean.n,
        metrics={name: EvalMetric(name=name, value=value) for name, value in values.items()},
        metadata={**_described(measure), "interval": mean.interval and f"95 %, {mean.interval}"},
    )


def _forget_times(path: Path) -> None:
    """Rewrite an archive such that it does not contain the times at which its members were written."""
    again = path.with_name(f".{path.name}.part")
    with zipfile.ZipFile(path) as written, zipfile.ZipFile(again, "w") as copy:
        for member in written.infolist():
            timeless = zipfile.ZipInfo(member.filename, _NO_TIME)
            timeless.compress_type = member.compress_type
            copy.writestr(timeless, written.read(member))
    again.replace(path)
