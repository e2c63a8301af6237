"""The summary in words: the sentences that are right for rows of contrasts, and for sweeps whose truth is known."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pytest

from analysis.findings.ranking import findings
from analysis.paper.summary import MOST, summary
from analysis.signatures import describe, discover
from analysis.stats.contrasts import COLUMNS, contrasts
from analysis.stats.family import NO_BEHAVIOUR
from analysis.stats.plan import Plan
from analysis.tables.comparison import compare
from analysis.tables.groups import swept_columns
from signature_tables import MEASURE, runs, table

NAN = math.nan
REACH = "warning.social_reach"
USUAL = {
    "measure": REACH, "signature": "warning", "headline": True, "readable_only": False, "baseline": False,
    "factor": "model", "level": "b", "reference": "a", "context": "", "n_pairs": 20, "n_missing": 0, "n_undefined": 0,
    "mean_level": 0.43, "mean_reference": 0.21, "difference": 0.22, "low": 0.1, "high": 0.34, "interval": "t",
    "test": "sign-flip", "p": 0.0013, "claim": "declared", "look": 1, "alpha": 0.05, "p_adjusted": 0.004, "family": 3,
    "significant": True, "p_bh": NAN, "g_z": 1.0, "superiority": 0.9, "bound_low": NAN, "bound_high": NAN,
    "margin": NAN, "widest": NAN, "n_within": 0, "p_equivalence": NAN, "p_equivalence_holm": NAN, "equivalent": False,
    "out_of_reach": "", "note": "",
}  # fmt: skip
"""A row of the contrasts of which nothing is to be said but what was found."""
FOUND = f"b warns its neighbours more than a: {REACH} 0.43 against 0.21, difference 0.22 [0.1, 0.34], 20 seeds, "
TESTED = "p = .004 after correction for 3 tests (level .05)"
NONE = {"mean_level": 0.23, "difference": 0.02, "low": -0.1, "high": 0.14, "p_adjusted": 0.8, "significant": False}
NONE_FOUND = f"No difference was found between b and a in {REACH}: 0.23 against 0.21, difference 0.02 [-0.1, 0.14], "
NONE_TESTED = "p = .800 after correction for 3 tests (level .05)"
FLAT = {"p": NAN, "p_adjusted": NAN, "significant": False}
LEFT = {**NONE, **FLAT}
GAP = "0.23 against 0.21, difference 0.02 [-0.1, 0.14]"
SILENT = f"b and a could not be compared in {REACH}, because "
MARGIN = {"margin": 0.2, "p_equivalence_holm": 0.01, "equivalent": True}
SAME = f"b and a differ in {REACH} by less than the declared margin of 0.2: 0.23 against 0.21, "
MISSING = {"n_missing": 2, "note": "missing in 2 of 22 seeds"}
OPEN = {"claim": "exploratory"}
EXPLORES = "Nothing was declared before the runs, so all findings are exploratory."


def row(**changes: Any) -> dict[str, Any]:
    return {**USUAL, **changes}


def differing(count: int, **changes: Any) -> list[dict[str, Any]]:
    """Return rows of so many measures that differ."""
    return [row(measure=f"own.x{number}", **changes) for number in range(count)]


def groups(*read: float, **more: Any):
    """Return groups a, b, ... of which these shares of decisions could be read."""
    names = "abcdefgh"[: len(read)]
    made = [run for name, share in zip(names, read, strict=True) for run in runs(name, [share] * 6, "outcome.readable")]
    return compare(table([{**one, **more} for one in made]))


def said(*rows: dict[str, Any], compared: Any = None, **options: Any) -> tuple[str, ...]:
    return summary(pd.DataFrame(rows, columns=list(COLUMNS)), compared or groups(1, 1), **options)


@pytest.mark.parametrize(
    ("changes", "right"),
    [
        ({}, FOUND + TESTED),
        ({"look": 3}, FOUND + "p = .004 after correction for 3 tests and 3 looks (level .05)"),
        (
            {**MISSING, "bound_low": 0.11, "bound_high": 0.29},
            f"{FOUND}{TESTED}; missing in 2 of 22 seeds; if the missing seeds had values, the difference could be "
            "from 0.11 to 0.29",
        ),
        (
            {**NONE, **MISSING},
            f"{NONE_FOUND}20 seeds, {NONE_TESTED}; missing in 2 of 22 seeds; the values of the measure have no limits, "
            "so missing seeds could change the difference by any amount",
        ),
        ({"margin": 0.1}, FOUND + TESTED),
        (
            {"measure": "warning.depth"},
            FOUND.replace("warns its neighbours more", "has a higher value of 'Longest chain of warnings'").replace(
                REACH, "warning.depth"
            )
            + TESTED,
        ),
        (
            {"measure": "place_choice.share_cafe", "difference": -0.22, "low": -0.34, "high": -0.1},
            "b spends less time in cafe than a: place_choice.share_cafe 0.43 against 0.21, difference -0.22 "
            f"[-0.34, -0.1], 20 seeds, {TESTED}",
        ),
        (NONE, f"{NONE_FOUND}20 seeds, {NONE_TESTED}"),
        (
            {**NONE, "low": 0.01},
            f"{NONE_FOUND.replace('[-0.1', '[0.01')}20 seeds, {NONE_TESTED}; the uncorrected interval of the "
            "difference excludes 0",
        ),
        (
            {**NONE, "n_pairs": 30, "margin": 0.1, "widest": 1.0, "n_within": 29},
            f"{NONE_FOUND}30 seeds, {NONE_TESTED}; in 29 of 30 seeds the difference is at most 0.1, but with 95 % "
            "confidence, up to 15 % of all possible seeds differ by more; the "
            "test does not show that the means are equal",
        ),
        (
            {**NONE, "factor": "world.agents", "level": "20", "reference": "10"},
            f"{NONE_FOUND}20 seeds, {NONE_TESTED}".replace("b and a", "world.agents=20 and world.agents=10"),
        ),
        (
            {**NONE, **MARGIN},
            f"{SAME}difference 0.02 [-0.1, 0.14], 20 seeds, p = .010 after correction (Gaffke's bounds)",
        ),
        (
            {**NONE, **MARGIN, "look": 3, "high": 0.24},
            f"{SAME}difference 0.02 [-0.1, 0.24], 20 seeds, p = .010 after correction and 3 looks (Gaffke's bounds)"
            "; the interval goes beyond the margin",
        ),
        (
            {**MARGIN, "low": 0.01, "high": 0.43},
            f"{FOUND.replace('[0.1, 0.34]', '[0.01, 0.43]')}{TESTED}; the difference is within the "
            "declared margin of 0.2, so it is too small to matter; the interval goes beyond the margin",
        ),
        ({**LEFT, "n_pairs": 0, "test": "not tested: no pair"}, f"{SILENT}no seed has a value for both"),
        (
            {**LEFT, "look": 0, "test": "not tested: before the first look"},
            f"{SILENT}the runs of the first declared look are incomplete: {GAP}, 20 seeds",
        ),
    ],
)
def test_a_declared_row_is_said_in_the_sentence_that_is_right_for_it(changes: dict[str, Any], right: str):
    assert said(row(**changes)) == (f"{right}.",)


UNREAD = "; 2 % of the decisions of b were unreadable"
TWIN = {"measure": f"{REACH}_readable", "readable_only": True, "headline": False}


@pytest.mark.parametrize(
    ("rows", "shares", "right"),
    [
        ([row()], (1, 0.98), f"{FOUND}{TESTED}{UNREAD}"),
        ([row()], (1, 0.9999), f"{FOUND}{TESTED}; <0.1 % of the decisions of b were unreadable"),
        ([row(**NONE)], (1, 0.98), f"{NONE_FOUND}20 seeds, {NONE_TESTED}{UNREAD}"),
        (
            [row(), row(**TWIN, difference=0.05, low=-0.02, high=0.12)],
            (1, 0.98),
            f"{FOUND}{TESTED}{UNREAD}; if only readable decisions count, the difference is 0.05 [-0.02, 0.12]",
        ),
        (
            [row(), row(**TWIN, difference=-0.05, low=-0.08, high=-0.02)],
            (1, 0.98),
            f"{FOUND}{TESTED}{UNREAD}; if only readable decisions count, the difference is -0.05 [-0.08, -0.02]",
        ),
        ([row(), row(**TWIN, low=-0.02)], (1, 1), FOUND + TESTED),
    ],
)
def test_decisions_that_could_not_be_read_weaken_a_sentence(
    rows: list[dict[str, Any]], shares: tuple[float, ...], right: str
):
    assert said(*rows, compared=groups(*shares)) == (f"{right}.",)


@pytest.mark.parametrize(
    ("rows", "options", "right"),
    [
        ([row(**OPEN)], {}, (EXPLORES, f"{FOUND}{TESTED}.")),
        (
            [row(**OPEN)],
            {"planned": True},
            ("No comparison follows the preregistration, so all findings are exploratory.", f"{FOUND}{TESTED}."),
        ),
        ([row(), row(**OPEN, level="c")], {"planned": True}, (f"{FOUND}{TESTED}.",)),
        ([row(), row(level="c", headline=False)], {}, (f"{FOUND}{TESTED}.",)),
        ([row(), row(level="c", headline=False, baseline=True)], {}, (f"{FOUND}{TESTED}.",)),
        (
            [row()],
            {"filtered": "without prompt=x: 20 of 40 runs"},
            (
                "These findings are based on only a part of the runs: without prompt=x: 20 of 40 runs.",
                f"{FOUND}{TESTED}.",
            ),
        ),
        ([row(**NONE), row()], {}, (f"{FOUND}{TESTED}.", f"{NONE_FOUND}20 seeds, {NONE_TESTED}.")),
        (
            [row(**LEFT, test="not tested: n < 6", n_pairs=3)] * 2 + [row(**LEFT, test="not tested: no pair")],
            {},
            (
                "3 comparisons could not be decided, 2 because fewer than 6 seeds only describe these runs and 1 "
                "because no seed has a value for both.",
            ),
        ),
        (
            [],
            {"compared": groups(1)},
            ("Nothing is compared, because a is the only group. Differences from baselines are not tested.",),
        ),
        (
            [],
            {"compared": groups(1, 1)},
            ("Nothing is compared: no two groups differ in only one setting and share a declared measure.",),
        ),
    ],
)
def test_what_is_no_claim_is_left_out_or_said_to_be_none(
    rows: list[dict[str, Any]], options: dict[str, Any], right: tuple[str, ...]
):
    assert said(*rows, **options) == right


@pytest.mark.parametrize(
    ("rows", "last"),
    [
        (differing(14), "Further comparisons are in contrasts.md: 3 findings."),
        (
            [*differing(12), *[row(**NONE)] * 2, row(**LEFT)],
            "Further comparisons are in contrasts.md: 1 finding, 2 without a difference and 1 undecided.",
        ),
        ([row(**{**NONE, **MARGIN})] * 13, "Further comparisons are in contrasts.md: 2 equal within a margin."),
        ([row(**NONE)] * 12, f"{NONE_FOUND}20 seeds, {NONE_TESTED}."),
    ],
)
def test_there_are_at_most_twelve_sentences_and_the_last_counts_what_is_left_out(rows: list[dict[str, Any]], last: str):
    texts = said(*rows)
    assert (len(texts), texts[-1]) == (MOST, last)


def test_a_filter_and_what_explores_take_sentences_of_the_twelve():
    texts = said(*differing(15, **OPEN), filtered="seed=0-9: 20 of 40 runs")
    assert len(texts) == MOST
    assert texts[-1] == "Further comparisons are in contrasts.md: 6 findings."


def test_the_largest_standardised_differences_come_first():
    first, second, third = (row(measure=f"own.{name}", g_z=g_z) for name, g_z in (("x", 1.2), ("y", NAN), ("z", -3.0)))
    texts = said({**first, "p_adjusted": 0.001}, second, third)
    assert [sentence.split("own.")[1][0] for sentence in texts] == ["y", "z", "x"], "y is the same in every seed"


def test_several_pairs_of_a_measure_are_one_finding():
    """Of a, b and c: c warns more than both, which differ too."""
    rows = [
        row(),
        row(level="c", mean_level=0.9, difference=0.69, low=0.6, high=0.78, p_adjusted=0.02, note="its clock stood"),
        row(level="c", reference="b", mean_level=0.9, mean_reference=0.43, difference=0.47, low=0.4, high=0.54),
    ]
    assert said(*rows) == (
        f"c warns its neighbours more than every other model: {REACH} 0.9 against 0.21 to 0.43, smallest difference "
        "0.47 [0.4, 0.54], 20 seeds, p at most .020 corrected for 3 tests; its clock stood; "
        "1 further pair also differs.",
    )
    apart = said(*rows[:2], row(level="c", reference="b", **NONE))
    assert apart[0].startswith(f"a warns its neighbours less than every other model: {REACH} 0.21 against 0.43 to 0.9")
    assert apart[1].startswith("No difference was found between c and b")


def test_a_model_that_the_plan_does_not_name_is_no_part_of_every_other_model():
    """The model d was added after the plan: it may warn more than c, and nobody declared a test."""
    ends = {"mean_level": 0.43, "mean_reference": 0.9, "difference": -0.47, "low": -0.54, "high": -0.4}
    declared = [
        row(
            level="c",
            mean_level=0.9,
            difference=0.69,
            low=0.6,
            high=0.78,
            note="over all 9 seeds the difference is 0.7",
        ),
        row(level="b", reference="c", **ends, note="over all 9 seeds the difference is -0.5"),
    ]
    added = row(level="d", reference="c", mean_reference=0.9, mean_level=0.95, **OPEN, headline=False, **FLAT)
    assert said(*declared, added)[0] == (
        f"c warns its neighbours more than a and b: {REACH} 0.9 against 0.21 to 0.43, smallest difference "
        "0.47 [0.4, 0.54], 20 seeds, p at most .004 corrected for 3 tests; c - a: over all 9 seeds the difference is "
        "0.7; b - c: over all 9 seeds the difference is -0.5."
    )
    assert said(*declared)[0].startswith("c warns its neighbours more than every other model: ")
    assert findings(declared)[0].note == "b - c: over all 9 seeds the difference is -0.5"


def test_sentences_hold_for_tables_that_are_made_from_runs():
    low, high = [0.1, 0.2, 0.15, 0.12, 0.18, 0.11, 0.14, 0.16], [0.5, 0.7, 0.6, 0.55, 0.65, 0.52, 0.58, 0.66]
    arms = (("a", low, "x"), ("b", high, "x"), ("a", low, "y"), ("b", low, "y"))
    made = [run for model, values, prompt in arms for run in runs(model, values, prompt=prompt)]
    found = table([{**one, "outcome.readable": 0.5 if one["model"] == "b" else 1.0} for one in made])
    columns = swept_columns(found)
    sentences = summary(contrasts(found, columns, family=["idle_rate.chosen"]), compare(found, columns))
    assert sentences[1] == (
        "b stays where it is more often than a (prompt=x): idle_rate.chosen 0.595 against 0.145, difference 0.45 "
        "[0.417, 0.485], 8 seeds, p = .008 in a single test (level .05); 50 % of the decisions of b were "
        "unreadable."
    )
    assert sentences[-1] == "2 comparisons could not be decided, because both are equal in every seed."


def test_every_measure_that_claims_rest_on_is_said_in_words():
    mute = {
        f"{signature.name}.{part.headline[0]}"
        for signature in discover()
        for part in signature.parts
        if signature.name not in NO_BEHAVIOUR and not describe(f"{signature.name}.{part.headline[0]}").says
    }
    assert mute == set()


UNBOUNDED = "path.made_up"
MORE, LESS, NOTHING, ALIKE = (
    "stays where it is more often",
    "stays where it is less often",
    "No difference",
    "by less than the declared margin",
)
WITHIN_TENTH = {"margins": {MEASURE: 0.1}}


def noise(n: int, seed: int = 0, spread: float = 0.02) -> np.ndarray:
    return np.random.default_rng([n, seed]).normal(0, spread, size=n)


def two(differences: Sequence[float], measure: str = MEASURE, **more: object) -> list[dict[str, Any]]:
    """Return runs of a model a at 0.3 and of a model b that differs from it by this in each seed."""
    return [*runs("a", [0.3] * len(differences), measure, **more), *_beside(differences, measure, **more)]


def _beside(differences: Sequence[float], measure: str, **more: object) -> list[dict[str, Any]]:
    made = runs("b", [0.3 + difference for difference in differences], measure, **more)
    return [one for one, difference in zip(made, differences, strict=True) if not math.isinf(difference)]


def many(*means: float, n: int) -> list[dict[str, Any]]:
    """Return runs of models a, b, ... around these means."""
    return [run for at, mean in enumerate(means) for run in runs("abcdefgh"[at], (mean + noise(n, at)).tolist())]


def planned(looks: Sequence[int], reached: int, measure: str = MEASURE, **more: Any) -> dict[str, Any]:
    groups = frozenset({("a",), ("b",)})
    return {"plan": Plan((measure,), groups, tuple(looks), tuple(range(looks[-1])), reached, **more)}


GONE = math.inf
"""Marks a seed of b whose run is missing."""
HALF = [0.1, -0.1] * 5
TURNED = [0.4, 0.41, 0.39, 0.42, 0.38, 0.4, 0.43, 0.37, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3]

CASES: dict[str, tuple[list[dict[str, Any]], Mapping[str, Any], Sequence[str], Sequence[str]]] = {
    "b is higher": (many(0.2, 0.5, n=8), {}, [f"b {MORE} than a", "8 seeds"], [NOTHING, ALIKE, LESS]),
    "signs are half and half": (two(HALF), {}, [NOTHING, "only large differences"], [MORE, LESS, ALIKE]),
    "6 seeds that agree are enough": (two([0.1, 0.2, 0.1, 0.3, 0.2, 0.1]), {}, [MORE, "p = .031"], [NOTHING]),
    "6 seeds with one tie are not": (two([0.1, 0.2, 0.1, 0.3, 0.2, 0]), {}, [NOTHING, "p = .062"], [MORE]),
    "5 seeds only describe": (two([0.3] * 4 + [0.2]), {}, ["fewer than 6 seeds only describe"], [MORE, NOTHING, ALIKE]),
    "4 of 10 seeds differ, 6 tie": (two([0.1, 0.2, 0.3, 0.1] + [0] * 6), {}, [NOTHING, "[0, "], [MORE]),
    "a constant difference has no interval": (two([0.2] * 10), {}, [MORE, "difference 0.2, 10 seeds"], ["["]),
    "an outlier against all others": (two([0.01] * 9 + [-0.3]), {}, [NOTHING], [MORE, LESS]),
    "equal in every seed": (two([0.0] * 10), {}, ["both are equal in every seed"], [ALIKE, NOTHING, MORE]),
    "equal in 10 seeds, with a margin": (
        two([0.0] * 10), WITHIN_TENTH, ["in all 10 seeds the difference is at most", "use at least 29 seeds"], [ALIKE],
    ),
    "equal in 29 seeds, with a margin": (two([0.0] * 29), WITHIN_TENTH, [ALIKE], ["seeds differ by more"]),
    "fails in one seed of 10": (two([0.0] * 9 + [0.7]), WITHIN_TENTH, ["in 9 of 10 seeds", "up to 39 %"], [ALIKE]),
    "small but sure": (
        two((0.02 + noise(60, spread=0.01)).tolist()), WITHIN_TENTH, [MORE, "so it is too small to matter"], [NOTHING],
    ),
    "no range": (
        two([0.01, -0.01] * 20, UNBOUNDED), {"margins": {UNBOUNDED: 0.1}, "family": [UNBOUNDED]},
        ["in all 40 seeds the difference is at most 0.1", "because the values of the measure have no limits"], [ALIKE],
    ),
    "half of the runs are missing": (
        two([0.1, 0.2, 0.15, 0.1, 0.3, 0.1, *[GONE] * 6]), {},
        [MORE, "6 seeds", "missing in 6 of 12 seeds", "from -0.0708 to 0.429, so they could reverse the result"], [],
    ),
    "undefined in two seeds": (two([*[0.3] * 8, NAN, NAN]), {}, [MORE, "undefined in 2 of 10"], ["missing"]),
    "one model of three differs": (
        many(0.2, 0.2, 0.6, n=10), {},
        [f"c {MORE} than every other model", f"{NOTHING} was found between b and a"], [LESS],
    ),
    "6 seeds are too few for three models": (
        many(0.1, 0.4, 0.8, n=6), {}, ["with 6 seeds, no p value can be as low as 0.05 after"
        " correction for 3 pairs"], [MORE, NOTHING, ALIKE],
    ),
    "9 seeds are enough for five models": (
        many(0.1, 0.3, 0.5, 0.7, 0.9, n=9), {},
        [f"e {MORE} than every other model", "6 further pairs also differ"], [NOTHING],
    ),
    "worlds disagree": (
        two((0.2 + noise(10)).tolist(), world="v") + two((noise(10) - 0.2).tolist(), world="w"), {},
        [f"b {MORE} than a (world=v)", f"b {LESS} than a (world=w)"], [],
    ),
    "prompts of one model": (
        [*runs("a", [0.3] * 8, prompt="x"), *runs("a", (0.6 + noise(8)).tolist(), prompt="y")], {},
        [f"With prompt=y a {MORE} than with prompt=x"], [LESS],
    ),
    "before the first look": (two([0.3] * 7), planned((8, 18), 0), ["first declared look are incomplete"], [MORE]),
    "decided at a look, turned later": (
        two(TURNED), planned((8, 18), 2),
        [f"b {MORE} than a", "0.4 [0.383, 0.417], 8 seeds", "over all 18 seeds the difference is 0.0111"], [LESS],
    ),
    "seeds beyond the last look": (
        two(HALF + [0.6] * 10), planned((10,), 1), [NOTHING, "10 seeds", "over all 20 seeds"], [MORE],
    ),
    "8 seeds within a declared widest difference": (
        two([0.0] * 8), planned((8,), 1, margins={MEASURE: 0.1}, widest={MEASURE: 0.3}), [ALIKE], [],
    ),
    "a later seed goes beyond the widest difference": (
        two([0.0] * 8 + [0.4]), planned((8,), 1, margins={MEASURE: 0.1}, widest={MEASURE: 0.3}),
        ["one seed differs by 0.4, more than --widest 0.3"], [ALIKE],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("made", "options", "says", "never"), CASES.values(), ids=CASES.keys())
def test_a_sweep_of_known_truth_is_told_as_it_is(
    made: list[dict[str, Any]], options: Mapping[str, Any], says: Sequence[str], never: Sequence[str]
):
    found = table(made)
    columns = swept_columns(found)
    rows = contrasts(found, columns, **options)
    sentences = summary(rows, compare(found, columns), planned="plan" in options)
    text = " ".join(sentence for sentence in sentences if "all findings are exploratory" not in sentence)
    assert [part for part in says if part not in text] == [], text
    assert [part for part in never if part in text] == [], text
    claimed = rows[rows["significant"]]
    excluded = (claimed["low"] > 0) | (claimed["high"] < 0) | claimed["low"].isna()
    assert excluded.all(), "a claim stands beside an interval that holds 0"
