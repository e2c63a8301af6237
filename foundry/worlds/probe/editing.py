"""Finds edits: modules that change what an agent perceives in a moment, and say what that should leave of a decision.

An edit is a module with `NAME`, `LEAVES` (`invariance`: the decision should stay; `equivariance`: it should change as
`expected` says; `cause`: something is taken away that may have been its cause) and `edit(question)`, which returns
another question, or None where there is nothing to change. It acts on the structured observation, never on text.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

from foundry.errors import InputError, not_found
from foundry.own_code import own_modules
from foundry.worlds.base import Question, Scenario

NONE = "none"
"""The edit that changes nothing."""
LEAVES = ("invariance", "equivariance", "cause")
_ROOM = f"{__package__}.edits"
_ANY = "any"


def _same(action: Any) -> Any:
    return action


@dataclass(frozen=True)
class Edit:
    """A change of what an agent perceives.

    Attributes:
        name: what it is called.
        leaves: what a decision that is made for the right reasons does: one of `LEAVES`.
        change: returns the changed question, or None where there is nothing to change.
        expected: returns what an action should become.
        origin: where it comes from, for people.
    """

    name: str
    leaves: str
    change: Callable[[Question], Question | None]
    expected: Callable[[Any], Any] = _same
    origin: str = "foundry"

    def applied(self, question: Question) -> Question | None:
        """Return the changed question; None where the edit changes nothing in it.

        Raises:
            InputError: a module of the user's own fails on it.
        """
        try:
            changed = self.change(question)
            if changed is not None and not isinstance(changed, Question):
                raise TypeError(f"edit returned {changed!r}, which is no question")
            return None if changed == question else changed
        except Exception as error:  # the boundary: whatever a user's file raises, it is told by its name
            cause = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError(f"{self.origin} cannot edit what is asked ({question.kind}): {cause}") from error

    def described(self, scenario: Scenario) -> dict[str, Any]:
        """Return what is to be known of it without its code: name, what it leaves, what actions should become."""
        labels = dict.fromkeys(label for actions in scenario.actions().values() for label in actions.labels)
        expected = {label: self.expected(label) for label in labels} if self.leaves == "equivariance" else {}
        return {"name": self.name, "leaves": self.leaves, "expected": expected}


UNEDITED = Edit(NONE, "invariance", lambda question: question)


def find_edit(name: str, form: str) -> Edit:
    """Return an edit for worlds of a form: the form's own stands before that of any form.

    Raises:
        InputError: there is none of this name, or a module of the user's own is no edit.
    """
    if name == NONE:
        return UNEDITED
    found = {edit.name: edit for edit in edits_for(form)}
    if name not in found:
        raise not_found(f"Edit for worlds of form '{form}'", name, [NONE, *found], "Own ones are in mine/edits/.")
    return found[name]


def edits_for(form: str) -> Iterator[Edit]:
    """Yield the edits for worlds of a form, later ones before earlier ones of their name."""
    for room in (_ANY, form):
        folder = Path(__file__).parent / "edits" / room
        for found in pkgutil.iter_modules([str(folder)]):
            yield _edit(importlib.import_module(f"{_ROOM}.{room}.{found.name}"), "foundry")
    for own in own_modules("edits"):
        module = own.load()
        if getattr(module, "FORM", form) == form:
            yield _edit(module, own.origin)


def _edit(module: ModuleType, origin: str) -> Edit:
    try:
        edit = Edit(module.NAME, module.LEAVES, module.edit, getattr(module, "expected", _same), origin)
    except AttributeError as error:
        raise InputError(f"{origin} is no edit ({error}): it needs NAME, LEAVES, a function edit(question).") from error
    if edit.leaves not in LEAVES:
        raise InputError(f"{origin}: LEAVES is {edit.leaves!r}: give one of {', '.join(LEAVES)}.")
    if edit.leaves == "equivariance" and not hasattr(module, "expected"):
        raise InputError(f"{origin}: an edit of equivariance needs a function expected(action).")
    return edit


def observing(question: Question, **changes: Any) -> Question:
    """Return a question whose agent perceives other values under some keys that it has."""
    known: Mapping[str, Any] = question.observation
    return replace(question, observation={**known, **{key: value for key, value in changes.items() if key in known}})
