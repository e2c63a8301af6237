"""What people read: names in a row, and the names of groups."""

from collections.abc import Iterable, Sequence


def joined(names: Iterable[str]) -> str:
    """Return names as a list in a sentence."""
    *first, last = list(names) or ["nothing"]
    return f"{', '.join(first)} and {last}" if first else last


def group_label(group: Sequence[str]) -> str:
    """Return the name of a group for people; a prompt that is called as its world stands once."""
    return " / ".join(dict.fromkeys(group))


def percent(share: float) -> str:
    """Return a share as a percentage; what is not nought never looks like it."""
    return "<0.1 %" if 0 < share < 0.001 else f"{100 * share:.3g} %"
