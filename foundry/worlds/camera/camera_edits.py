"""Edits that a probe makes in the images and observations of 3D worlds."""

from collections.abc import Iterable, Mapping
from typing import Any

from PIL import ImageOps

from foundry.worlds.any.any_edits import seeing
from foundry.worlds.base import Question
from foundry.worlds.probe.editing import Edit, observing

_SIDES = {"left": "right", "right": "left", "turn left": "turn right", "turn right": "turn left"}
_ARROW = " → "
"""Text between the names in a choice of several things: "door → chair → lamp"."""
_POSE = ("x", "y", "z", "yaw", "pitch")


def mirror_image(question: Question) -> Question | None:
    """Mirror every image; the words and the agent's pose do not change."""
    return seeing(question, ImageOps.mirror)


def no_history(question: Question) -> Question:
    """Remove the agent's earlier decisions, and their results, from the observation."""
    return observing(question, history=(), idle_streak=0)


def no_labels(question: Question) -> Question:
    """Replace the names of things by numbers: the target, and the things in choices.

    Names are replaced in the task, the route and the choices; all other words do not change.
    """
    seen = question.observation
    choices = seen.get("choices", ())
    target = [seen["target"]] if seen.get("target") else []
    names_told = [name for choice in choices for name in choice["text"].split(_ARROW)]
    names = {name: f"thing {number}" for number, name in enumerate(sorted({*target, *names_told}), 1)}

    def renamed(choice: Mapping[str, Any]) -> dict[str, Any]:
        return {**choice, "text": _ARROW.join(names[name] for name in choice["text"].split(_ARROW))}

    return observing(
        question,
        target="".join(names[name] for name in target),
        task=_replaced(seen.get("task", ""), names, target),
        instruction={key: _replaced(text, names, target) for key, text in seen.get("instruction", {}).items()},
        choices=[renamed(choice) for choice in choices],
    )


def _replaced(text: str, names: Mapping[str, str], names_told: Iterable[str]) -> str:
    for name in names_told:
        text = text.replace(name, names[name])
    return text


def no_pose(question: Question) -> Question:
    """Replace the agent's present and past poses by null; the image does not change."""
    history = tuple({**entry, "pose": None} for entry in question.observation.get("history", ()))
    return observing(question, **dict.fromkeys(_POSE), history=history)


EDITS = (
    Edit("mirror_image", "equivariance", mirror_image, lambda action: _SIDES.get(action, action)),
    Edit("no_history", "cause", no_history),
    Edit("no_labels", "cause", no_labels),
    Edit("no_pose", "cause", no_pose),
)
