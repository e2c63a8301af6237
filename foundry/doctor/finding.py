"""What one check found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """How a check went."""

    OK = "ok"
    WARNING = "warning"  # the sweep would run, and its numbers may not be what they seem
    PROBLEM = "problem"  # the sweep would not run, or not to its end
    SKIPPED = "skipped"  # could not be looked at


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Attributes:
        check: what was looked at.
        subject: of which model, world or machine.
        status: how it went.
        found: what was measured or read.
        advice: what to do about it; "" for nothing.
    """

    check: str
    subject: str
    status: Status
    found: str
    advice: str = ""
