"""Chooses the measures that are tested: those declared before the runs, or a default family."""

import difflib
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from analysis.arrays import BoolArray
from analysis.signatures import FAILURE_RATE, Signature, discover, is_readable_only
from foundry.errors import InputError, not_found

NO_BEHAVIOUR = frozenset({"cost"})
"""Signatures about the cost of a run, not about behaviour."""


def _claimed() -> list[Signature]:
    return [signature for signature in discover() if signature.primary and signature.name not in NO_BEHAVIOUR]


def are_apart(measures: Sequence[str]) -> BoolArray:
    """Return which measures belong to signatures that are tested only if they are declared (M,).

    These measures form a family of their own, so that they do not change the corrected p of other measures.
    """
    names = {signature.name for signature in discover() if not signature.primary}
    return np.array([name.partition(".")[0] in names for name in measures], dtype=np.bool_)


def is_denominator(measure: str) -> bool:
    """Return whether a measure is only a denominator of other measures, such as `n_moves`."""
    return measure.partition(".")[2].startswith("n_")


def primary_measures(measures: Sequence[str], present: Iterable[Collection[str]] = ()) -> tuple[str, ...]:
    """Return the default family: for each signature, the first headline measure that all worlds have.

    One measure per signature keeps the family small enough for ten seeds.

    Args:
        measures: all measures, in their order.
        present: the measures that each run has; by default all, but worlds can have different measures.
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
    """Return the measures to test: the family, or by default `primary_measures`.

    Raises:
        InputError: a measure of the family does not exist.
    """
    return primary_measures(measures, present) if family is None else known_measures(family, measures)


def known_measures(names: Sequence[str], measures: Sequence[str]) -> tuple[str, ...]:
    """Return the names, or raise an InputError if one of them is not a measure."""
    for name in names:
        if name not in measures:
            raise unknown_measure(name, measures)
    return tuple(names)


def headline_measures(measures: Sequence[str]) -> tuple[str, ...]:
    """Return the headline measures of all signatures except cost, over all decisions and without denominators."""
    shown = [signature.headline_columns(measures) for signature in _claimed()]
    return tuple(dict.fromkeys(name for columns in shown for name in columns if not is_denominator(name)))


def unknown_measure(asked: str, measures: Sequence[str]) -> InputError:
    """Return the error for an unknown measure; it lists the measures of the signature, or the headline measures."""
    signatures = dict.fromkeys(name.partition(".")[0] for name in measures)
    meant = difflib.get_close_matches(asked.partition(".")[0], list(signatures), n=1)
    own = [name for name in measures if name.partition(".")[0] in meant and not is_readable_only(name)]
    return not_found("Measure", asked, own or headline_measures(measures), "All are columns of signatures.csv.")
