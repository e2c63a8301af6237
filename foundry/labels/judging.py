"""Lets a model label the texts of a sweep; the model gets equal texts only once."""

from collections.abc import Mapping, Sequence
from typing import Any

from foundry.errors import FoundryError, InputError
from foundry.labels.definition import Context, Label
from foundry.labels.folder import Judge, Judgement
from foundry.models.base import ChatMessage, Model, Request, RequestKeys
from foundry.texts import counted
from foundry.worlds.replies import without_thinking

KIND = "label"
"""The kind of question that a model gets when it labels."""
SAMPLING_SEED = 0
"""Seed of every call, so that equal questions get equal answers."""
_EXCERPT = 60
"""Number of characters of an unreadable answer that an error shows."""
_SIGNS = " \t\r\n\"'*_`#([{.!)]}"

Texts = Sequence[tuple[str, Context]]
"""Texts to label, each with its context."""


def steady(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return a model's configuration with its temperature, if it has one, set to 0."""
    options = config.get("options")
    if isinstance(options, Mapping) and "temperature" in options:
        return {**config, "options": {**options, "temperature": 0.0}}
    return {**config, "temperature": 0.0} if "temperature" in config else dict(config)


async def judge(model: Model, label: Label, texts: Texts, by_hand: Texts = ()) -> Judge:
    """Ask a model the question of a label about texts, and return its answers.

    Args:
        model: model with its wrappers; the cache answers earlier questions.
        label: the label.
        texts: the distinct texts of a sweep.
        by_hand: texts with known labels, which show how often the model is right.

    Raises:
        InputError: the model cannot answer questions about labels.
        FoundryError: no answer is one of the choices.
    """
    if model.kinds is not None and KIND not in model.kinds:
        raise InputError(
            f"Model '{model.name}' cannot label texts, because it answers only questions of the kinds "
            f"{', '.join(model.kinds)}. Name a language model with --model."
        )
    info = await model.inspect()
    keys = RequestKeys(model, info.digest)
    every = [*texts, *by_hand]
    replies = await model.ask_all([_request(label.judged(*text), keys) for text in every])
    judged = tuple(
        Judgement(
            text=text, context=dict(context), label=read_answer(reply.text, label.options(context)), reply=reply.text
        )
        for (text, context), reply in zip(every, replies, strict=True)
    )
    for answered in (judged[: len(texts)], judged[len(texts) :]):
        _check_readable(model.name, label, answered)
    return Judge(
        labeller=model.name,
        digest=info.digest,
        question_sha256=label.question_sha256,
        parameters=model.parameters(),
        judgements=judged[: len(texts)],
        by_hand=judged[len(texts) :],
    )


def _check_readable(model: str, label: Label, judged: Sequence[Judgement]) -> None:
    """Raise an error if none of the answers is a choice, because no measure could be computed."""
    if judged and all(judgement.label is None for judgement in judged):
        choices = " nor ".join(label.options(judged[0].context))
        raise FoundryError(
            f"Model '{model}' answered neither {choices} to any of {counted(len(judged), 'text')}; its first answer "
            f"begins {judged[0].reply[:_EXCERPT]!r}. No label was written, and earlier labels stay. Name another "
            "model with --model."
        )


def _request(prompt: str, keys: RequestKeys) -> Request:
    messages = (ChatMessage("user", prompt),)
    key = keys.key(messages, SAMPLING_SEED)
    return Request(messages=messages, seed=SAMPLING_SEED, kind=KIND, observation={}, step=0, agent=0, key=key)


def read_answer(reply: str, options: Sequence[str]) -> str | None:
    """Return the choice if a reply contains only a choice and punctuation around it; None for any other reply."""
    said = without_thinking(reply).strip(_SIGNS).casefold()
    return next((option for option in options if option.strip(_SIGNS).casefold() == said), None)
