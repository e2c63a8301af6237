"""The measures on which claims may rest: those declared before the runs, or a default family."""

import difflib
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from analysis.arrays import BoolArray
from analysis.signatures import FAILURE_RATE, Signature, discover, is_readable_only
from foundry.errors import InputError, not_found

NO_BEHAVIOUR = frozenset({"cost"})
"""Signatures about the cost of a run, not about behaviour."""


def _claimed() -> list[Signature]:
    """Return the signatures on which claims may rest if nothing is declared."""
    return [one for one in discover() if one.primary and one.name not in NO_BEHAVIOUR]


def are_apart(measures: Sequence[str]) -> BoolArray:
    """Return which measures belong to signatures on which claims rest only if that is declared (M,).

    They are corrected among themselves, so that they do not change the results of other measures.
    """
    names = {one.name for one in discover() if not one.primary}
    return np.array([name.partition(".")[0] in names for name in measures], dtype=np.bool_)


def is_denominator(measure: str) -> bool:
    """Return whether the measure is a count that only serves as a denominator."""
    return measure.partition(".")[2].startswith("n_")


def primary_measures(measures: Sequence[str], present: Iterable[Collection[str]] = ()) -> tuple[str, ...]:
    """Return the default family: for each signature, the first headline measure that all worlds have.

    One measure per signature keeps the family small enough for ten seeds; exact tests of many measures need more.

    Args:
        measures: all measures, in their order.
        present: the measures of each run, since worlds have different measures; by default each run has all.
    """
    worlds = [names for names in dict.fromkeys(map(frozenset, present)) if not names <= {FAILURE_RATE}]
    primary: list[str] = []
    for signature in _claimed():
        columns = signature.headline_columns(measures)
        firsts = {next((name for name in columns if name in names), "") for names in worlds or [frozenset(measures)]}
        primary += [name for name in columns if name in firsts]
    return tuple(primary)


def declared_measures(
    family: Sequence[str] | None, measures: Sequence[str], present: Iterable[Collection[str]] = ()
) -> tuple[str, ...]:
    """Return the measures on which claims rest: the family, by default from `primary_measures`.

    Raises:
        InputError: a measure of the family does not exist.
    """
    return primary_measures(measures, present) if family is None else known_measures(family, measures)


def known_measures(names: Sequence[str], measures: Sequence[str]) -> tuple[str, ...]:
    """Return the names if all are known measures.

    Raises:
        InputError: a measure does not exist.
    """
    for name in names:
        if name not in measures:
            raise unknown_measure(name, measures)
    return tuple(names)


def headline_measures(measures: Sequence[str]) -> tuple[str, ...]:
    """Return the headline measures of the signatures, over all decisions, without denominators and cost."""
    shown = [one.headline_columns(measures) for one in _claimed()]
    return tuple(dict.fromkeys(name for columns in shown for name in columns if not is_denominator(name)))


def unknown_measure(asked: str, measures: Sequence[str]) -> InputError:
    """Return the error for an unknown measure, with the measures of its signature, or the headlines.

    It does not list all measures, since there are hundreds.
    """
    signatures = dict.fromkeys(name.partition(".")[0] for name in measures)
    meant = difflib.get_close_matches(asked.partition(".")[0], list(signatures), n=1)
    own = [name for name in measures if name.partition(".")[0] in meant and not is_readable_only(name)]
    return not_found("Measure", asked, own or headline_measures(measures), "All are columns of signatures.csv.")
