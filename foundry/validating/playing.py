"""Plays what is known of a world in closed form: scripted policies over many seeds, each against its number."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from foundry import calling
from foundry.errors import FoundryError

if TYPE_CHECKING:
    from analysis.validation.facts import ClosedForm, Facts, Study

Z = 4.0
"""Standard errors that a mean may be off; of a hundred right ones, one page in 160 would show a wrong one."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Held:
    """What scripted policies came to, against what they must.

    Attributes:
        world: name of the world.
        name: of the closed form.
        command: what plays it again.
        column: the measure; empty for a study.
        n: seeds; 0 for a study.
        result: mean over seeds.
        error: its standard error; 0 where every seed gives the same.
        value: the closed form.
        tolerance: how far the number itself is rounded.
        why: where the number comes from.
    """

    world: str
    name: str
    command: str
    column: str
    n: int
    result: float
    error: float
    value: float
    tolerance: float
    why: str

    @property
    def holds(self) -> bool:
        """Whether the result is within `Z` standard errors and the tolerance of the closed form."""
        return abs(self.result - self.value) <= self.tolerance + Z * self.error + _ROUNDING * max(abs(self.value), 1.0)


def hold(facts: Facts, folder: Path, mine: Sequence[Path] = ()) -> Iterator[Held]:
    """Play everything that is known of a world in closed form.

    Args:
        facts: what is known of it.
        folder: where the sweeps go.
        mine: the user's own folders.

    Raises:
        FoundryError: a run failed, or a measure is not defined in one.
    """
    for place, one in enumerate(facts.closed_forms):
        yield _played(facts.world, one, folder / f"{facts.world}-{place}", mine)
    for study in facts.studies:
        yield _studied(facts.world, study)


def _played(world: str, one: ClosedForm, folder: Path, mine: Sequence[Path]) -> Held:
    from analysis.validation.values import values_of

    asked = (f"world={world}", f"model={one.policy}", f"seed=0-{one.seeds - 1}", *one.overrides)
    where = (f"output.dir={folder}", "cache.path=''", "analyze=false")
    ran = calling.sweep(*asked, *where, config_dir=mine[0] if mine else None)
    if ran.failed:
        raise FoundryError(f"'{one.name}' of world '{world}' cannot be played: {ran.failed[0]}")
    values = values_of(ran.path, one.column)
    mean = math.fsum(values) / len(values)
    spread = math.sqrt(math.fsum((value - mean) ** 2 for value in values) / max(len(values) - 1, 1))
    return Held(
        command=f"foundry -m {' '.join(asked)}" + (f" --config-dir {mine[0]}" if mine else ""),
        world=world,
        column=one.column,
        n=len(values),
        result=mean,
        error=spread / math.sqrt(len(values)),
        **_said(one),
    )


def _studied(world: str, study: Study) -> Held:
    module, _, name = study.function.partition(":")
    result, error = getattr(importlib.import_module(module), name)()
    command = f"python -c 'from {module} import {name}; print({name}())'"
    return Held(world=world, command=command, column="", n=0, result=result, error=error, **_said(study))


def _said(one: ClosedForm | Study) -> dict[str, Any]:
    kept = ("name", "value", "tolerance", "why")
    return {key: value for key, value in msgspec.structs.asdict(one).items() if key in kept}
