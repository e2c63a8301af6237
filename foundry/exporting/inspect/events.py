"""Calls as events of Inspect, one span a step; imported only where `inspect_ai` is installed."""

from __future__ import annotations

import base64
import itertools
import mimetypes
from collections.abc import Iterator, Mapping
from typing import Any

from inspect_ai.event import Event, ModelEvent, SpanBeginEvent, SpanEndEvent
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

from foundry.exporting.conditions import ExportedRun
from foundry.exporting.shared import sampling
from foundry.records import Call

_MESSAGES = {"system": ChatMessageSystem, "user": ChatMessageUser, "assistant": ChatMessageAssistant}
_ENDINGS = {"stop": "stop", "length": "max_tokens"}


def events(run: ExportedRun) -> Iterator[Event]:
    """Yield the calls of a run in the order of its log.

    Every event has the time at which the run started: a call's log has durations, and no clock.
    """
    times = {"timestamp": run.summary.started, "working_start": 0.0}
    calls = enumerate(run.calls())
    for number, (step, found) in enumerate(itertools.groupby(calls, key=lambda one: one[1].step)):
        span = f"{run.folder.id}-span-{number}"
        ids = [f"{span}-begin", f"{span}-end"]
        yield SpanBeginEvent(id=span, span_id=span, uuid=ids[0], type="step", name=f"step {step}", **times)
        for index, call in found:
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
    content = [ContentText(text=said["content"]), *(_image(run, one) for one in images)] if images else said["content"]
    return _MESSAGES[said["role"]](id=f"{call.key}-{index}", content=content)


def _image(run: ExportedRun, sha256: str) -> Content:
    """Return an image as it was sent; where it was not kept, its hash as data, which no model reads as text."""
    found = run.image(sha256)
    if found is None:
        return ContentData(data={"image_sha256": sha256, "kept": False})
    name, content = found
    kind = mimetypes.guess_type(name)[0]
    return ContentImage(image=f"data:{kind};base64,{base64.b64encode(content).decode()}")


def _config(call: Call) -> GenerateConfig:
    known = sampling(call.parameters)
    stop = known.pop("stop", None)
    return GenerateConfig(seed=call.seed, stop_seqs=[stop] if isinstance(stop, str) else stop, **known)


def _output(call: Call, seconds: float | None) -> ModelOutput:
    said = ContentText(text=call.text)
    content = call.text if call.thinking is None else [ContentReasoning(reasoning=call.thinking), said]
    message = ChatMessageAssistant(id=f"{call.key}-reply", content=content, source="generate", model=call.model)
    choice = ChatCompletionChoice(message=message, stop_reason=_ENDINGS.get(call.ending, "unknown"))
    return ModelOutput(model=call.served_model or call.model, choices=[choice], usage=usage(call), time=seconds)


def usage(call: Call) -> ModelUsage | None:
    """Return the tokens of a call, None where its server did not count them."""
    if call.prompt_tokens is None or call.output_tokens is None:
        return None
    return ModelUsage(
        input_tokens=call.prompt_tokens - (call.cached_tokens or 0),
        output_tokens=call.output_tokens,
        total_tokens=call.prompt_tokens + call.output_tokens,
        input_tokens_cache_read=call.cached_tokens,
    )


def _metadata(call: Call) -> dict[str, Any]:
    """Return what of a call Inspect has no field for."""
    return {
        "step": call.step,
        "agent": call.agent,
        "kind": call.kind,
        "digest": call.digest,
        "key": call.key,
        "parameters": call.parameters,
        "ending": call.ending,
        "timings": call.timings,
        "attempts": [{"error": one.error, "elapsed_s": one.elapsed_s, "busy": one.busy} for one in call.attempts],
        "server_version": call.server_version,
    }
