"""What can be declared before the runs, and what a sweep can find."""

import math
from dataclasses import replace

import numpy as np
import pytest

from analysis.planned.declaring import code_of, declared, never_the_same, out_of_reach
from analysis.planned.reach import CHANCE, reach_of, sure_effect
from analysis.signatures import discover
from analysis.stats.max_t import step_down_p
from analysis.stats.sequential import levels
from foundry.errors import InputError
from planning import LOOKS, MEASURES, condition, plan


def test_a_plan_holds_looks_with_their_levels_alone_and_in_the_family():
    made = plan("abc")
    assert made.tests == {"model": 6} and made.pairs == {"model": 3}
    with pytest.raises(InputError, match="no two conditions"):
        plan("a")
    assert [look.seeds for look in made.looks] == list(LOOKS)
    expected = levels(LOOKS, np.array([0.05, 0.05 / 3]))
    assert [[look.alpha, look.alpha_in_family] for look in made.looks] == pytest.approx(expected, abs=1e-8)


def test_tests_are_counted_for_each_factor_and_repeats_make_none():
    conditions = [
        condition(model, **{"world.steps": steps, "sampling_seed": repeat})
        for model in "abc"
        for steps in ("5", "9")
        for repeat in "01"
    ]
    made = declared(
        conditions, ["grid"] * 12, family=MEASURES, margins={}, looks=(), foundry="0", commit=None, asked=[], models=[]
    )
    assert made.tests == {"model": 2 * 3 * 2, "world.steps": 2 * 3}
    assert made.pairs == {"model": 3 * 2, "world.steps": 3}
    assert [(look.seeds, look.alpha_in_family) for look in made.looks] == [(12, round(0.05 / 6, 8))]


def test_a_measure_is_tested_in_no_pair_with_a_world_that_lacks_it():
    said = {"margins": {}, "looks": (), "foundry": "0", "commit": None, "asked": [], "models": []}
    conditions = [condition(model, world=world) for world in ("w", "x") for model in "ab"]
    forms = ["grid", "grid", "rounds", "rounds"]
    assert declared(conditions, forms, family=MEASURES, **said).tests == {"model": 3, "world": 2}
    with pytest.raises(InputError, match=r"No two conditions to compare have clustering\.nni"):
        declared(conditions[::2], forms[::2], family=["clustering.nni"], **said)


def test_a_measure_stands_with_the_code_of_the_forms_whose_own_module_has_it():
    part = next(signature for signature in discover() if signature.name == "clustering").parts[0]
    assert code_of("clustering.nni", ["grid"]) == {"grid": part.sha256}
    assert list(code_of("communication.reciprocity", ["grid", "rounds"])) == ["grid"]
    with pytest.raises(InputError, match="path_efficiency.success"):
        code_of("path_efficiency.success", ["grid"])
    patterns = [(signature.name, name) for signature in discover() for name in signature.measures if "*" in name]
    signature, pattern = next((name, own) for name, own in patterns if name == "place_choice")
    assert code_of(f"{signature}.{pattern.replace('*', 'cafe')}", ["grid"])
    assert code_of("clustering.nni_readable", ["grid"])


@pytest.mark.parametrize(
    ("changed", "is_same"),
    [
        ('"""Words."""\n\nLEAST = 1  # why\n\ndef f():\n    """More\n    words."""\n    return "#"\n', True),
        ("# Alone.\nLEAST = 1\ndef f():\n\n    return '#'\n".replace("'", '"'), True),
        ('LEAST = 2\ndef f():\n    return "#"\n', False),
        ('LEAST = 1\ndef f():\n    return "# other"\n', False),
        ('LEAST = 1\ndef f(): "words"; return "#"\n', False),
    ],
)
def test_docstrings_and_comments_are_no_code(tmp_path, changed, is_same):
    (tmp_path / "a.py").write_text('LEAST = 1\ndef f():\n    return "#"\n')
    (tmp_path / "b.py").write_text(changed)
    part = next(signature for signature in discover() if signature.name == "clustering").parts[0]
    hashes = {replace(part, file=tmp_path / name).sha256 for name in ("a.py", "b.py")}
    assert (len(hashes) == 1) is is_same


def test_looks_that_no_p_can_pass_are_told():
    assert out_of_reach(plan("ab", looks=(8, 12))) == []
    assert [line.split(" no p")[0] for line in out_of_reach(plan("abcd", looks=(8, 12)))] == ["with 8 seeds,"]
    assert [line.split(":")[0] for line in out_of_reach(plan("ab"))] == [
        "with 6 seeds, no p value can be as low as 0.025"
    ]


def test_margins_within_which_nothing_can_be_the_same_are_told():
    margins = dict.fromkeys(MEASURES, 0.1)
    lines = never_the_same(plan("ab", margins=margins))
    assert lines[0].startswith("The margin 0.1 of idle_rate.chosen needs 29 seeds, but the sweep has 12")
    assert lines[1].startswith("The values of clustering.nni have no limits") and len(lines) == 2
    assert never_the_same(plan("ab", margins=margins, widest=dict.fromkeys(MEASURES, 0.3))) == []


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"family": ["clustering.mni"]}, "Did you mean 'clustering.nni'"),
        ({"family": ["clustering.nni"] * 2}, "given twice"),
        ({"family": []}, "No measure is declared"),
        ({"margins": {"movement.move_rate": 0.1}}, "is not a declared measure: add --family movement.move_rate"),
        *(({"margins": {MEASURES[0]: margin}}, "above 0") for margin in (-1.0, 0.0, math.inf)),
        ({"widest": {MEASURES[0]: 0.3}}, f"has no margin: add --margin {MEASURES[0]}=SIZE"),
        ({"margins": {MEASURES[0]: 0.3}, "widest": {MEASURES[0]: 0.2}}, "use a value above its margin 0.3"),
        ({"looks": (9, 6, 12)}, "must ascend: use 6,9,12"),
        ({"looks": (4, 12)}, "begin with 6"),
        *(({"looks": (6, n)}, f"The last look is at {n} seeds, but the sweep has 12") for n in (9, 15)),
    ],
)
def test_what_cannot_be_declared_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        plan("ab", **changes)


def reached(models: str, worlds: int = 1, seeds: int = 12):
    conditions = [
        condition(model, world=f"w{world}", seeds=range(seeds)) for world in range(worlds) for model in models
    ]
    return reach_of(conditions, ["grid"] * len(conditions))


@pytest.mark.parametrize(("models", "worlds", "fewest"), [("ab", 1, 6), ("abc", 1, 7), ("abcde", 4, 11)])
def test_a_test_needs_more_seeds_the_more_pairs_there_are(models: str, worlds: int, fewest: int):
    assert reached(models, worlds).fewest == fewest
    few = reached(models, worlds, seeds=fewest - 1)
    assert not few.is_enough and math.isnan(few.effect)
    assert few.line().endswith(
        f"need{'s' * (models == 'ab')} at least {fewest} seeds: with {fewest - 1} seeds, no difference can be claimed"
    )


def test_a_single_condition_compares_nothing_and_more_seeds_find_smaller_differences():
    assert reached("a") is None
    sizes = [sure_effect(seeds, 3, 5) for seeds in (8, 12, 20)]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(("seeds", "pairs", "measures"), [(8, 1, 5), (10, 3, 3)])
def test_the_promised_difference_is_found_as_often_by_the_test_in_use(seeds: int, pairs: int, measures: int):
    effect = sure_effect(seeds, pairs, measures)
    draws = np.random.default_rng(5)
    shift = np.zeros((measures, 1))
    shift[0] = effect
    p = [step_down_p(draws.standard_normal((measures, seeds)) + shift)[0] for _ in range(200)]
    assert np.mean(np.array(p) * pairs <= 0.05) == pytest.approx(CHANCE, abs=0.09)
