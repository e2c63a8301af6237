"""The signatures: modules in `analysis/<form>/signatures/`, or your own.

A module defines

- `NAME`: the prefix of the signature's columns;
- `measure(run: GridRun) -> dict[str, float]`: its measures of one run, without the prefix. The type of `run` says which
  runs the module measures: `GridRun` for runs of 2D worlds, `AnyRun` for runs of every form. An undefined value is NaN,
  never 0. Counts that are denominators are named `n_...`. The names of the measures must not depend on events in the
  run;
- `MEASURES`: the title, range and null (if any) of each measure; a `*` stands for the name of a place or another
  configured thing;
- `HEADLINE`: the measures in the signature's plot and in the short table, in order; names may contain `*`. By default
  the first headline measure is tested. Policies that do not differ in the signature's subject must not differ in any
  headline measure; `tests/analysis/test_nulls.py` plays such policies;
- optionally `READABLE_TOO = False`, if leaving out unreadable decisions makes no sense;
- optionally `applies(run) -> bool`, if the signature has a meaning only in some worlds of the form. The function says
  whether the signature applies to the run's world. It may use the world's declarations and settings, but no events;
- optionally `PRIMARY = False`, if the signature is tested only when declared;
- optionally `LABEL`, the label from which the measures are computed; the measures in `UNLABELLED` need no label;
- optionally `correct(run, correction)`, which returns the measures corrected by people's labels.

Modules of several forms with one `NAME` are one signature: a name has one meaning in all forms. If a signature has a
module for one form and a module for any form, the form's own module measures the runs of this form.

Every measure exists twice: over all decisions as `<signature>.<measure>`, and over readable decisions (outcome `chosen`
or `repaired`) as `<signature>.<measure>_readable`. A module uses only the decisions in `run.counted` and
`run.message_counted`. Means over states weight each state by the number of counted decisions that led to it. A value of
one agent in a state counts if the agent's own counted decision led to this state. A pair of decisions counts if both
decisions count.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.any.label_signature import UNCORRECTED
from analysis.arrays import FloatArray
from analysis.form import FormAnalysis
from analysis.labelling import Labelling, Reading
from analysis.labelling.correcting import Correction
from analysis.measure import Measure, share
from analysis.signature_modules import Part, parts
from foundry.own_code import own_folders

FAILURE_RATE = "failure.rate"
"""The column that is 1 for a failed run, 0 for a complete run and NaN for others."""

READABLE_SUFFIX = "_readable"
"""Suffix of the measures over readable decisions only."""


@dataclass(frozen=True)
class Signature:
    """A signature: all modules with the same name.

    Attributes:
        parts: its modules; those for a single form come before the one for any form.
    """

    name: str
    parts: tuple[Part, ...]

    @property
    def primary(self) -> bool:
        """True if the signature is tested by default."""
        return any(part.primary for part in self.parts)

    @property
    def is_label(self) -> bool:
        """True if the signature's measures are the shares of a label's choices."""
        return any(part.about for part in self.parts)

    @property
    def readable_too(self) -> bool:
        """True if the signature also has measures over readable decisions only."""
        return any(part.readable_too for part in self.parts)

    @cached_property
    def measures(self) -> Mapping[str, Measure]:
        """The measures of the signature, by name."""
        return {name: part.measures[name] for part in reversed(self.parts) for name in part.measures}

    @property
    def headline(self) -> tuple[str, ...]:
        """Names of the measures that are shown first."""
        return tuple(dict.fromkeys(name for part in self.parts for name in part.headline))

    def part(self, run: type) -> Part | None:
        """Return the signature's module that measures runs of the given class; None if it has none."""
        return next((part for part in self.parts if part.run in (run, AnyRun)), None)

    def measure(self, run: Any) -> dict[str, float]:
        """Return a run's measures over its counted decisions; {} if the signature does not apply to its world."""
        return next((part.measure(run) for part in self.parts if part.run is type(run) and part.applies(run)), {})

    def columns(self, run: Any, readable: Any) -> dict[str, float]:
        """Return the columns of a run: its measures, then the same over readable decisions only."""
        every = self.measure(run)
        values = {f"{self.name}.{name}": value for name, value in every.items()}
        if self.readable_too:
            alone = every if run.all_readable else self.measure(readable)
            values |= {f"{self.name}.{name}{READABLE_SUFFIX}": value for name, value in alone.items()}
        return values

    def is_readable_only(self, measure: str) -> bool:
        """Return whether a measure, without the signature's name, is over readable decisions only."""
        return self.readable_too and measure.endswith(READABLE_SUFFIX)

    def describe(self, measure: str, run: type | None = None) -> Measure:
        """Return the description of a measure.

        Args:
            measure: name of the measure without the signature's name.
            run: class of the runs, because the description can depend on the form.
        """
        if self.is_readable_only(measure):
            measure_all = self.describe(measure.removesuffix(READABLE_SUFFIX), run)
            return replace(measure_all, label=f"{measure_all.label}, readable only")
        if measure.endswith(UNCORRECTED):
            measure_all = self.describe(measure.removesuffix(UNCORRECTED), run)
            return replace(measure_all, label=f"{measure_all.label}, without people's labels")
        part = None if run is None else self.part(run)
        measures = {**self.measures, **(part.measures if part else {})}
        if measure in measures:
            return measures[measure]
        for pattern, described in measures.items():
            start, star, end = pattern.partition("*")
            if star and measure.startswith(start) and measure.endswith(end):
                return described.of(measure[len(start) : len(measure) - len(end)])
        return Measure(measure.replace("_", " "), low=0) if measure.startswith("n_") else Measure(measure)

    def headline_columns(self, columns: Iterable[str]) -> list[str]:
        """Return the columns that are headline measures over all decisions, in the order of `headline`."""
        prefix = f"{self.name}."
        present = [name.removeprefix(prefix) for name in columns if name.startswith(prefix)]
        return [
            f"{prefix}{name}"
            for pattern in self.headline
            for name in present
            if not self.is_readable_only(name) and self._means(pattern, name)
        ]

    def _means(self, pattern: str, measure: str) -> bool:
        """Return whether a measure matches a pattern such as `share_*`, but no longer pattern, such as `share_of_*`."""
        start, star, _ = pattern.partition("*")
        if not star:
            return measure == pattern
        further = (pattern.partition("*")[0] for pattern in (*self.measures, "n_*") if "*" in pattern)
        return measure.startswith(start) and not any(
            len(start_of_name) > len(start) and measure.startswith(start_of_name) for start_of_name in further
        )


def discover() -> tuple[Signature, ...]:
    """Return all signatures by name, including your own.

    Raises:
        InputError: a user's module cannot be used.
    """
    return _discover(own_folders())


@cache
def _discover(_folders: tuple[Path, ...]) -> tuple[Signature, ...]:
    all_parts = sorted(parts(), key=lambda part: (part.name, part.run is AnyRun))
    return tuple(Signature(name, tuple(same)) for name, same in groupby(all_parts, key=lambda part: part.name))


def measure(run: Any, general: AnyRun | None = None) -> dict[str, float]:
    """Return all measures of all signatures, over all decisions and over readable decisions only.

    Args:
        run: a run, in the class of its form.
        general: the same run in the class for any form; if None, signatures of any form are left out.
    """
    views = {type(view): (view, view.only_readable()) for view in (general, run) if view is not None}
    values: dict[str, float] = {}
    for signature in discover():
        part = signature.part(type(run))
        if part is not None and part.run in views:
            values |= signature.columns(*views[part.run])
    return values


def corrected(
    run: Any, measures: Mapping[str, float], corrections: Mapping[str, Correction]
) -> tuple[dict[str, float], dict[str, FloatArray]]:
    """Return a run's measures, corrected by people's labels.

    The second result has the value in each copy, for measures that use copies.

    The uncorrected measure gets a name with the suffix UNCORRECTED.

    Args:
        run: a run, in the class of its form.
        measures: measures without people's labels, by `<signature>.<measure>`.
        corrections: corrections by label.
    """
    corrected_values: dict[str, float] = {}
    copies: dict[str, FloatArray] = {}
    for signature in discover():
        part = signature.part(type(run))
        correction = corrections.get(part.label) if part is not None else None
        if part is None or part.correct is None or correction is None or run.id not in correction.strata_of_run:
            continue
        views = {"": run, READABLE_SUFFIX: run.only_readable()} if signature.readable_too else {"": run}
        for suffix, view in views.items():
            for name, values in part.correct(view, correction).items():
                column = f"{signature.name}.{name}{suffix}"
                corrected_values[column] = _mean(values)
                corrected_values[f"{signature.name}.{name}{UNCORRECTED}{suffix}"] = measures[column]
                if len(values) > 1:
                    copies[column] = values
    return corrected_values, copies


def _mean(values: FloatArray) -> float:
    defined = values[~np.isnan(values)]
    return float(defined.mean()) if len(defined) else math.nan


def readings(labellings: Iterable[Labelling], measures: Iterable[str]) -> dict[str, Reading]:
    """Return who labelled the texts behind each measure; measures without labels are left out."""
    by_sweep, names = list(labellings), list(measures)
    rests_on = {
        signature.name: (part.label, part.unlabelled)
        for signature in discover()
        for part in signature.parts
        if part.label
    }
    rests_on |= {own.label.name: (own.label.name, ()) for labelling in by_sweep for own in labelling.own}
    alone = {own.label.name for labelling in by_sweep for own in labelling.own if not own.has_surrogate}
    by_measure: dict[str, Reading] = {}
    for column in names:
        name, _, measure = column.removesuffix(READABLE_SUFFIX).partition(".")
        label, without = rests_on.get(name, ("", ()))
        if label and measure not in without and not measure.startswith("n_"):
            is_corrected = f"{name}.{measure}{UNCORRECTED}" in names or label in alone
            correctable = is_corrected or measure.endswith(UNCORRECTED)
            every = [
                labelling.reading(label, corrected=is_corrected, correctable=correctable) for labelling in by_sweep
            ]
            short, text = (
                " or ".join(dict.fromkeys(getattr(reading, name) for reading in every)) for name in ("short", "text")
            )
            by_measure[column] = Reading(short, text)
    return by_measure


def sources(forms: Iterable[FormAnalysis], measures: Iterable[str]) -> list[dict[str, str]]:
    """Return a row per form and signature with the origin of its code.

    Signatures of labels are included only if `measures` names one of their measures.

    The keys are `form`, `signature`, `origin` (`foundry`, or your own file or package), `module` (its full name, or the
    name of your file), and `sha256` of its code.
    """
    names = {name.partition(".")[0] for name in measures}
    shown = [signature for signature in discover() if signature.name in names or not signature.is_label]
    used = [(form.name, signature.part(form.run)) for form in forms for signature in shown]
    return [
        {"form": form, "signature": part.name, "origin": part.origin, "module": part.module, "sha256": part.sha256}
        for form, part in used
        if part is not None
    ]


def is_readable_only(column: str) -> bool:
    """Return whether the column `<signature>.<measure>` is over readable decisions only."""
    name, _, measure = column.partition(".")
    return any(signature.name == name and signature.is_readable_only(measure) for signature in discover())


def is_of_form(column: str, run: type) -> bool:
    """Return True if a column's signature has a module for exactly this class of runs, not only one for any form."""
    part = next((signature.part(run) for signature in discover() if signature.name == column.partition(".")[0]), None)
    return part is not None and part.run is not AnyRun


def describe(column: str, run: type | None = None) -> Measure:
    """Return the description of the measure in the column `<signature>.<measure>`.

    If `run` is given, it is the description for runs of this class.
    """
    if column == FAILURE_RATE:
        return share("Failed runs (share)")
    name, _, measure = column.partition(".")
    by_name = {signature.name: signature for signature in discover()}
    return by_name[name].describe(measure, run) if name in by_name else Measure(column)
