"""Which measures a claim may rest on: those declared before anything is seen."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.signatures import discover

NO_BEHAVIOUR = frozenset({"cost"})
"""Signatures that say what a run took, and not what the agents did."""


def is_denominator(measure: str) -> bool:
    """Return whether the measure only counts what others are shares of."""
    return measure.partition(".")[2].startswith("n_")


def primary_measures(measures: Sequence[str]) -> tuple[str, ...]:
    """Return the family that is declared unless another is: of each signature the first of its headline measures.

    One measure a signature keeps the family small enough for ten seeds, which exact tests of many measures are not.
    """
    shown = [one.headline_columns(measures) for one in discover() if one.name not in NO_BEHAVIOUR]
    return tuple(columns[0] for columns in shown if columns)


def headline_measures(measures: Sequence[str]) -> tuple[str, ...]:
    """Return the signatures' headlines over all decisions, without denominators and cost."""
    shown = [one.headline_columns(measures) for one in discover() if one.name not in NO_BEHAVIOUR]
    return tuple(dict.fromkeys(name for columns in shown for name in columns if not is_denominator(name)))
