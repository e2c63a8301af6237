"""Every check of signatures sees what it is there for."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from analysis.measure import Null
from foundry.conformance.finding import Status, look, name_of
from foundry.conformance.signatures import SIGNATURE, SignatureCase

BY_NAME = {name_of(check): check for check in SIGNATURE}
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
    found = ModuleType("own")
    vars(found).update(
        {"NAME": "own", "MEASURES": {"mean": Described("Mean")}, "HEADLINE": ("mean",), "measure": measure} | changes
    )
    return found


def case(one: ModuleType) -> SignatureCase:
    return SignatureCase(one, [Run(), Run()], [Run(np.array([]))], lambda: [Run()] * 6)


BROKEN = [
    (module(mean, NAME="Own name"), "says what it is", "NAME"),
    (module(mean, MEASURES={"mean": Described("")}), "says what it is", "MEASURES"),
    (module(mean, HEADLINE=["mean"]), "says what it is", "HEADLINE"),
    (module(mean, HEADLINE=("median",)), "says what it is", "does not describe"),
    (module(unsaid), "says what it takes", "annotate"),
    (module(None), "says what it takes", "no function `measure`"),  # type: ignore[arg-type]
    (module(endless), "measures what it describes", "inf"),
    (module(beyond), "measures what it describes", "0 to 10"),
    (module(text), "measures what it describes", "return a number"),
    (module(more), "measures what it describes", "not in MEASURES"),
    (module(missing), "has the same names whatever happened", "say NaN"),
    (module(zero), "says nan for nothing", "is 0"),
    (module(mean, MEASURES={"mean": Described("Mean", null=Null(3, "draws"))}), "comes to its nulls", "Null says 3"),
    (module(drifting), "measures the same twice", "second look"),
    (module(writing), "leaves the run as it is", "changes the run"),
]


@pytest.mark.parametrize("check", SIGNATURE, ids=name_of)
def test_a_sound_signature_passes(check):
    found = look("signature own", check, case(module(mean)))
    assert (found.status, found.note) == (Status.PASSED, "")


@pytest.mark.parametrize(
    ("broken", "name", "words"), BROKEN, ids=[f"{name} {n}" for n, (_, name, _) in enumerate(BROKEN)]
)
def test_a_signature_that_breaks_a_rule_fails_the_check_of_that_rule(broken: ModuleType, name: str, words: str):
    found = look("signature own", BY_NAME[name], case(broken))
    assert found.status is Status.FAILED and words in found.note, found


def test_every_check_is_seen_to_fail():
    assert {name for _, name, _ in BROKEN} == set(BY_NAME)


def test_a_signature_of_another_form_is_tried_on_nothing():
    found = look("signature own", BY_NAME["measures what it describes"], case(module(foreign)))
    assert found.status is Status.SKIPPED and "Other" in found.note
