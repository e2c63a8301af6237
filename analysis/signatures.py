"""The signatures: modules that are found by being in `analysis/<form>/signatures/`, or a user's own.

A module defines

- `NAME`: the prefix of its columns;
- `measure(run: GridRun) -> dict[str, float]`: its measures of one run, without the prefix. What the run is annotated
  as says whose runs are measured: those of one form, or with `AnyRun` those of every form. Undefined is NaN, never 0;
  counts that are denominators are named `n_...`. Which names there are does not depend on what happened in the run;
- `MEASURES`: what each measure is called, between which values it can lie, and what chance alone gives, where there
  is such a number; a `*` stands for the name of a place or another configured thing;
- `HEADLINE`: the measures that its plot and the short table show, in their order, `*` included; claims rest on the
  first of them unless others are declared, so none of them may differ between policies that are alike in what it is
  about: `tests/analysis/test_nulls.py` plays such policies;
- optionally `READABLE_TOO = False`, where it makes no sense to leave out the decisions that could not be read;
- optionally `applies(run) -> bool`, where it is about some worlds of the form alone: whether it is about the run's, by
  what its world declares and is set to, never by what happened in the run;
- optionally `PRIMARY = False`, where no claim rests on it unless that is declared;
- optionally `LABEL`, the label that its measures rest on, all but those of `UNLABELLED`, and
  `correct(run, correction)`, which returns the measures that labels of people correct.

Modules of several forms that have one `NAME` are one signature: a name means the same in all. Where a form has a
module of the name that one for every form has, too, the form's own measures its runs.

Every measure is there twice: over all decisions as `<signature>.<measure>`, and as
`<signature>.<measure>_readable` over those alone that could be read, that is whose outcome is `chosen` or
`repaired`. A module counts what the run says that counts: `run.counted` and `run.message_counted`. What is counted by
decision, counts these decisions. What is a mean over states is weighted by the number of counted decisions that led to
each state; what belongs to one agent in a state counts if the agent's own decision that led there does. Of pairs of
decisions both must count.
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
from analysis.labelling import Labelling
from analysis.labelling.correcting import Correction
from analysis.measure import Measure, share
from analysis.signature_modules import Part, parts
from foundry.own_code import own_folders

FAILURE_RATE = "failure.rate"
"""The one column that comes from how runs ended: 1 for a failed run, 0 for a complete one, NaN for others."""

READABLE_SUFFIX = "_readable"
"""How the measures over the readable decisions alone end."""


@dataclass(frozen=True)
class Signature:
    """The modules of one name.

    Attributes:
        name: the prefix of its columns.
        parts: the modules, those for one form before the one for all.
    """

    name: str
    parts: tuple[Part, ...]

    @property
    def primary(self) -> bool:
        """Whether claims rest on it where nothing is declared."""
        return any(one.primary for one in self.parts)

    @property
    def is_label(self) -> bool:
        """Whether its measures are shares of the choices of a label."""
        return any(one.about for one in self.parts)

    @property
    def readable_too(self) -> bool:
        """Whether it has measures over the readable decisions alone."""
        return any(one.readable_too for one in self.parts)

    @cached_property
    def measures(self) -> Mapping[str, Measure]:
        """What its measures are."""
        return {name: one.measures[name] for one in reversed(self.parts) for name in one.measures}

    @property
    def headline(self) -> tuple[str, ...]:
        """The measures that are shown first."""
        return tuple(dict.fromkeys(name for one in self.parts for name in one.headline))

    def part(self, run: type) -> Part | None:
        """Return what measures runs of the form with this class; None where nothing does."""
        return next((one for one in self.parts if one.run in (run, AnyRun)), None)

    def measure(self, run: Any) -> dict[str, float]:
        """Return the measures of a run over the decisions that count in it; none if it is not about its world."""
        return next((one.measure(run) for one in self.parts if one.run is type(run) and one.applies(run)), {})

    def columns(self, run: Any, readable: Any) -> dict[str, float]:
        """Return the columns of a run: its measures, then those of the same run with the readable decisions alone."""
        every = self.measure(run)
        found = {f"{self.name}.{name}": value for name, value in every.items()}
        if self.readable_too:
            alone = every if run.all_readable else self.measure(readable)
            found |= {f"{self.name}.{name}{READABLE_SUFFIX}": value for name, value in alone.items()}
        return found

    def is_readable_only(self, measure: str) -> bool:
        """Return whether a measure, without the signature's name, is over the readable decisions alone."""
        return self.readable_too and measure.endswith(READABLE_SUFFIX)

    def describe(self, measure: str, run: type | None = None) -> Measure:
        """Return what a measure is.

        Args:
            measure: without the signature's name.
            run: the class of the runs that it is of, where one name means different things in several forms.
        """
        if self.is_readable_only(measure):
            found = self.describe(measure.removesuffix(READABLE_SUFFIX), run)
            return replace(found, label=f"{found.label}, readable alone")
        if measure.endswith(UNCORRECTED):
            found = self.describe(measure.removesuffix(UNCORRECTED), run)
            return replace(found, label=f"{found.label}, without labels of people")
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
        """Return those columns of a table that are this signature's headline over all decisions, in its order."""
        prefix = f"{self.name}."
        present = [name.removeprefix(prefix) for name in columns if name.startswith(prefix)]
        return [
            f"{prefix}{name}"
            for pattern in self.headline
            for name in present
            if not self.is_readable_only(name) and self._means(pattern, name)
        ]

    def _means(self, pattern: str, measure: str) -> bool:
        """Return whether a measure is one of a pattern, and of none that says more of its name."""
        start, star, _ = pattern.partition("*")
        if not star:
            return measure == pattern
        further = (one.partition("*")[0] for one in (*self.measures, "n_*") if "*" in one)
        return measure.startswith(start) and not any(
            len(one) > len(start) and measure.startswith(one) for one in further
        )


def discover() -> tuple[Signature, ...]:
    """Return all signatures by name, the user's own among them.

    Raises:
        InputError: a module of the user's own cannot be used; names its file.
    """
    return _discover(own_folders())


@cache
def _discover(_folders: tuple[Path, ...]) -> tuple[Signature, ...]:
    found = sorted(parts(), key=lambda one: (one.name, one.run is AnyRun))
    return tuple(Signature(name, tuple(same)) for name, same in groupby(found, key=lambda one: one.name))


def measure(run: Any, general: AnyRun | None = None) -> dict[str, float]:
    """Return every measure of every signature, over all decisions and over the readable ones alone.

    Args:
        run: a run as its form has it.
        general: the same run as every form has it; without it the signatures of every form are left out.
    """
    views = {type(one): (one, one.only_readable()) for one in (general, run) if one is not None}
    found: dict[str, float] = {}
    for signature in discover():
        part = signature.part(type(run))
        if part is not None and part.run in views:
            found |= signature.columns(*views[part.run])
    return found


def corrected(
    run: Any, measures: Mapping[str, float], corrections: Mapping[str, Correction]
) -> tuple[dict[str, float], dict[str, FloatArray]]:
    """Return the measures of a run that labels of people change, and the values of those that are taken of copies.

    What was measured without these labels keeps its value under a name that ends with UNCORRECTED.

    Args:
        run: a run as its form has it.
        measures: the measures without the labels of people, by `<signature>.<measure>`.
        corrections: by label.
    """
    found: dict[str, float] = {}
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
                found[column] = _mean(values)
                found[f"{signature.name}.{name}{UNCORRECTED}{suffix}"] = measures[column]
                if len(values) > 1:
                    copies[column] = values
    return found, copies


def _mean(values: FloatArray) -> float:
    """Return the mean of the copies in which a measure is defined; NaN where there is none."""
    defined = values[~np.isnan(values)]
    return float(defined.mean()) if len(defined) else math.nan


def readings(labellings: Iterable[Labelling], measures: Iterable[str]) -> dict[str, str]:
    """Return whose reading of texts each of these measures rests on, in words; nothing of those that rest on none."""
    by_sweep, names = list(labellings), list(measures)
    rests_on = {one.name: (part.label, part.unlabelled) for one in discover() for part in one.parts if part.label}
    rests_on |= {own.label.name: (own.label.name, ()) for one in by_sweep for own in one.own}
    alone = {own.label.name for one in by_sweep for own in one.own if not own.has_surrogate}
    found: dict[str, str] = {}
    for column in names:
        name, _, measure = column.removesuffix(READABLE_SUFFIX).partition(".")
        label, without = rests_on.get(name, ("", ()))
        if label and measure not in without and not measure.startswith("n_"):
            is_corrected = f"{name}.{measure}{UNCORRECTED}" in names or label in alone
            correctable = is_corrected or measure.endswith(UNCORRECTED)
            whose = (one.reading(label, corrected=is_corrected, correctable=correctable) for one in by_sweep)
            found[column] = " or ".join(dict.fromkeys(whose))
    return found


def sources(forms: Iterable[FormAnalysis], measures: Iterable[str]) -> list[dict[str, str]]:
    """Return where the signatures of these forms come from, a row a form and signature; labels only if measured.

    The keys: `form`, `signature`, `origin` (`foundry`, or the user's own file or package), `module` (its full name, or
    the file's name), and `sha256` of its code without docstrings and comments.
    """
    names = {name.partition(".")[0] for name in measures}
    shown = [one for one in discover() if one.name in names or not one.is_label]
    kept = [(form.name, one.part(form.run)) for form in forms for one in shown]
    return [
        {"form": form, "signature": part.name, "origin": part.origin, "module": part.module, "sha256": part.sha256}
        for form, part in kept
        if part is not None
    ]


def is_readable_only(column: str) -> bool:
    """Return whether the column `<signature>.<measure>` is over the readable decisions alone."""
    name, _, measure = column.partition(".")
    return any(one.name == name and one.is_readable_only(measure) for one in discover())


def is_of_form(column: str, run: type) -> bool:
    """Return whether the form with this class of runs has its own measure of this name, and not that of any form."""
    part = next((one.part(run) for one in discover() if one.name == column.partition(".")[0]), None)
    return part is not None and part.run is not AnyRun


def describe(column: str, run: type | None = None) -> Measure:
    """Return what the column `<signature>.<measure>` is, of runs of this class where one is given."""
    if column == FAILURE_RATE:
        return share("Failed runs (share)")
    name, _, measure = column.partition(".")
    by_name = {signature.name: signature for signature in discover()}
    return by_name[name].describe(measure, run) if name in by_name else Measure(column)
