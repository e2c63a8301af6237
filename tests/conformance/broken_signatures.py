"""A signature that holds all that a signature must hold, and signatures that break one rule each."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from analysis.measure import Null
from foundry.conformance.signatures import SignatureCase

NUMBERS = itertools.count(1)


@dataclass(frozen=True)
class Run:
    """A run of which only the numbers that were decided are known."""

    number: Any = field(default_factory=lambda: np.array([1.0, 2.0, 4.0]))


class Other:
    """A run of another form."""


@dataclass(frozen=True)
class Described:
    label: str
    low: float = 0.0
    high: float = 10.0
    null: Null | None = Null(7 / 3, "draws at random")


def mean(run: Run) -> dict[str, float]:
    return {"mean": float(run.number.mean()) if run.number.size else math.nan, "n_decisions": float(run.number.size)}


def unsaid(run) -> dict[str, float]:
    return {}


def zero(run: Run) -> dict[str, float]:
    return {"mean": float(run.number.mean()) if run.number.size else 0.0}


def missing(run: Run) -> dict[str, float]:
    return mean(run) if run.number.size else {}


def endless(run: Run) -> dict[str, float]:
    return {"mean": math.inf}


def beyond(run: Run) -> dict[str, float]:
    return {"mean": 11.0}


def text(run: Run) -> dict[str, Any]:
    return {"mean": "high"}


def more(run: Run) -> dict[str, float]:
    return {"median": 1.0}


def drifting(run: Run) -> dict[str, float]:
    return {"mean": 1.0 / next(NUMBERS)}


def writing(run: Run) -> dict[str, float]:
    run.number.sort()
    run.number[:] = 0
    return {"mean": 1.0}


def foreign(run: Other) -> dict[str, float]:
    return {"mean": 1.0}


def module(measure: Callable[..., Any], **changes: Any) -> ModuleType:
    module = ModuleType("own")
    vars(module).update(
        {"NAME": "own", "MEASURES": {"mean": Described("Mean")}, "HEADLINE": ("mean",), "measure": measure} | changes
    )
    return module


def case(one: ModuleType) -> SignatureCase:
    return SignatureCase(one, [Run(), Run()], [Run(np.array([]))], lambda: [[Run()]] * 6)


SOUND = case(module(mean))
FOREIGN = case(module(foreign))
BROKEN = [
    (case(module(mean, NAME="Own name")), "says what it is", "NAME"),
    (case(module(mean, MEASURES={"mean": Described("")})), "says what it is", "MEASURES"),
    (case(module(mean, HEADLINE=["mean"])), "says what it is", "HEADLINE"),
    (case(module(mean, HEADLINE=("median",))), "says what it is", "does not describe"),
    (case(module(unsaid)), "says what it takes", "annotation"),
    (case(module(None)), "says what it takes", "no function `measure`"),  # type: ignore[arg-type]
    (case(module(endless)), "measures what it describes", "inf"),
    (case(module(beyond)), "measures what it describes", "0 to 10"),
    (case(module(text)), "measures what it describes", "return a number"),
    (case(module(more)), "measures what it describes", "not in MEASURES"),
    (case(module(missing)), "has the same names whatever happened", "as NaN"),
    (case(module(zero)), "says nan for nothing", "is 0"),
    (case(module(mean, MEASURES={"mean": Described("Mean", null=Null(3, ""))})), "comes to its nulls", "Null is 3"),
    (case(module(drifting)), "measures the same twice", "measuring again"),
    (case(module(writing)), "leaves the run as it is", "changes the run"),
]
