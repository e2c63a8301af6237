"""Has a model say which messages of a sweep are warnings: one yes-or-no question a distinct text."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from string import Template
from typing import Any

import msgspec

from foundry.errors import FoundryError, InputError, RecordError
from foundry.labels import Labelled, Labels
from foundry.models.base import ChatMessage, Model, Request, RequestKeys
from foundry.storing.store import RunFolder, SweepFolder, lines_of
from foundry.texts import counted
from foundry.worlds.replies import without_thinking

KIND = "label"
"""The kind of question."""

SAMPLING_SEED = 0
"""Seed of every call: one and the same question has one answer."""

_EXCERPT = 60
"""Characters of an unreadable answer that its error shows."""

_ANSWER = re.compile(r"[\s\"'*_`#([{]*(yes|no)[\s\"'*_`.!)\]}]*", re.IGNORECASE)


@dataclass(frozen=True)
class Text:
    """What is to be labelled: a message, and the names of the fires in its world."""

    text: str
    fires: tuple[str, ...]


class _Fire(msgspec.Struct):
    name: str


class _Said(msgspec.Struct):
    message: str | None = None


def texts_of(sweep: SweepFolder) -> dict[Text, int]:
    """Return the distinct messages of a sweep and of the baselines beside it, by appearance, with the first's seed."""
    sweeps = [sweep]
    if sweep.baselines_dir.exists():
        sweeps.append(SweepFolder.open(sweep.baselines_dir))
    counts: dict[Text, int] = {}
    for run in (run for one in sweeps for run in one.runs()):
        for said in _messages(run):
            counts.setdefault(Text(said, _fires(run)), run.run.seed)
    return counts


def _fires(run: RunFolder) -> tuple[str, ...]:
    try:
        return tuple(fire.name for fire in msgspec.convert(run.config()["world"].get("fires", ()), list[_Fire]))
    except msgspec.ValidationError as error:
        raise RecordError(f"The fires in the world of run '{run.id}' cannot be read: {error}") from error


def _messages(run: RunFolder) -> list[str]:
    """Return what was said in a run, heard or not; the torn last line of one that has not ended is left out."""
    content = run.steps_bytes()
    lines = lines_of(content[: content.rfind(b"\n") + 1], _Said, run.stream_path("steps"))
    return [line.message for line in lines if line.message is not None]


def steady(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return a model's configuration with a temperature of 0, where it has a temperature."""
    options = config.get("options")
    if isinstance(options, Mapping) and "temperature" in options:
        return {**config, "options": {**options, "temperature": 0.0}}
    return {**config, "temperature": 0.0} if "temperature" in config else dict(config)


async def label(model: Model, question: str, texts: Sequence[Text], hand_labelled: Sequence[Text]) -> Labels:
    """Ask a model about texts, those to check it by included.

    Args:
        model: the model with its wrappers; what was asked before comes from the cache of answers.
        question: template with `$message` and `$fires`.
        texts: the distinct messages of a sweep.
        hand_labelled: texts whose labels are known.
    """
    if model.kinds is not None and KIND not in model.kinds:
        raise InputError(
            f"Model '{model.name}' cannot label messages: it answers {', '.join(model.kinds)} only. "
            "Name a language model with --model."
        )
    info = await model.inspect()
    keys = RequestKeys(model, info.digest)
    every = [*texts, *hand_labelled]
    replies = await model.ask_all([_request(one, question, keys) for one in every])
    labelled = tuple(
        Labelled(text=one.text, fires=one.fires, warning=read_answer(reply.text), reply=reply.text)
        for one, reply in zip(every, replies, strict=True)
    )
    for answered in (labelled[: len(texts)], labelled[len(texts) :]):
        _check_readable(model.name, answered)
    return Labels(
        labeller=model.name,
        digest=info.digest,
        question_sha256=hashlib.sha256(question.encode()).hexdigest(),
        parameters=model.parameters(),
        labels=labelled[: len(texts)],
        hand_labelled=labelled[len(texts) :],
    )


def _check_readable(model: str, labelled: Sequence[Labelled]) -> None:
    """Refuse answers none of which says yes or no: no number could come of them."""
    if labelled and all(one.warning is None for one in labelled):
        raise FoundryError(
            f"Model '{model}' said neither yes nor no to any of {counted(len(labelled), 'text')}; its first answer "
            f"begins {labelled[0].reply[:_EXCERPT]!r}. No label was written, and earlier labels stay. "
            "Name another model with --model."
        )


def _request(text: Text, question: str, keys: RequestKeys) -> Request:
    content = Template(question).substitute(message=text.text, fires=", ".join(text.fires) or "none")
    messages = (ChatMessage("user", content),)
    return Request(
        messages=messages,
        seed=SAMPLING_SEED,
        kind=KIND,
        observation={},
        step=0,
        agent=0,
        key=keys.key(messages, SAMPLING_SEED),
    )


def read_answer(reply: str) -> bool | None:
    """Return what a reply says: yes or no, without anything else beside signs; None for all other replies."""
    match = _ANSWER.fullmatch(without_thinking(reply))
    return match[1].lower() == "yes" if match else None
