"""What every signature must hold: it describes its measures, measures alike what is alike, and says NaN for nothing."""

from __future__ import annotations

import inspect
import math
import pickle
import re
import typing
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from types import ModuleType
from typing import Any

from foundry.conformance.finding import Broken, Skipped, require

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_COUNT = "n_"
"""How the names of counts begin, which are denominators and may be 0."""


@dataclass(frozen=True)
class SignatureCase:
    """A signature to be checked.

    Attributes:
        module: it.
        runs: runs as arrays, of every kind that its function could take.
        emptied: the same runs, none of whose decisions could be read and none of which counts.
    """

    module: ModuleType
    runs: Sequence[Any]
    emptied: Sequence[Any]

    def taken(self, runs: Iterable[Any]) -> list[Any]:
        """Return the runs that its function takes.

        Raises:
            Broken: it does not say which it takes.
            Skipped: there are none here.
        """
        kind = run_type(self.module)
        found = [run for run in runs if isinstance(run, kind)]
        if not found:
            raise Skipped(f"it takes a {kind.__name__}, and this world gives none: name another world=")
        found = [run for run in found if getattr(self.module, "applies", lambda _: True)(run)]
        if not found:
            raise Skipped("it is not about this world: name another world=")
        return found

    def measured(self) -> list[dict[str, float]]:
        """Return what it measures of each run."""
        return [self.module.measure(run) for run in self.taken(self.runs)]


def run_type(module: ModuleType) -> type:
    """Return the class of the runs that a signature's function takes.

    Raises:
        Broken: it does not say.
    """
    function = getattr(module, "measure", None)
    if not callable(function):
        raise Broken("it has no function `measure`: define measure(run: ...) -> dict[str, float]")
    names = list(inspect.signature(function).parameters)
    kind = typing.get_type_hints(function).get(names[0]) if names else None
    if not isinstance(kind, type):
        raise Broken("measure does not say what it takes: annotate it, as in measure(run: AnyRun) -> dict[str, float]")
    return kind


def says_what_it_is(case: SignatureCase) -> None:
    """It has a NAME for its columns, MEASURES that describe them, and a HEADLINE of some of these."""
    name = getattr(case.module, "NAME", None)
    require(
        isinstance(name, str) and _NAME.fullmatch(name) is not None,
        f"NAME is {name!r}: give a text of small letters, digits and _, the prefix of its columns",
    )
    measures = getattr(case.module, "MEASURES", None)
    described = isinstance(measures, Mapping) and all(getattr(one, "label", "") for one in measures.values())
    require(described, "MEASURES is no mapping of names to analysis.measure.Measure, each with a label")
    headline = getattr(case.module, "HEADLINE", ())
    require(isinstance(headline, tuple) and bool(headline), f"HEADLINE is {headline!r}: give a tuple of measures")
    for one in headline:
        require(_is_described(one, measures or {}), f"HEADLINE names '{one}', which MEASURES does not describe")


def says_what_it_takes(case: SignatureCase) -> None:
    """The annotation of `measure` says for which runs it is."""
    run_type(case.module)


def measures_what_it_describes(case: SignatureCase) -> None:
    """Every measure is a number, described, and between the values that it says."""
    for found in case.measured():
        require(isinstance(found, dict), f"measure gives {type(found).__name__}: return a dict of floats")
        for name, value in found.items():
            require(isinstance(value, Real), f"'{name}' is {value!r}: return a number")
            _check_range(name, value, case.module.MEASURES)


def _check_range(name: str, value: float, measures: Mapping[str, Any]) -> None:
    if name.startswith(_COUNT):
        require(value >= 0, f"the count '{name}' is {value:g}")
        return
    require(
        _is_described(name, measures), f"'{name}' is not in MEASURES: describe it there, or call a count {_COUNT}..."
    )
    measure = next(one for pattern, one in measures.items() if _matches(name, pattern))
    within = math.isnan(value) or (math.isfinite(value) and measure.low - 1e-9 <= value <= measure.high + 1e-9)
    require(within, f"'{name}' is {value:g}, and MEASURES says {measure.low:g} to {measure.high:g}")


def _is_described(name: str, measures: Mapping[str, Any]) -> bool:
    return any(_matches(name, pattern) for pattern in measures)


def _matches(name: str, pattern: str) -> bool:
    start, star, end = pattern.partition("*")
    return name == pattern or (bool(star) and name.startswith(start) and name.endswith(end))


def has_the_same_names_whatever_happened(case: SignatureCase) -> None:
    """Runs of one world have the same measures, also where nothing could be read."""
    emptied = [case.module.measure(run) for run in case.taken(case.emptied)]
    found = [*case.measured(), *emptied]
    first, others = found[0], found[1:]
    for other in others:
        differing = sorted(set(first) ^ set(other))
        require(
            not differing, f"{', '.join(differing)} is there in one run and not in another: say NaN where undefined"
        )


def says_nan_for_nothing(case: SignatureCase) -> str | None:
    """Where no decision counts, what is undefined is NaN: a measure of 0 would be a finding."""
    if not getattr(case.module, "READABLE_TOO", True):
        raise Skipped("READABLE_TOO is False: all decisions count")
    zeros: set[str] = set()
    for run in case.taken(case.emptied):
        found = {name: value for name, value in case.module.measure(run).items() if not name.startswith(_COUNT)}
        none = {name for name, value in found.items() if value == 0}
        require(
            not none or len(none) < len(found),
            f"{', '.join(sorted(none))} is 0 in a run without any decision that counts: say NaN, for 0 is a finding",
        )
        zeros |= none
    return f"0 where no decision counts, which should be meant so: {', '.join(sorted(zeros))}" if zeros else None


def measures_the_same_twice(case: SignatureCase) -> None:
    """Measuring a run again gives the same numbers."""
    for first, second in zip(case.measured(), case.measured(), strict=True):
        require(
            repr(first) == repr(second), f"a second look gives {second} instead of {first}: draw from a fixed stream"
        )


def leaves_the_run_as_it_is(case: SignatureCase) -> None:
    """Measuring changes nothing of the run, which all signatures share."""
    for run in case.taken(case.runs):
        before = pickle.dumps(vars(run))
        case.module.measure(run)
        after = {name: value for name, value in vars(run).items() if name in pickle.loads(before)}
        require(pickle.dumps(after) == before, "measure changes the run: copy an array before writing into it")


CHECKS = (
    says_what_it_is,
    says_what_it_takes,
    measures_what_it_describes,
    has_the_same_names_whatever_happened,
    says_nan_for_nothing,
    measures_the_same_twice,
    leaves_the_run_as_it_is,
)
