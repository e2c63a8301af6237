"""Texts for people: lists of names, and the names of groups."""

from collections.abc import Iterable, Sequence


def joined(names: Iterable[str]) -> str:
    """Return names as a list in a sentence."""
    *first, last = list(names) or ["nothing"]
    return f"{', '.join(first)} and {last}" if first else last


def group_label(group: Sequence[str]) -> str:
    """Return the name of a group for people; a prompt with the name of its world is left out."""
    return " / ".join(dict.fromkeys(group))


def percent(share: float) -> str:
    """Return a share as a percentage; a nonzero share is never shown as zero."""
    return "<0.1 %" if 0 < share < 0.001 else f"{100 * share:.3g} %"
