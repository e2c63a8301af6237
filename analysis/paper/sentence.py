"""Writes a row of the contrasts as a sentence: result, interval, number of seeds, p and limitations."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from analysis.form import FormAnalysis
from analysis.labelling import Reading
from analysis.measure import Measure
from analysis.prose import percent
from analysis.signatures import READABLE_SUFFIX, describe
from analysis.stats.contrasts import ALPHA
from analysis.stats.equivalence import fewest_for_same, most_beyond
from analysis.stats.factors import MODEL, find_factors, sides_of
from analysis.stats.intervals import ENOUGH_FOR_CLAIMS, FEWEST_FOR_CLAIMS
from analysis.stats.plan import DECLARED
from analysis.stats.testing import NOT_TESTED
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.texts import number, p_value, with_interval

DIFFERENT, SAME, NOTHING, SILENT = (
    "different",
    "equal within a margin",
    "without a difference",
    "undecided",
)
"""The results that a row of the contrasts can have."""
READABLE = "outcome.readable"
LEVEL = f"{ALPHA:g}".removeprefix("0")
_SIDES = ("factor", "level", "reference", "context")
_ROUNDING = 1e-9
_REASONS = {
    f"n < {FEWEST_FOR_CLAIMS}": f"fewer than {FEWEST_FOR_CLAIMS} seeds only describe these runs",
    "no pair": "no seed has a value for both",
    "no difference in any seed": "both are equal in every seed",
    "before the first look": "the runs of the first declared look are incomplete",
}

Row = Mapping[Any, Any]


@dataclass(frozen=True)
class Sides:
    """Facts about groups of runs, for sentences that say how two groups differ.

    Attributes:
        unread: share of unreadable decisions, by factor, level and context.
        twins: the differences over readable decisions only, by measure, factor, level, reference and context.
        runs: class of the runs by factor, level and context; it determines the titles of measures.
        words: descriptions of measures that belong to no signature, by name.
        levels: all compared levels by factor and context, including levels that were not declared.
    """

    unread: Mapping[tuple[str, str, str], float]
    twins: Mapping[tuple[str, ...], Row]
    models: frozenset[str]
    runs: Mapping[tuple[str, str, str], type]
    words: Mapping[str, Measure] = field(default_factory=dict)
    readings: Mapping[str, Reading] = field(default_factory=dict)
    levels: Mapping[tuple[str, str], frozenset[str]] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        contrasts: pd.DataFrame,
        compared: Comparison,
        forms: Mapping[Group, FormAnalysis],
        readings: Mapping[str, Reading] | None = None,
    ) -> "Sides":
        """Collect the facts from the table of contrasts, the compared groups, and the groups' forms."""
        own = [group for group in compared.groups if group not in compared.baselines]
        columns = compared.group_columns
        factors = find_factors(columns, own)
        shares = {
            group: compared.estimates[READABLE, group].mean for group in own if (READABLE, group) in compared.estimates
        }
        unread = {side: 1 - share for group, share in shares.items() for side in sides_of(columns, group, factors)}
        shown = ["measure", *_SIDES, "difference", "low", "high"]
        alone = contrasts.loc[contrasts["readable_only"].astype(bool), shown].to_dict("records")
        twins = {_key(row, str(row["measure"]).removesuffix(READABLE_SUFFIX)): row for row in alone}
        at = columns.index(MODEL) if MODEL in columns else None
        models = frozenset(group[at] for group in own) if at is not None else frozenset()
        runs = {side: forms[group].run for group in own if group in forms for side in sides_of(columns, group, factors)}
        return cls(unread, twins, models, runs, readings=readings or {}, levels=_levels(contrasts))

    def describe(self, row: Row) -> Measure:
        """Return the description of a row's measure."""
        measure = str(row["measure"])
        run = self.runs.get((row["factor"], row["level"], row["context"]))
        return self.words.get(measure) or describe(measure, run)

    def reading(self, row: Row) -> Reading:
        """Return who labelled the texts from which a row's measure is computed; empty if the measure uses no labels."""
        return self.readings.get(str(row["measure"]), Reading("", ""))

    def twin(self, row: Row) -> Row | None:
        """Return the row with the same comparison over readable decisions only; None if no such row exists."""
        return self.twins.get(_key(row, str(row["measure"])))


def _levels(contrasts: pd.DataFrame) -> dict[tuple[str, str], frozenset[str]]:
    own = contrasts.loc[~contrasts["baseline"].astype(bool), list(_SIDES)].drop_duplicates()
    return {
        (str(factor), str(context)): frozenset(rows["level"]) | frozenset(rows["reference"])
        for (factor, context), rows in own.groupby(["factor", "context"])
    }


def _key(row: Row, measure: str) -> tuple[str, ...]:
    return (measure, *(str(row[name]) for name in _SIDES))


def kind_of(row: Row) -> str:
    """Return the result of a row: DIFFERENT, SAME, NOTHING (no difference found) or SILENT (undecided)."""
    if row["significant"]:
        return DIFFERENT
    if row["equivalent"]:
        return SAME
    return SILENT if math.isnan(row["p_adjusted"]) or row["out_of_reach"] else NOTHING


def why_silent(row: Row) -> str:
    """Return why a row has no test, or why its test could not have become significant."""
    if row["out_of_reach"]:
        return str(row["out_of_reach"])
    why = str(row["test"]).removeprefix(NOT_TESTED)
    return _REASONS.get(why, why)


def sentence(row: Row, sides: Sides) -> str:
    """Return a row as a sentence, with its limitations."""
    text = {DIFFERENT: _different, SAME: _same, NOTHING: _nothing, SILENT: _silent}[kind_of(row)](row, sides)
    return "; ".join([text, *weaknesses(row, sides)]) + "."


def _different(row: Row, sides: Sides) -> str:
    said = compared_words(
        row, str(row["level"]), named(row, str(row["reference"])), higher=row["difference"] > 0, sides=sides
    )
    read = f", {reading}" if (reading := sides.reading(row).text) else ""
    return f"{said}{read}: {row['measure']} {_means(row)}, {_tested(row)}"


def compared_words(
    row: Row, level: str, others: str, *, higher: bool, sides: Sides, contexts: Mapping[str, str] | None = None
) -> str:
    """Return the difference of a row in words, such as `herd stays where it is more often than random`."""
    within = _within(row, contexts)
    doing = sides.describe(row).phrase(higher)
    if row["factor"] == MODEL:
        return f"{level} {doing} than {others}{within}"
    whose = _whose(row, sides)
    within = "" if row["context"] == f"{MODEL}={whose}" else within
    return f"With {row['factor']}={level} {whose} {doing} than with {others}{within}"


def _same(row: Row, sides: Sides) -> str:
    corrected = f"p{equals_p(row['p_equivalence_holm'])} after correction{_looks(row)} (Gaffke's bounds)"
    return (
        f"{_both(row)} differ in {row['measure']} by less than the declared margin of {number(row['margin'])}: "
        f"{_means(row)}, {corrected}"
    )


def _nothing(row: Row, sides: Sides) -> str:
    return f"{nothing_words(row, str(row['level']), str(row['reference']))}: {_means(row)}, {_tested(row)}"


def nothing_words(row: Row, first: str, second: str, contexts: Mapping[str, str] | None = None) -> str:
    """Return in words that no difference was found between the two levels of a row."""
    both = f"{named(row, first)} and {named(row, second)}{_within(row, contexts)}"
    return f"No difference was found between {both} in {row['measure']}"


def _silent(row: Row, sides: Sides) -> str:
    said = f"{_both(row)} could not be compared in {row['measure']}, because {why_silent(row)}"
    return f"{said}: {_means(row)}" if row["n_pairs"] else said


def _whose(row: Row, sides: Sides) -> str:
    """Return the name of the model with which both compared groups were run; "the model" if it is not known."""
    named = [part.removeprefix(f"{MODEL}=") for part in str(row["context"]).split(", ") if part.startswith(f"{MODEL}=")]
    named += sides.models if len(sides.models) == 1 else []
    return named[0] if named else "the model"


def _both(row: Row) -> str:
    return " and ".join(named(row, str(row[side])) for side in ("level", "reference")) + _within(row)


def named(row: Row, level: str) -> str:
    """Return the name of a level in sentences: a model's name, or `factor=level` for other factors."""
    return level if row["factor"] == MODEL else f"{row['factor']}={level}"


def _within(row: Row, contexts: Mapping[str, str] | None = None) -> str:
    context = (contexts or {}).get(str(row["context"]), str(row["context"]))
    return f" ({context})" if context else ""


def _means(row: Row) -> str:
    difference = with_interval(row["difference"], row["low"], row["high"])
    seeds = f"{row['n_pairs']} seed" + ("s" if row["n_pairs"] != 1 else "")
    return f"{number(row['mean_level'])} against {number(row['mean_reference'])}, difference {difference}, {seeds}"


def _tested(row: Row) -> str:
    family = f"after correction for {row['family']} tests" if row["family"] > 1 else "in a single test"
    return f"p{equals_p(row['p_adjusted'])} {family}{_looks(row)} (level {LEVEL})"


def _looks(row: Row) -> str:
    return f" and {row['look']} looks" if row["claim"] == DECLARED and row["look"] > 1 else ""


def equals_p(p: float) -> str:
    """Return a p value as text, with an equals or a less-than sign: ` = .04` or ` < .001`."""
    text = p_value(p)
    return f" {text[0]} {text[1:]}" if text.startswith("<") else f" = {text}"


def weaknesses(row: Row, sides: Sides) -> Iterator[str]:
    """Yield phrases that limit the result of a row, such as "the interval goes beyond the margin"."""
    kind, has_margin = kind_of(row), not math.isnan(row["margin"])
    if kind != DIFFERENT and (reading := sides.reading(row).text):
        yield reading
    if kind == DIFFERENT and row["equivalent"]:
        yield f"the difference is within the declared margin of {number(row['margin'])}, so it is too small to matter"
    if row["equivalent"] and max(-row["low"], row["high"]) > row["margin"]:
        yield "the interval goes beyond the margin"
    if (kind == NOTHING or row["out_of_reach"]) and row["p"] <= ALPHA and (row["low"] > 0 or row["high"] < 0):
        yield "the uncorrected interval of the difference excludes 0"
    if kind in (NOTHING, SILENT) and row["n_pairs"] and has_margin:
        yield _not_the_same(row)
    if kind == NOTHING and row["n_pairs"] < ENOUGH_FOR_CLAIMS:
        yield f"with fewer than {ENOUGH_FOR_CLAIMS} seeds, only large differences can be detected"
    if kind != SILENT or (has_margin and not row["out_of_reach"]):
        yield from filter(None, [str(row["note"]), _missing(row)])
    yield from _unread(row, sides)


def _missing(row: Row) -> str:
    """Return, in words, how much the missing seeds could change the difference; "" if no seed is missing."""
    if not row["n_missing"]:
        return ""
    if math.isnan(row["bound_low"]):
        return "the values of the measure have no limits, so missing seeds could change the difference by any amount"
    whole = f"if the missing seeds had values, the difference could be from {number(row['bound_low'])} to "
    turned = kind_of(row) == DIFFERENT and row["bound_low"] <= 0 <= row["bound_high"]
    return whole + number(row["bound_high"]) + (", so they could reverse the result" if turned else "")


def _not_the_same(row: Row) -> str:
    """Return, in words, in how many seeds the difference is within the margin, and how equality could be shown."""
    n, within, margin = int(row["n_pairs"]), int(row["n_within"]), number(row["margin"])
    share = f"with 95 % confidence, up to {100 * most_beyond(within, n):.0f} % of all possible seeds differ by more"
    cases = f"all {n}" if within == n else f"{within} of {n}"
    fewest = fewest_for_same(row["margin"], row["widest"])
    if math.isnan(fewest):
        needs = "to show equality, declare a widest difference, because the values of the measure have no limits"
    elif n < fewest:
        needs = f"to show equality, use at least {fewest:.0f} seeds"
    else:
        needs = "the test does not show that the means are equal"
    return f"in {cases} seeds the difference is at most {margin}, but {share}; {needs}"


def _unread(row: Row, sides: Sides) -> Iterator[str]:
    shares = {
        str(row[name]): sides.unread.get((row["factor"], row[name], row["context"]), 0.0)
        for name in ("level", "reference")
    }
    for name, share in shares.items():
        if share > _ROUNDING:
            yield f"{percent(share)} of the decisions of {named(row, name)} were unreadable"
    twin = sides.twin(row)
    if any(share > _ROUNDING for share in shares.values()) and twin is not None and kind_of(row) == DIFFERENT:
        held = twin["low"] > 0 if row["difference"] > 0 else twin["high"] < 0
        if not held:
            difference = with_interval(twin["difference"], twin["low"], twin["high"])
            yield f"if only readable decisions count, the difference is {difference}"
