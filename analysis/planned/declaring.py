"""Makes the declaration before the runs: measures and their code, tests, and the level of the test at each look."""

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
    "Differences of the conditions are paired by seed. Two-sided exact sign-flip test of the mean (9,999 random "
    "signs above 16 pairs). Tests are corrected by step-down max-T over the measures of each pair of conditions, and "
    "by Holm's method over the pairs of a factor. Alpha is spent in proportion to the seeds: each test counts with "
    "the smallest overall error at which one of its looks so far is significant. For measures with a margin, "
    "Gaffke's bounds of the mean from both sides, with the range of the measure or the declared widest difference. "
    "Their alpha is spent and corrected by Holm's method."
)
LEFT_OUT = (
    "A seed whose run failed or is missing in either condition: it has no value there. It is counted.",
    "A seed for which the measure is undefined in either condition, such as the length of messages of a silent agent.",
    f"Tests of fewer than {FEWEST_FOR_CLAIMS} pairs, and of measures that are equal in every seed.",
    "Scripted baselines, measures over readable decisions only, and all measures not named here: they are exploratory.",
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
    """Return the preregistration of a sweep.

    Args:
        conditions: the compared conditions.
        forms: form of each condition's world.
        family: tested measures.
        margins: by measure, the difference below which conditions count as equal.
        looks: number of seeds at each look; by default a single look at all seeds.
        widest: by measure with a margin, the largest difference that any seed can have.
        **said: further fields of `Preregistration`: `foundry`, `commit`, `asked`, `models`.

    Raises:
        InputError: a measure does not exist or is named twice. A margin is not positive, or for a measure that is not
            declared. A widest difference is not above its margin. The looks do not fit the seeds. No two conditions
            can be compared.
    """
    seeds = list(dict.fromkeys(seed for condition in conditions for seed in condition.runs.values()))
    wanted = checked_looks(looks, len(seeds))
    _check_margins(family, margins)
    widest = widest or {}
    _check_widest(margins, widest)
    measures = _once(family)
    code = {measure: code_of(measure, list(dict.fromkeys(forms))) for measure in measures}
    pairs = compared_pairs(conditions, forms)
    if not pairs:
        raise InputError("There are no two conditions to compare: name two models, worlds or prompts.")
    tests = Counter(factor for factor, both in pairs for own in code.values() if both <= own.keys())
    compared = Counter(factor for factor, both in pairs if any(both <= own.keys() for own in code.values()))
    if not tests:
        raise InputError(
            f"No two conditions to compare have {joined(measures)}: name measures that two conditions share."
        )
    return Preregistration(
        made=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        conditions=list(conditions),
        seeds=seeds,
        measures=[
            PlannedMeasure(name=part_name, margin=margins.get(part_name), code_sha256=own, widest=widest.get(part_name))
            for part_name, own in code.items()
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
    """Return the number of seeds at each look, ascending; the last look has all seeds.

    Raises:
        InputError: the numbers do not ascend, begin too low, or do not end with all seeds.
    """
    planned = tuple(looks) or (seeds,)
    shown, ascending = (",".join(map(str, some)) for some in (planned, sorted(set(planned))))
    if shown != ascending:
        raise InputError(f"Looks at {shown} seeds must ascend: use {ascending}.")
    if planned[0] < FEWEST_FOR_CLAIMS:
        raise InputError(f"A look at {planned[0]} seeds cannot test anything: begin with {FEWEST_FOR_CLAIMS} or more.")
    if planned[-1] != seeds:
        raise InputError(f"The last look is at {planned[-1]} seeds, but the sweep has {seeds}: make them equal.")
    return planned


def out_of_reach(plan: Preregistration) -> list[str]:
    """Return a line for each look with too few seeds: no p value can be low enough for Holm's correction."""
    return [
        f"with {look.seeds} seeds, no p value can be as low as {look.alpha_in_family:.2g}: use more seeds or "
        "fewer conditions"
        for look in plan.looks
        if least_p(look.seeds) > look.alpha_in_family
    ]


def never_the_same(plan: Preregistration) -> list[str]:
    """Return a line for each measure whose equality cannot be shown, with the remedy."""
    lines = [
        line
        for measure in plan.measures
        if measure.margin is not None and (line := _unreachable(measure, len(plan.seeds)))
    ]
    names = [measure.name for measure in plan.measures if measure.margin is None]
    if len(plan.looks) == 1 or not names:
        return lines
    return [
        *lines,
        f"For {joined(names)}, only a difference ends the sweep early; else all {len(plan.seeds)} seeds are run. "
        f"Add --margin {names[0]}=SIZE, the difference below which conditions count as the same.",
    ]


def _unreachable(measure: PlannedMeasure, seeds: int) -> str:
    """Return the reason why this number of seeds cannot show equality of a measure, or ""."""
    runs = [form_of(form).run for form in measure.code_sha256]
    name, margin = measure.name, measure.margin or math.nan
    described = describe(name, runs[0] if len(runs) == 1 else None)
    fewest = fewest_for_same(margin, min(described.high - described.low, measure.widest or math.inf))
    if math.isnan(fewest):
        return (
            f"The values of {name} have no limits, so equality within its margin cannot be shown: add --widest "
            f"{name}=SIZE, the largest difference that any seed can have."
        )
    if fewest <= seeds:
        return ""
    return (
        f"The margin {margin:g} of {name} needs {fewest:.0f} seeds, but the sweep has {seeds}: use more seeds, or "
        f"add --widest {name}=SIZE, the largest difference that any seed can have."
    )


def check_measures(names: Iterable[str], forms: Sequence[str]) -> None:
    """Raise an InputError if no signature of the given forms declares a measure.

    Counts and the failure rate are accepted, although signatures do not declare them.
    """
    for name in names:
        if name != FAILURE_RATE and not is_denominator(name):
            code_of(name, forms)


def code_of(measure: str, forms: Sequence[str]) -> dict[str, str]:
    """Return, by form, the hash of the code that computes a measure.

    Raises:
        InputError: no signature of these forms has the measure.
    """
    name, _, own = measure.partition(".")
    parts: dict[str, Part] = {}
    for signature in discover():
        for form in forms:
            part = signature.part(form_of(form).run)
            if signature.name == name and part is not None and _measures(signature, part, own):
                parts[form] = part
    if not parts:
        raise unknown_measure(measure, _known(forms))
    return {form: part.sha256 for form, part in parts.items()}


def _measures(signature: Signature, part: Part, measure: str) -> bool:
    plain = measure.removesuffix("_readable") if signature.is_readable_only(measure) else measure
    patterns = (measure.partition("*") for measure in part.measures)
    return any(
        plain == start if not star else plain.startswith(start) and plain.endswith(end) for start, star, end in patterns
    )


def _known(forms: Sequence[str]) -> list[str]:
    runs = [form_of(form).run for form in forms]
    parts = (signature.part(run) for signature in discover() for run in runs)
    return list(dict.fromkeys(f"{part.name}.{name}" for part in parts if part is not None for name in part.measures))


def _once(family: Sequence[str]) -> Sequence[str]:
    if not family:
        raise InputError(
            "No measure is declared: name the measures to test with --family, such as clustering.largest_group."
        )
    twice = [name for place, name in enumerate(family) if name in family[:place]]
    if twice:
        raise InputError(f"--family {twice[0]} is given twice: name each measure once.")
    return family


def _check_margins(family: Sequence[str], margins: Mapping[str, float]) -> None:
    for name, margin in margins.items():
        if name not in family:
            raise InputError(f"--margin {name} is not a declared measure: add --family {name}.")
        if not 0 < margin < float("inf"):
            raise InputError(f"The margin of {name} is {margin:g}: use a value above 0, in the unit of the measure.")


def _check_widest(margins: Mapping[str, float], widest: Mapping[str, float]) -> None:
    for name, size in widest.items():
        if name not in margins:
            raise InputError(f"--widest {name} has no margin: add --margin {name}=SIZE.")
        if not margins[name] < size < math.inf:
            raise InputError(
                f"--widest {name} is {size:g}: use a value above its margin {margins[name]:g}, in the unit of the "
                "measure."
            )


def _planned_looks(looks: Sequence[int], pairs: int) -> list[PlannedLook]:
    rows = levels(looks, np.array([ALPHA, ALPHA / pairs])).tolist()
    return [
        PlannedLook(seeds=n, alpha=round(alone, 8), alpha_in_family=round(strict, 8))
        for n, (alone, strict) in zip(looks, rows, strict=True)
    ]


def compared_pairs(conditions: Sequence[PlannedCondition], forms: Sequence[str]) -> list[tuple[str, frozenset[str]]]:
    """Return, for each pair of conditions that differ in only one factor, this factor and the forms of both worlds."""
    factors = dict.fromkeys(
        key for condition in conditions for key in condition.factors if key not in (*KEYS, "sampling_seed")
    )
    rows = [
        {
            "run": next(iter(condition.runs)),
            "world": condition.world.name,
            "model": condition.model.name,
            "prompt": condition.prompt.name,
            "seed": 0,
            "status": "",
            **{key: str(condition.factors.get(key)) for key in factors},
        }
        for condition in conditions
    ]
    table = SignatureTable(pd.DataFrame(rows), tuple(factors), (), (frozenset(),) * len(rows))
    form = dict(zip(group_keys(swept_columns(table)), forms, strict=True))
    values = seed_values(table)
    return [
        (pair.factor, frozenset(form[values.groups[index]] for index in (pair.level, pair.reference)))
        for pair in pairs(values)
    ]
