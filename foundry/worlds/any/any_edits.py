"""Edits of images, and of keys of the observation that worlds of several forms have."""

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from PIL import Image

from foundry.worlds.base import Question, Scenario
from foundry.worlds.probe.editing import Edit, drawn, observing

JPEG_QUALITY = 95
"""Quality of an edited JPEG; a high value, because encoding an image again loses detail."""
_GREY = (128, 128, 128)
_LISTS = ("names", "choices")
"""Keys of an observation that hold a list of options."""


def blank_image(question: Question) -> Question | None:
    """Replace each image by a grey image of the same size; return None without images."""
    return seeing(question, lambda image: Image.new("RGB", image.size, _GREY))


def seeing(question: Question, change: Callable[[Image.Image], Image.Image]) -> Question | None:
    """Change each image and keep its file format; return None without images."""
    if not question.images:
        return None
    return replace(question, images=tuple(_changed(image, change) for image in question.images))


def _changed(encoded: bytes, change: Callable[[Image.Image], Image.Image]) -> bytes:
    buffer = io.BytesIO()
    with Image.open(io.BytesIO(encoded)) as image:
        change(image).save(buffer, image.format, **({"quality": JPEG_QUALITY} if image.format == "JPEG" else {}))
    return buffer.getvalue()


def no_messages(question: Question) -> Question:
    """Remove the messages of others; the text that the agent keeps as its memory stays."""
    return observing(question, received=[])


def no_persona(question: Question) -> Question:
    """Remove the agent's persona and the personas of its neighbours."""
    near, seen = (
        [{**other, "persona": {}} for other in question.observation.get(key, ())] for key in ("neighbours", "seen")
    )
    return observing(question, persona={}, neighbours=near, seen=seen)


def other_image(question: Question, others: Sequence[Question]) -> Question | None:
    """Show the images of another moment of the same kind; return None if no other moment has different images."""
    seen = [other.images for other in others if other.kind == question.kind]
    differing = [images for images in seen if images != question.images and len(images) == len(question.images)]
    images = drawn(question, "other_image", differing)
    return None if images is None else replace(question, images=images)


def places(scenario: Scenario) -> tuple[str, ...]:
    """Return the parts "2", "3" and so on of this edit: the positions of options that it can move to the front."""
    most = max((len(actions.labels) for actions in scenario.actions().values()), default=0)
    return tuple(str(place) for place in range(2, most + 1))


def permute_options(question: Question, part: str | None = None) -> Question:
    """List the options in a different order; no option is renamed.

    The list is rotated: the options before a drawn option move to the end. A part gives the position of this option:
    `permute_options.2` lists the second option first. If a list has no option at this position, nothing changes.
    """
    turned = {}
    for key in (key for key in _LISTS if key in question.observation):
        options = question.observation[key]
        first = drawn(question, "permute_options", range(1, len(options))) if part is None else int(part) - 1
        turned[key] = [*options[first or 0 :], *options[: first or 0]]
    return observing(question, **turned)


def attributes(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of the attributes of a world's personas, in their order."""
    return tuple(dict.fromkeys(name for persona in scenario.personas(0) for name in persona))


def swap_persona(question: Question, others: Sequence[Question], part: str | None = None) -> Question | None:
    """Copy the persona, or one attribute of it (`part`), from another moment; None if no moment has a different one."""
    own = question.observation.get("persona")
    if not own:
        return None
    gained = [with_part(own, other.observation.get("persona") or own, part) for other in others]
    persona = drawn(question, "swap_persona", [other for other in gained if other != own])
    return None if persona is None else observing(question, persona=persona)


def with_part(own: Mapping[str, str], other: Mapping[str, str], part: str | None) -> dict[str, str]:
    """Return a persona with one attribute (`part`) of another persona; without a part, return the other persona."""
    if part is None:
        return dict(other)
    return {name: other.get(name, value) if name == part else value for name, value in own.items()}


EDITS = (
    Edit("blank_image", "cause", blank_image),
    Edit("no_messages", "cause", no_messages),
    Edit("no_persona", "cause", no_persona),
    Edit("other_image", "cause", other_image),
    Edit("permute_options", "invariance", permute_options, parts=places),
    Edit("swap_persona", "cause", swap_persona, parts=attributes),
)
