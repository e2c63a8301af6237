"""Shows the moments in which models differ most, each with picture, prompt and all replies."""

import base64
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from analysis.probes.choices import MomentKey
from analysis.probes.distance import ChoiceDistance
from analysis.tables.texts import number
from foundry.errors import FoundryError

SHOWN = 10
"""Maximum number of moments on the page."""
_PLAIN = 0
"""Index of a moment without an edit."""
_JPEG = b"\xff\xd8"


class MomentSource(Protocol):
    """A source of the moments of a probe; each moment is found by its number."""

    @property
    def models(self) -> Mapping[Any, str]:
        """The names of the models; answers refer to them by index."""

    @property
    def edits(self) -> Sequence[Any]:
        """The edits with their names; answers refer to them by index."""

    def place(self, run: str, step: int, agent: int, kind: str, again: int) -> int:
        """Return the number of the moment that has this run, step, agent, kind of question and repetition."""

    def seen(self, number: int, *, plain: bool = False) -> Any:
        """Return `perceived`, `prompts` and `answers` of a moment; if `plain`, without edits and formats."""

    def picture(self, number: int, edit: int, image: int) -> bytes:
        """Return the picture of a moment as PNG or JPEG."""


@dataclass(frozen=True)
class Reply:
    """A choice and text that several replies share, with the number of these replies."""

    choice: str
    text: str
    times: int


@dataclass(frozen=True)
class Column:
    """The answers of a model in a moment.

    Attributes:
        choices: for each choice its name, its frequency as text, and its frequency in per cent.
    """

    model: str
    choices: tuple[tuple[str, str, float], ...]
    replies: tuple[Reply, ...]


@dataclass(frozen=True)
class ShownMoment:
    """A moment on the page.

    Attributes:
        title: agent, step, kind of question and run.
        excess: this distance minus the distance by chance, as text.
        source: the picture as a data URL, or "".
    """

    title: str
    distance: str
    excess: str
    source: str
    why: str
    alt: str
    prompts: tuple[str, ...]
    columns: tuple[Column, ...]


def furthest(looked: MomentSource, distances: Mapping[MomentKey, ChoiceDistance]) -> list[ShownMoment]:
    """Return the moments in which the models differ most: by the distance between them minus the distance by chance."""
    return [_shown(looked, key, gap) for key, gap in list(distances.items())[:SHOWN]]


def _shown(looked: MomentSource, key: MomentKey, gap: ChoiceDistance) -> ShownMoment:
    place = looked.place(key.run, key.step, key.agent, key.kind, key.again)
    seen = looked.seen(place, plain=True)
    source, why = _picture(looked, place)
    has_images = bool(seen.perceived and seen.perceived[_PLAIN].images)
    prompts = dict.fromkeys(answer.prompt for answer in seen.answers if answer.prompt is not None)
    names = list(looked.models.values())
    return ShownMoment(
        title=f"Agent {key.agent} at step {key.step}: {key.kind} (seed {key.seed}, {key.run})",
        distance=number(gap.distance),
        excess=number(gap.excess),
        source=source,
        why=why,
        alt=f"The view of agent {key.agent}"
        if has_images
        else f"The world at step {key.step}, before agent {key.agent} decided",
        prompts=tuple(_text(seen.prompts[prompt]) for prompt in prompts),
        columns=tuple(
            _column(names[answer.model], answer.replies, answer.expected)
            for answer in sorted(seen.answers, key=_place_of_model)
        ),
    )


def _place_of_model(answer: Any) -> int:
    return int(answer.model)


def _picture(looked: MomentSource, place: int) -> tuple[str, str]:
    try:
        content = looked.picture(place, _PLAIN, 0)
    except FoundryError as error:
        return "", str(error)
    kind = "jpeg" if content.startswith(_JPEG) else "png"
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}", ""


def _column(model: str, replies: Sequence[Any], expected: Mapping[str, float]) -> Column:
    choices = Counter(reply.choice for reply in replies)
    counted = [(choice, f"{count} of {len(replies)}", 100 * count / len(replies)) for choice, count in _most(choices)]
    lines = [(choice, f"{share:.0%} expected", 100 * share) for choice, share in _most(expected)]
    texts = Counter((reply.choice, reply.text) for reply in replies)
    return Column(
        model,
        tuple(lines or counted),
        tuple(
            Reply(choice, "(the text of this reply was not recorded)" if text is None else text, count)
            for (choice, text), count in texts.most_common()
        ),
    )


def _most(choices: Mapping[str, float]) -> list[tuple[str, float]]:
    return sorted(choices.items(), key=lambda item: (-item[1], item[0]))


def _text(messages: Sequence[Mapping[str, Any]]) -> str:
    return "\n\n".join(f"[{message['role']}]\n{message['content']}" for message in messages)
