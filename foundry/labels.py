"""What a model said of the messages of a sweep (`analysis/labels.json`)."""

from __future__ import annotations

from typing import Any

import msgspec


class Labelled(msgspec.Struct, frozen=True, kw_only=True):
    """What a model said of one text.

    Attributes:
        text: the text.
        fires: names of the fires in the world that it is from, as the model was told.
        warning: whether it is a warning; null when the reply was neither yes nor no.
        reply: the raw reply.
    """

    text: str
    fires: tuple[str, ...]
    warning: bool | None
    reply: str


class Labels(msgspec.Struct, frozen=True, kw_only=True):
    """Which messages of a sweep are warnings, by a model (`analysis/labels.json`).

    Attributes:
        labeller: name of the model.
        digest: its digest on its server, or null.
        question_sha256: hash of the template of the question.
        parameters: everything beside the question that decided the answers.
        labels: one for each distinct text and names of fires.
        hand_labelled: the same for the texts that were labelled by hand, for the agreement.
    """

    labeller: str
    digest: str | None
    question_sha256: str
    parameters: dict[str, Any]
    labels: tuple[Labelled, ...]
    hand_labelled: tuple[Labelled, ...]
