"""What shows runs of a form, found by the form's name: the part that reads their records, and the part of the page.

Both come from `foundry/viewer/<form>/` and its `static/page.js`, else from a module of the user's own, which may name
`VIEWER` and `PAGE` (`foundry.own_code`, group `forms`), else they are those of `any`, which shows what all forms share.
"""

from __future__ import annotations

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
"""The place of the scripts of the user's forms on the page."""
T = TypeVar("T")


@dataclass(frozen=True)
class FormView:
    """What reads the records of a form for the page.

    Attributes:
        run: one run; one that extends `foundry.viewer.any.any_view.AnyView` can be shown by the generic page.
    """

    run: type[RunView]


@dataclass(frozen=True)
class Script:
    """What shows runs of a form on the page.

    Attributes:
        form: the form that it shows.
        address: where the page finds it.
        file: the script.
    """

    form: str
    address: str
    file: Path

    @property
    def told(self) -> dict[str, str]:
        """What the page is told of it."""
        return {"form": self.form, "script": self.address}


def view_of(form: str) -> FormView:
    """Return what reads the records of a form.

    Raises:
        InputError: the user's own module of this name is not fit for it.
    """
    shipped = _shipped(form)
    room = Path(__file__).with_name(form) if shipped else None
    return _own(form, "VIEWER", FormView, room) or shipped or _generic()


def scripts_of(form: str) -> list[Script]:
    """Return what shows runs of a form, in the order of loading: one of the user's own comes on top of the generic.

    Raises:
        InputError: the user's own module of this name is not fit for it.
    """
    own = outside_script(form)
    shipped = _script(form)
    if shipped is not None:
        return [shipped]
    return [one for one in (_script(GENERIC), own) if one is not None]


def outside_script(form: str) -> Script | None:
    """Return the script of the user's own for a form, or None where there is none.

    Raises:
        InputError: the user's own module of this name is not fit for it, or its script is not there.
    """
    file = _own(form, "PAGE", Path, static_file(f"{form}/page.js"))
    if file is not None and not file.is_file():
        raise InputError(f"The page of form '{form}' cannot be shown: its PAGE, '{file}', is not there.")
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
    """Return a name of the user's module of a form, or None.

    Raises:
        InputError: it says something else, or there is a shipped part for that.
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
        raise InputError(f"{own.origin}: {what} is no {kind.__name__} but {found!r}.")
    return None


def prepare(sweep: SweepFolder) -> None:
    """Make what takes long when a page is first opened, for the first run of each condition that has begun."""
    prepared = set()
    for run in sweep.runs():
        if run.run.condition in prepared or not run.beginning:
            continue
        prepared.add(run.run.condition)
        view = view_of(run.declared.form).run
        if view.prepare is not RunView.prepare:
            view(run).prepare()
