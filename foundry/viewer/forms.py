"""Finds the view of a form by its name: the class that reads its records, and the script of its page.

The class and the script of foundry's own forms are in `foundry/viewer/<form>/`; the script is `static/page.js`. The
module of a user's form names its class as `VIEWER` and its script as `PAGE` (`foundry.own_code`, group `forms`). For
any other form, the view `any` shows the data that runs of all forms have.
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
"""The addresses of scripts from users' own forms begin with this name."""
T = TypeVar("T")


@dataclass(frozen=True)
class FormView:
    """Names the class that reads the records of a form for the page.

    Attributes:
        run: a subclass of `RunView`. A form without a page of its own needs a subclass of `AnyView`.
    """

    run: type[RunView]


@dataclass(frozen=True)
class Script:
    """The script that shows runs of a form: the form's name, the script's address on the page, and its file."""

    form: str
    address: str
    file: Path

    @property
    def told(self) -> dict[str, str]:
        """The form and the address of its script, as the page gets them."""
        return {"form": self.form, "script": self.address}


def view_of(form: str) -> FormView:
    """Return the view of a form, or raise InputError if the user's module with this name is invalid."""
    shipped = in_room(f"foundry.viewer.{form}", "VIEWER")
    room = Path(__file__).with_name(form) if shipped else None
    return _own(form, "VIEWER", FormView, room) or shipped or in_room(f"foundry.viewer.{GENERIC}", "VIEWER")


def scripts_of(form: str) -> list[Script]:
    """Return the scripts of a form in the order of loading; the generic script is loaded before a user's script."""
    own, shipped = outside_script(form), _script(form)
    return [script for script in ([shipped] if shipped else [_script(GENERIC), own]) if script is not None]


def outside_script(form: str) -> Script | None:
    """Return the user's script for a form, or None; raise InputError if the script is missing."""
    file = _own(form, "PAGE", Path, static_file(f"{form}/page.js"))
    if file is not None and not file.is_file():
        raise InputError(f"Runs of the form '{form}' cannot be shown: its PAGE '{file}' does not exist.")
    return None if file is None else Script(form, f"{OUTSIDE}/{form}/page.js", file)


def _script(form: str) -> Script | None:
    file = static_file(f"{form}/page.js")
    return None if file is None else Script(form, f"{form}/page.js", file)


def _own(form: str, what: str, kind: type[T], shipped: Path | None) -> T | None:
    """Return the value `what` from the user's module of a form; None if there is no such module or value.

    Raises:
        InputError: the value has another type than `kind`, or foundry has a form of this name.
    """
    for own in own_modules("forms"):
        if own.name != form:
            continue
        part: Any = getattr(own.load(), what, None)
        if part is None:
            return None
        if shipped is not None:
            refuse_shipped_name(f"{what} in {own.origin}", form, {form: shipped})
        if isinstance(part, kind):
            return part
        raise InputError(f"{own.origin}: {what} must be of type {kind.__name__}; got {part!r}.")
    return None


def prepare(sweep: SweepFolder) -> None:
    """Compute and store, for the first begun run of each condition, the data that take long to compute for a page."""
    prepared = set()
    for run in sweep.runs():
        if run.run.condition in prepared or not run.beginning:
            continue
        prepared.add(run.run.condition)
        view = view_of(run.declared.form).run
        if view.prepare is not RunView.prepare:
            view(run).prepare()
