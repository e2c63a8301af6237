"""Finds the swept settings, and the pairs of groups that differ in only one of them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import pandas as pd

from analysis.stats.values import Group, SeedValues

MODEL = "model"
_SEEDS = ("seed", "sampling_seed")


@dataclass(frozen=True)
class Factor:
    """A swept setting and its levels, in the order of their first run."""

    name: str
    levels: tuple[str, ...]


@dataclass(frozen=True)
class Pair:
    """Two groups that differ in only one factor.

    Attributes:
        reference: index of the second group, whose values are subtracted from those of the first.
        context: the other swept settings, which are equal in both groups, such as `prompt=paper`; "" if there are none.
        baseline: whether the reference is a baseline; such pairs are not tested.
    """

    factor: str
    level: int
    reference: int
    context: str
    baseline: bool = False


def find_factors(columns: Sequence[str], groups: Iterable[Group]) -> tuple[Factor, ...]:
    """Return the factors: the columns, other than seeds, in which groups differ."""
    frame = pd.DataFrame(list(groups), columns=list(columns), dtype=str)
    factors = [Factor(name, tuple(frame[name].astype(str).unique())) for name in columns if name not in _SEEDS]
    return tuple(factor for factor in factors if len(factor.levels) > 1)


def swept(values: SeedValues) -> tuple[Factor, ...]:
    """Return the factors of the groups that are not baselines."""
    groups = [group for group, baseline in zip(values.groups, values.baseline, strict=True) if not baseline]
    return find_factors(values.columns, groups)


def pairs(values: SeedValues) -> list[Pair]:
    """Return all pairs of groups that differ in only one factor; then each group with each baseline."""
    factors = swept(values)
    own = [index for index, baseline in enumerate(values.baseline) if not baseline]
    all_pairs = [pair for factor in factors for pair in _pairs_of(values, factor, factors, own)]
    return [*all_pairs, *_with_baselines(values, factors, own)]


def _pairs_of(values: SeedValues, factor: Factor, factors: Sequence[Factor], own: Sequence[int]) -> Iterator[Pair]:
    column = values.columns.index(factor.name)
    contexts: dict[Group, list[int]] = {}
    for index in own:
        contexts.setdefault(_without(values.groups[index], column), []).append(index)
    for members in contexts.values():
        ordered = sorted(members, key=lambda index: factor.levels.index(values.groups[index][column]))
        for reference, level in combinations(ordered, 2):
            yield Pair(
                factor.name, level, reference, context_of(values.columns, values.groups[level], factors, factor.name)
            )


def _with_baselines(values: SeedValues, factors: Sequence[Factor], own: Sequence[int]) -> Iterator[Pair]:
    """Yield each group with each baseline that has the same other settings, such as the same world.

    A baseline may lack a swept setting; for example, a scripted policy reads no prompt. Such a baseline is compared
    with all values of the setting.
    """
    if MODEL not in values.columns:
        return
    column = values.columns.index(MODEL)
    levels = [{values.groups[index][at] for index in own} for at in range(len(values.columns))]
    for reference, baseline in enumerate(values.baseline):
        for level in own if baseline else ():
            pair = zip(values.groups[level], values.groups[reference], levels, strict=True)
            if all(at == column or a == b or b not in swept for at, (a, b, swept) in enumerate(pair)):
                yield Pair(
                    MODEL,
                    level,
                    reference,
                    context_of(values.columns, values.groups[level], factors, MODEL),
                    baseline=True,
                )


def _without(group: Group, column: int) -> Group:
    return (*group[:column], *group[column + 1 :])


def context_of(columns: Sequence[str], group: Group, factors: Sequence[Factor], but: str) -> str:
    """Return the swept settings of a group except one, in the form `world=cafe, prompt=paper`."""
    own = dict(zip(columns, group, strict=True))
    return ", ".join(f"{factor.name}={own[factor.name]}" for factor in factors if factor.name != but)


def sides_of(columns: Sequence[str], group: Group, factors: Sequence[Factor]) -> list[tuple[str, str, str]]:
    """Return (factor, level, context) for each factor; the table of contrasts names a group by these three texts."""
    return [
        (factor.name, group[columns.index(factor.name)], context_of(columns, group, factors, factor.name))
        for factor in factors
    ]
