"""What is declared before the runs: measures with their code, tests, looks with their levels."""

import datetime
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from analysis.form import form_of
from analysis.prose import joined
from analysis.signature_modules import Part
from analysis.signatures import FAILURE_RATE, Signature, describe, discover
from analysis.stats.contrasts import ALPHA
from analysis.stats.equivalence import fewest_for_same
from analysis.stats.factors import pairs
from analysis.stats.family import is_denominator, unknown_measure
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.stats.sequential import levels
from analysis.stats.sign_flip import least_p
from analysis.stats.values import seed_values
from analysis.tables.groups import group_keys, swept_columns
from analysis.tables.signature_table import KEYS, SignatureTable
from foundry.errors import InputError
from foundry.storing.preregistration import PlannedCondition, PlannedLook, PlannedMeasure, Preregistration

METHOD = (
    "Differences of the conditions are paired by seed. Two-sided exact sign-flip test of the mean (9,999 drawn signs "
    "above 16 pairs). Tests are corrected by step-down max-T over the measures of each pair of conditions, and by "
    "Holm's method over the pairs of a factor. Alpha is spent in proportion to the seeds: each test counts with the "
    "least error in all at which one of its looks so far is significant. "
    "Where a margin is given, Gaffke's bounds of the mean from both sides, with the range of the measure or the widest "
    "difference that is declared. Their alpha is spent and corrected by Holm's method."
)
LEFT_OUT = (
    "A seed whose run failed, or is missing, in either condition: it has no value there. It is counted.",
    "A seed in which the measure is undefined in either condition, such as the length of messages of who said nothing.",
    f"Tests of fewer than {FEWEST_FOR_CLAIMS} pairs, and of measures that differ in no seed.",
    "Scripted baselines, measures over readable decisions alone, and all measures not named here: they explore.",
)


def declared(
    conditions: Sequence[PlannedCondition],
    forms: Sequence[str],
    *,
    family: Sequence[str],
    margins: Mapping[str, float],
    looks: Sequence[int],
    widest: Mapping[str, float] | None = None,
    **said: Any,
) -> Preregistration:
    """Return what is declared.

    Args:
        conditions: what is compared.
        forms: of the world of each.
        family: the measures that are tested.
        margins: by measure of the family, the difference below which conditions count as the same.
        looks: seeds at each look; none is a single one at all seeds.
        widest: by measure with a margin, the difference that no seed goes beyond.
        **said: what else `Preregistration` holds of the sweep: `foundry`, `commit`, `asked`, `models`.

    Raises:
        InputError: a measure does not exist or is named twice, a margin is of another or not positive, a widest
            difference is not above its margin, looks do not fit the seeds, or there is nothing to compare.
    """
    seeds = list(dict.fromkeys(seed for one in conditions for seed in one.runs.values()))
    wanted = checked_looks(looks, len(seeds))
    _check_margins(family, margins)
    widest = widest or {}
    _check_widest(margins, widest)
    measures = _once(family)
    code = {one: code_of(one, list(dict.fromkeys(forms))) for one in measures}
    pairs = compared_pairs(conditions, forms)
    if not pairs:
        raise InputError("There are no two conditions to compare: name two models, worlds or prompts.")
    tests = Counter(factor for factor, both in pairs for own in code.values() if both <= own.keys())
    compared = Counter(factor for factor, both in pairs if any(both <= own.keys() for own in code.values()))
    if not tests:
        raise InputError(f"No two conditions to compare have {joined(measures)}: name a measure of both, or others.")
    return Preregistration(
        made=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        conditions=list(conditions),
        seeds=seeds,
        measures=[
            PlannedMeasure(name=one, margin=margins.get(one), code_sha256=own, widest=widest.get(one))
            for one, own in code.items()
        ],
        tests=dict(tests),
        pairs=dict(compared),
        method=METHOD,
        alpha=ALPHA,
        looks=_planned_looks(wanted, max(compared.values())),
        left_out=list(LEFT_OUT),
        **said,
    )


def checked_looks(looks: Sequence[int], seeds: int) -> tuple[int, ...]:
    """Return the numbers of seeds at which is looked: ascending, the last of them all seeds.

    Raises:
        InputError: they are no such numbers.
    """
    found = tuple(looks) or (seeds,)
    shown, ascending = (",".join(map(str, some)) for some in (found, sorted(set(found))))
    if shown != ascending:
        raise InputError(f"Looks at {shown} seeds do not ascend: write {ascending}.")
    if found[0] < FEWEST_FOR_CLAIMS:
        raise InputError(f"A look at {found[0]} seeds proves nothing: begin with {FEWEST_FOR_CLAIMS} or more.")
    if found[-1] != seeds:
        raise InputError(f"The last look is at {found[-1]} seeds, and {seeds} are asked for: let them be as many.")
    return found


def out_of_reach(plan: Preregistration) -> list[str]:
    """Return at which looks no test can be significant at the first step of Holm's correction, one line each."""
    return [
        f"at {one.seeds} seeds no p can be as small as {one.alpha_in_family:.2g}: it takes more seeds or fewer "
        "conditions"
        for one in plan.looks
        if least_p(one.seeds) > one.alpha_in_family
    ]


def never_the_same(plan: Preregistration) -> list[str]:
    """Return for which measures only a difference can be claimed, and what changes that, one line each."""
    lines = [line for one in plan.measures if one.margin is not None and (line := _unreachable(one, len(plan.seeds)))]
    names = [one.name for one in plan.measures if one.margin is None]
    if len(plan.looks) == 1 or not names:
        return lines
    return [
        *lines,
        f"Only a difference answers {joined(names)}: without one all {len(plan.seeds)} seeds are played. Add --margin "
        f"{names[0]}=SIZE, below which a difference counts as none.",
    ]


def _unreachable(measure: PlannedMeasure, seeds: int) -> str:
    """Return why so many seeds cannot show a measure to be the same; "" where they can."""
    runs = [form_of(form).run for form in measure.code_sha256]
    name, margin = measure.name, measure.margin or math.nan
    described = describe(name, runs[0] if len(runs) == 1 else None)
    fewest = fewest_for_same(margin, min(described.high - described.low, measure.widest or math.inf))
    if math.isnan(fewest):
        return (
            f"{name} has no range, so nothing can be said to be the same within its margin: add --widest {name}=SIZE, "
            "which no seed may go beyond."
        )
    if fewest <= seeds:
        return ""
    return (
        f"The margin {margin:g} of {name} takes {fewest:.0f} seeds, and {seeds} are asked for: ask for more, or add "
        f"--widest {name}=SIZE, which no seed may go beyond."
    )


def check_measures(names: Iterable[str], forms: Sequence[str]) -> None:
    """Refuse names of measures that no signature of these forms declares, before any run is measured.

    Counts are not declared, and neither is the rate of failures: they are known when the runs are measured.

    Raises:
        InputError: there is one; names the closest.
    """
    for name in names:
        if name != FAILURE_RATE and not is_denominator(name):
            code_of(name, forms)


def code_of(measure: str, forms: Sequence[str]) -> dict[str, str]:
    """Return the hash of the code of a measure's signature by form.

    Raises:
        InputError: no signature of these forms has the measure; names the closest.
    """
    name, _, own = measure.partition(".")
    found: dict[str, Part] = {}
    for signature in discover():
        for form in forms:
            part = signature.part(form_of(form).run)
            if signature.name == name and part is not None and _measures(signature, part, own):
                found[form] = part
    if not found:
        raise unknown_measure(measure, _known(forms))
    return {form: part.sha256 for form, part in found.items()}


def _measures(signature: Signature, part: Part, measure: str) -> bool:
    """Return whether a part of a signature has a measure, by its name or a pattern."""
    plain = measure.removesuffix("_readable") if signature.is_readable_only(measure) else measure
    patterns = (one.partition("*") for one in part.measures)
    return any(
        plain == start if not star else plain.startswith(start) and plain.endswith(end) for start, star, end in patterns
    )


def _known(forms: Sequence[str]) -> list[str]:
    runs = [form_of(form).run for form in forms]
    found = (one.part(run) for one in discover() for run in runs)
    return list(dict.fromkeys(f"{part.name}.{name}" for part in found if part is not None for name in part.measures))


def _once(family: Sequence[str]) -> Sequence[str]:
    if not family:
        raise InputError("No measure is declared: name what is tested with --family, such as clustering.largest_group.")
    twice = [name for place, name in enumerate(family) if name in family[:place]]
    if twice:
        raise InputError(f"--family {twice[0]} is given twice: name each measure once.")
    return family


def _check_margins(family: Sequence[str], margins: Mapping[str, float]) -> None:
    for name, margin in margins.items():
        if name not in family:
            raise InputError(f"--margin {name} is of no declared measure: add --family {name}.")
        if not 0 < margin < float("inf"):
            raise InputError(f"The margin of {name} is {margin:g}: give one above 0, in the unit of the measure.")


def _check_widest(margins: Mapping[str, float], widest: Mapping[str, float]) -> None:
    for name, size in widest.items():
        if name not in margins:
            raise InputError(f"--widest {name} has no margin: add --margin {name}=SIZE.")
        if not margins[name] < size < math.inf:
            raise InputError(
                f"--widest {name} is {size:g}: give one above its margin {margins[name]:g}, in the unit of the measure."
            )


def _planned_looks(looks: Sequence[int], pairs: int) -> list[PlannedLook]:
    found = levels(looks, np.array([ALPHA, ALPHA / pairs])).tolist()
    return [
        PlannedLook(seeds=n, alpha=round(alone, 8), alpha_in_family=round(strict, 8))
        for n, (alone, strict) in zip(looks, found, strict=True)
    ]


def compared_pairs(conditions: Sequence[PlannedCondition], forms: Sequence[str]) -> list[tuple[str, frozenset[str]]]:
    """Return the factor of each pair of conditions that differ in one alone, with the forms of both one's worlds."""
    factors = dict.fromkeys(key for one in conditions for key in one.factors if key not in (*KEYS, "sampling_seed"))
    rows = [
        {
            "run": next(iter(one.runs)),
            "world": one.world.name,
            "model": one.model.name,
            "prompt": one.prompt.name,
            "seed": 0,
            "status": "",
            **{key: str(one.factors.get(key)) for key in factors},
        }
        for one in conditions
    ]
    table = SignatureTable(pd.DataFrame(rows), tuple(factors), (), (frozenset(),) * len(rows))
    form = dict(zip(group_keys(swept_columns(table)), forms, strict=True))
    values = seed_values(table)
    return [
        (pair.factor, frozenset(form[values.groups[index]] for index in (pair.level, pair.reference)))
        for pair in pairs(values)
    ]
