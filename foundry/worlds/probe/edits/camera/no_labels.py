"""Things are not called by their names: not what is to be found, nor those that can be chosen.

Names are replaced where the task, a told way or a choice gives them; all others that words hold stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_labels"
LEAVES = "cause"
_ARROW = " → "
"""What stands between the things of one choice."""


def edit(question: Question) -> Question:
    """Return the question with numbered things in place of named ones."""
    seen = question.observation
    choices = seen.get("choices", ())
    target = [seen["target"]] if seen.get("target") else []
    told = [name for choice in choices for name in choice["text"].split(_ARROW)]
    names = {name: f"thing {number}" for number, name in enumerate(sorted({*target, *told}), 1)}

    def renamed(choice: Mapping[str, Any]) -> dict[str, Any]:
        return {**choice, "text": _ARROW.join(names[name] for name in choice["text"].split(_ARROW))}

    return observing(
        question,
        target="".join(names[name] for name in target),
        task=_replaced(seen.get("task", ""), names, target),
        instruction={key: _replaced(text, names, target) for key, text in seen.get("instruction", {}).items()},
        choices=[renamed(choice) for choice in choices],
    )


def _replaced(text: str, names: Mapping[str, str], told: Iterable[str]) -> str:
    for name in told:
        text = text.replace(name, names[name])
    return text
