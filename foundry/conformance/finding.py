"""What a check found, and how checks are run: each is a function of a case whose first line says what must hold."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias, TypeVar

from foundry.errors import FoundryError

Case = TypeVar("Case")
Check: TypeAlias = Callable[[Case], str | None]
"""Returns what is to be known all the same, or nothing; raises Broken or Skipped."""


class Status(StrEnum):
    """What became of a check."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Attributes:
        part: what was checked, such as `world bar`.
        check: the check's name.
        rule: what must hold.
        status: whether it does.
        note: what to do about it, why it was skipped, or what is to be known all the same.
    """

    part: str
    check: str
    rule: str
    status: Status
    note: str = ""


class Broken(Exception):
    """A rule does not hold; the message says where, and what to do."""


class Skipped(Exception):
    """A rule does not apply; the message says why."""


def require(condition: bool, message: str) -> None:
    """Say that a rule is broken unless the condition holds.

    Raises:
        Broken: it does not.
    """
    if not condition:
        raise Broken(message)


def examine(part: str, checks: Sequence[Check[Case]], case: Case) -> list[Finding]:
    """Return what the checks find, in their order; a cause that several run into is told once."""
    found: list[Finding] = []
    told: set[str] = set()
    for check in checks:
        finding = look(part, check, case)
        if finding.status is Status.FAILED and finding.note in told:
            finding = Finding(part, finding.check, finding.rule, Status.SKIPPED, "for what failed above")
        told.add(finding.note)
        found.append(finding)
    return found


def look(part: str, check: Check[Case], case: Case) -> Finding:
    """Return what one check finds."""
    name, rule = name_of(check), str(inspect.getdoc(check)).partition("\n")[0]
    try:
        note = check(case)
    except Skipped as reason:
        return Finding(part, name, rule, Status.SKIPPED, str(reason))
    except Broken as reason:
        return Finding(part, name, rule, Status.FAILED, str(reason))
    except Exception as error:  # noqa: BLE001 - the boundary: whatever a user's part raises is what was found
        return Finding(part, name, rule, Status.FAILED, _cause(error))
    return Finding(part, name, rule, Status.PASSED, note or "")


def name_of(check: Check[Case]) -> str:
    """Return the name of a check."""
    return check.__name__.replace("_", " ")


def failed(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings that something must be done about."""
    return [one for one in findings if one.status is Status.FAILED]


def _cause(error: Exception) -> str:
    """Return an error in one line, with the last place outside this package where it came from."""
    text = " ".join(str(error).split())
    if isinstance(error, FoundryError):
        return text
    frames = inspect.getinnerframes(error.__traceback__) if error.__traceback__ else []
    own = [one for one in frames if "/foundry/conformance/" not in one.filename.replace("\\", "/")]
    where = f" ({own[-1].filename}, line {own[-1].lineno})" if own else ""
    return f"{type(error).__name__}: {text}{where}"
