"""Finds the view of a form by its name: the reader of its records, and its part of the page.

Both come from `foundry/viewer/<form>/` and its `static/page.js`, or from a user's module with `VIEWER` and `PAGE`
(`foundry.own_code`, group `forms`). Otherwise `any` shows the parts that all forms share.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from foundry.errors import InputError
from foundry.naming import in_room
from foundry.own_code import own_modules, refuse_shipped_name
from foundry.storing.store import SweepFolder
from foundry.viewer.files import static_file
from foundry.viewer.run_view import RunView

GENERIC = "any"
OUTSIDE = "forms"
"""The folder in the page's addresses for users' scripts."""
T = TypeVar("T")


@dataclass(frozen=True)
class FormView:
    """The reader of a form's records for the page.

    Attributes:
        run: view of a run; the generic page can show subclasses of `foundry.viewer.any.any_view.AnyView`.
    """

    run: type[RunView]


@dataclass(frozen=True)
class Script:
    """A form's part of the page.

    Attributes:
        form: name of the form.
        address: address of the script on the page.
        file: the script.
    """

    form: str
    address: str
    file: Path

    @property
    def told(self) -> dict[str, str]:
        """Its description for the page."""
        return {"form": self.form, "script": self.address}


def view_of(form: str) -> FormView:
    """Return the reader of a form's records.

    Raises:
        InputError: the user's module with this name is invalid.
    """
    shipped = _shipped(form)
    room = Path(__file__).with_name(form) if shipped else None
    return _own(form, "VIEWER", FormView, room) or shipped or _generic()


def scripts_of(form: str) -> list[Script]:
    """Return the scripts of a form in the order of loading; a user's script follows the generic script.

    Raises:
        InputError: the user's module with this name is invalid.
    """
    own = outside_script(form)
    shipped = _script(form)
    if shipped is not None:
        return [shipped]
    return [one for one in (_script(GENERIC), own) if one is not None]


def outside_script(form: str) -> Script | None:
    """Return the user's script for a form, or None.

    Raises:
        InputError: the user's module with this name is invalid, or its script is missing.
    """
    file = _own(form, "PAGE", Path, static_file(f"{form}/page.js"))
    if file is not None and not file.is_file():
        raise InputError(f"The page of form '{form}' cannot be shown: its PAGE '{file}' does not exist.")
    return None if file is None else Script(form, f"{OUTSIDE}/{form}/page.js", file)


def _script(form: str) -> Script | None:
    file = static_file(f"{form}/page.js")
    return None if file is None else Script(form, f"{form}/page.js", file)


def _generic() -> FormView:
    found = _shipped(GENERIC)
    assert found is not None, "the view of any form is shipped"
    return found


def _shipped(form: str) -> FormView | None:
    found = in_room(f"foundry.viewer.{form}", "VIEWER")
    return found if isinstance(found, FormView) else None


def _own(form: str, what: str, kind: type[T], shipped: Path | None) -> T | None:
    """Return a value in the user's module of a form, or None.

    Raises:
        InputError: the value has the wrong type, or the form has a shipped part for it.
    """
    for own in own_modules("forms"):
        if own.name != form:
            continue
        found: Any = getattr(own.load(), what, None)
        if found is None:
            return None
        if shipped is not None:
            refuse_shipped_name(f"{what} in {own.origin}", form, {form: shipped})
        if isinstance(found, kind):
            return found
        raise InputError(f"{own.origin}: {what} must be of type {kind.__name__}; got {found!r}.")
    return None


def prepare(sweep: SweepFolder) -> None:
    """Prepare slow parts of the page, for the first started run of each condition."""
    prepared = set()
    for run in sweep.runs():
        if run.run.condition in prepared or not run.beginning:
            continue
        prepared.add(run.run.condition)
        view = view_of(run.declared.form).run
        if view.prepare is not RunView.prepare:
            view(run).prepare()
