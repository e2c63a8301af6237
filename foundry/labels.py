"""What a model said of the messages of a sweep (`analysis/labels.json`), and people (`analysis/people.json`)."""

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


WARNINGS, REPLIES = "warnings", "replies"
"""What people are asked about."""
NONE = "none"
"""The label of a reply that decides nothing."""


class Judged(msgspec.Struct, frozen=True, kw_only=True):
    """What a person said of one text.

    Attributes:
        text: a message, or a model's reply.
        seed: the seed of the run in which it appeared first.
        label: `yes` or `no` of a message that may be a warning; of a reply what it decides, or NONE.
        fires: of a message the names of the fires in its world, as the person was told.
        kind: of a reply the kind of its question.
        recorded: of a reply what its run says it decided, or NONE where nothing could be read.
    """

    text: str
    seed: int
    label: str
    fires: tuple[str, ...] = ()
    kind: str = ""
    recorded: str = ""


class JudgedBy(msgspec.Struct, frozen=True, kw_only=True):
    """What one person said of the texts of a sweep.

    Attributes:
        labeller: the name of the person as a model.
        what: WARNINGS or REPLIES.
        question_sha256: hash of the template of the question.
        asked: how many texts were to be labelled; more than `labels` where the person has not come to the end.
        labels: what was said so far.
    """

    labeller: str
    what: str
    question_sha256: str
    asked: int
    labels: tuple[Judged, ...]


class People(msgspec.Struct, frozen=True, kw_only=True):
    """What people said of the texts of a sweep (`analysis/people.json`).

    Attributes:
        people: one entry for each person and each thing that was asked.
    """

    people: tuple[JudgedBy, ...] = ()

    def joined(self, new: JudgedBy) -> People:
        """Return them with an entry in the place of the one for the same."""
        others = tuple(one for one in self.people if (one.labeller, one.what) != (new.labeller, new.what))
        return People(people=(*others, new))
