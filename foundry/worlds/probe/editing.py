"""Finds edits. An edit changes what an agent perceives in a moment, and says how its decision should change.

A user's own edit is a Python file with its name (`NAME`), its kind (`LEAVES`) and a function `edit(question)`. The kind
states how the decision should change. After an edit of invariance, the model should decide as before. After an edit of
equivariance, the model should choose the matching action (`expected(action)`): after a mirror image, right instead of
left. An edit of a cause removes a possible cause of the decision.

An edit returns a changed question, or None if there is nothing to change. An edit changes the structured observation
and the images, never the prompt's text. Shipped edits of a form are in `foundry/worlds/<form>/<form>_edits.py`
(`EDITS`); the edits in the folder `any` fit every form.

An edit may have parts, such as the attributes of a persona. The file of such an edit also has a function
`parts(scenario)`, which returns the names of the parts; its function `edit` has a parameter `part`. For example, the
edit `swap_persona.age` changes only the age; `swap_persona.each` stands for one edit per attribute. The function `edit`
may also have a parameter `others`, for the questions of all other moments of this seed and of the next seed. The
function for expected actions (`expected`) may have a parameter for the configured world (`scenario`).
"""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from foundry.errors import InputError, not_found
from foundry.naming import in_room
from foundry.own_code import own_modules, refuse_shipped_name
from foundry.seeding import stream
from foundry.texts import one_line
from foundry.worlds.base import Question, Scenario
from foundry.worlds.probe.quantities import moved, split

NONE = "none"
"""Name of the edit that changes nothing."""
SHIPPED = "foundry"
"""Origin of the edits that foundry ships."""
LEAVES = ("invariance", "equivariance", "cause")
EACH = "each"
"""Part name that stands for every part: `swap_persona.each` is one edit per attribute of a persona."""


@dataclass(frozen=True)
class Edit:
    """A change of what an agent perceives.

    Attributes:
        leaves: how a decision for the right reasons would change, one of `LEAVES`.
        change: function that returns the changed question, or None; it gets `others` if it has such a parameter.
        expected: function that converts the action without the edit to the action that should follow the edit.
        parts: function that returns the names of its parts in a world; `change` then takes one as `part`.
        origin: the source of the edit, for messages.
        moves: the quantity that the edit sets, and the value; with `moves`, moments that the edit does not change are
            asked too.
    """

    name: str
    leaves: str
    change: Callable[..., Question | None]
    expected: Callable[..., Any] = lambda action: action
    parts: Callable[[Scenario], Sequence[str]] = lambda scenario: ()
    origin: str = SHIPPED
    moves: tuple[str, float] | None = None

    @property
    def looks_around(self) -> bool:
        """True if the edit uses questions of other moments."""
        return "others" in inspect.signature(self.change).parameters

    def applied(self, question: Question, others: Sequence[Question] = ()) -> Question | None:
        """Return the question as changed by the edit, or None if the edit changes nothing.

        Args:
            question: the recorded question.
            others: the recorded questions of the other moments of this seed and of the next seed.
        """
        try:
            changed = _given(self.change, question, others=others)
            if changed is not None and not isinstance(changed, Question):
                raise TypeError(f"edit returned {changed!r} instead of a question")
            return None if changed == question and self.moves is None else changed
        except Exception as error:  # the boundary: report any error of a user's file under its name
            cause = one_line(f"{type(error).__name__}: {error}")
            raise InputError(f"{self.origin} cannot edit a '{question.kind}' question: {cause}") from error

    def described(self, scenario: Scenario) -> dict[str, Any]:
        """Return the edit's name, its kind and its expected actions, as `sweep.yaml` records them."""
        labels = dict.fromkeys(label for actions in scenario.actions().values() for label in actions.labels)
        is_moved = self.leaves == "equivariance"
        expected = {label: _given(self.expected, label, scenario=scenario) for label in labels} if is_moved else {}
        moves = {} if self.moves is None else {"moves": self.moves[0], "to": self.moves[1]}
        return {"name": self.name, "leaves": self.leaves, "expected": expected, **moves}


def _given(function: Callable[..., Any], subject: Any, **known: Any) -> Any:
    """Call a function with `subject`, and with each `known` argument for which the function has a parameter."""
    parameters = inspect.signature(function).parameters
    return function(subject, **{name: value for name, value in known.items() if name in parameters})


UNEDITED = Edit(NONE, "invariance", lambda question: question)


def find_edits(name: str, scenario: Scenario) -> list[Edit]:
    """Return the edits that a name means: `swap_persona` is one edit, `swap_persona.each` one per attribute."""
    check_own_edits(scenario.form)
    whole, _, part = name.partition(".")
    if part != EACH:
        return [find_edit(name, scenario)]
    parts = parts_of(whole, scenario)
    if not parts:
        raise InputError(f"Edit '{whole}' has no parts in world '{scenario.name}'. Use edit={whole} without .{EACH}.")
    return [find_edit(f"{whole}.{part}", scenario) for part in parts]


def find_edit(name: str, scenario: Scenario) -> Edit:
    """Return the edit with this name; if two edits share a name, the one of the world's form wins."""
    if name == NONE:
        return UNEDITED
    if "=" in name:
        path, value = split(name)
        change = partial(moved, path=path, value=value, form=scenario.form)
        return Edit(name, "cause", change, moves=(path, value))
    whole, _, part = name.partition(".")
    edit = _known(whole, scenario)
    if not part:
        return edit
    parts = edit.parts(scenario)
    if part not in parts:
        raise not_found(f"Part of edit '{whole}'", part, [EACH, *parts] if parts else [])
    return replace(edit, name=name, change=partial(edit.change, part=part))


def parts_of(name: str, scenario: Scenario) -> Sequence[str]:
    """Return the names of an edit's parts in a world; empty if it has none."""
    return () if name == NONE else tuple(_known(name, scenario).parts(scenario))


def _known(name: str, scenario: Scenario) -> Edit:
    edits = {edit.name: edit for edit in edits_of(scenario.form)}
    if name not in edits:
        raise not_found(
            f"Edit for worlds of form '{scenario.form}'", name, [NONE, *edits], "Own ones are in mine/edits/."
        )
    return edits[name]


def check_own_edits(form: str) -> None:
    """Raise InputError if a user's edit has the name of a shipped edit."""
    shipped = shipped_edits("any", form)
    for edit in edits_of(form):
        if edit.origin != SHIPPED:
            refuse_shipped_name(edit.origin, edit.name, shipped)


def shipped_edits(*forms: str) -> dict[str, Path]:
    """Return the file of each shipped edit, by the edit's name; only for the given forms, if any."""
    forms = forms or tuple(file.parent.name for file in Path(__file__).parents[1].glob("*/*_edits.py"))
    edits = [edit for form in forms for edit in _edits_in(form)]
    return {edit.name: Path(inspect.getfile(edit.change)) for edit in edits}


def edits_of(form: str) -> Iterator[Edit]:
    """Yield the edits for worlds of a form: edits that fit every form, edits of this form, and the user's own."""
    for room in ("any", form):
        yield from _edits_in(room)
    for own in own_modules("edits"):
        module = own.load()
        if getattr(module, "FORM", form) == form:
            yield _own_edit(module, own.origin)


def _edits_in(form: str) -> Sequence[Edit]:
    return in_room(f"foundry.worlds.{form}.{form}_edits", "EDITS") or ()


def _own_edit(module: ModuleType, origin: str) -> Edit:
    try:
        optional = {name: getattr(module, name) for name in ("expected", "parts") if hasattr(module, name)}
        edit = Edit(module.NAME, module.LEAVES, module.edit, origin=origin, **optional)
    except AttributeError as error:
        raise InputError(
            f"{origin} cannot be used as an edit ({error}). It needs NAME, LEAVES and a function edit(question)."
        ) from error
    if edit.leaves not in LEAVES:
        raise InputError(f"{origin} has LEAVES = {edit.leaves!r}. Choose from {', '.join(LEAVES)}.")
    if edit.leaves == "equivariance" and "expected" not in optional:
        raise InputError(f"{origin}: an edit of equivariance needs a function expected(action).")
    return edit


def observing(question: Question, **changes: Any) -> Question:
    """Return the question with these values in its observation; keys that the observation lacks are ignored."""
    known: Mapping[str, Any] = question.observation
    return replace(question, observation={**known, **{key: value for key, value in changes.items() if key in known}})


def drawn(question: Question, name: str, among: Sequence[Any]) -> Any:
    """Return a random value, always the same for the same moment; None if there are no values."""
    return among[int(stream(question.sampling_seed(0), name).integers(len(among)))] if among else None
