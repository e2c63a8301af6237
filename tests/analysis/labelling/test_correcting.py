"""Measures that labels of people correct: the estimator, its limits, and the copies with drawn labels."""

import math
from functools import cache

import numpy as np
import pytest

from analysis.labelling.correcting import COPIES, Correction, corrected_by, corrected_mean
from analysis.stats.imputed import variance_of_copies, widened
from foundry.labels.definition import Label
from foundry.labels.folder import Labels
from foundry.labels.items import Item
from foundry.labels.sampling import Sample, extended

LABEL = Label(
    name="warning", question="?", choices=("yes", "no"), unit="message",
    rule="fire", rule_is_pattern=True, near="smoke", near_is_pattern=True,
)  # fmt: skip
WORDS = ("fire", "smoke", "hello", "hello")
RUNS, EACH = 6, 80


def truth(item: Item) -> bool:
    """The rule finds two thirds of the warnings, and every fifth of its warnings is none."""
    number = item.step * 7 + item.seed
    return number % 5 > 0 if "fire" in item.text else number % (3 if "smoke" in item.text else 9) == 0


@cache
def items() -> list[Item]:
    return [
        Item(f"a-s{seed}", "a", seed, step, 0, "message", f"{WORDS[step % 4]} {seed} {step}", {}, step % 2 == 0)
        for seed in range(RUNS) for step in range(1, EACH + 1)
    ]  # fmt: skip


def sample(seed: int = 0, per_model: int = 90) -> Sample:
    empty = Sample(label="warning", question_sha256=LABEL.question_sha256, seed=seed)
    return extended(empty, LABEL, items(), dict.fromkeys(item.run for item in items()), per_model)


MODELS = {item.run: item.model for item in items()}


def correction(sample: Sample, **people: dict[str, str]) -> Correction:
    corrected = corrected_by(Labels(sample, people), LABEL, MODELS)
    assert corrected.correction is not None, corrected.why
    return corrected.correction


def honest(sample: Sample) -> dict[str, str]:
    by_id = {item.id: truth(item) for item in items()}
    return {picture.item: "yes" if by_id[picture.item] else "no" for picture in sample.drawn}


def share(correction: Correction, run: str) -> float:
    own = [item for item in items() if item.run == run]
    surrogate = np.array(["fire" in item.text for item in own], dtype=np.float64)
    people, weight = np.full(EACH, math.nan), np.ones(EACH)
    for weighed in correction.by_run.get(run, ()):
        people[weighed.step - 1], weight[weighed.step - 1] = weighed.shares.get("yes", 0.0), weighed.weight
    return corrected_mean(surrogate, people, weight)


def test_over_many_draws_the_corrected_share_is_that_of_the_true_labels_whatever_the_rule_gets_wrong():
    true = np.mean([truth(item) for item in items()])
    by_rule = np.mean(["fire" in item.text for item in items()])
    found = []
    for seed in range(120):
        drawn = sample(seed)
        item = correction(drawn, ana=honest(drawn))
        found.append(np.mean([share(item, f"a-s{run}") for run in range(RUNS)]))
    error = np.std(found) / math.sqrt(len(found))
    assert abs(np.mean(found) - true) < 4 * error < 0.02 < abs(by_rule - true)


def test_with_all_texts_labelled_the_share_is_exactly_the_true_one():
    drawn = sample(per_model=10_000)
    one = correction(drawn, ana=honest(drawn))
    for run in range(RUNS):
        own = [truth(item) for item in items() if item.seed == run]
        assert share(one, f"a-s{run}") == pytest.approx(np.mean(own))


def test_unclear_labels_count_as_not_drawn_and_two_people_who_disagree_as_a_half():
    drawn = sample()
    ana = honest(drawn)
    first, second = (picture.item for picture in drawn.drawn[:2])
    ana[first] = "unclear"
    ben = {second: {"yes": "no", "no": "yes"}[ana[second]]}
    picture = correction(drawn, ana=ana, ben=ben)
    assert (picture.texts, picture.people) == (len(drawn.drawn) - 1, ("ana", "ben"))
    assert picture.note() == f"corrected with {len(drawn.drawn) - 1} labels of 2 people"
    weighed = {(run, item.step): item for run, some in picture.by_run.items() for item in some}
    by_item = {item.item: item for item in drawn.drawn}
    assert (by_item[first].run, by_item[first].step) not in weighed
    assert weighed[by_item[second].run, by_item[second].step].shares == {"yes": 0.5, "no": 0.5}
    stratum = drawn.strata[by_item[first].stratum]
    others = [item for item in drawn.drawn if item.stratum == by_item[first].stratum and item.item != first]
    assert weighed[others[0].run, others[0].step].weight == stratum.size / len(others)


def test_a_stratum_with_fewer_than_five_labels_corrects_nothing_and_says_what_to_do():
    drawn = sample()
    near = [picture.item for picture in drawn.drawn if drawn.strata[picture.stratum].says == "near"]
    few = {item: label for item, label in honest(drawn).items() if item not in near[4:]}
    corrected = corrected_by(Labels(drawn, {"ana": few}), LABEL, MODELS, "foundry play out --label warning")
    assert corrected.correction is None
    assert corrected.why == (
        "only 4 of 120 texts of a in stratum 'near' have a label by a person, but 5 are needed: continue "
        "with foundry play out --label warning"
    )


def test_copies_keep_labels_of_people_and_draw_the_others_at_the_rates_of_their_cell():
    drawn = sample()
    one = correction(drawn, ana=honest(drawn))
    known = drawn.drawn[0]
    texts = [(known.text, {}, known.aware), *((f"hello other {number}", {}, True) for number in range(400))]
    copies = one.copies("a-s0", texts)
    assert copies.shape == (COPIES, 401)
    assert set(copies[:, 0].tolist()) == {honest(drawn)[known.item] == "yes"}
    labelled = [honest(drawn)[item.item] == "yes" for item in drawn.drawn if "hello" in item.text and item.aware]
    assert copies[:, 1:].mean() == pytest.approx(np.mean(labelled), abs=0.08)
    assert copies[:, 1:].mean(axis=1).std() > 0.01, "each copy has rates of its own"
    assert (one.copies("a-s1", texts) == copies).all(), "the same text has the same label in every run of a copy"


def test_the_variance_of_copies_is_rubins_and_widened_differences_keep_their_mean():
    rng = np.random.default_rng(3)
    differences = rng.normal(0.1, 0.2, (8, 1)) + rng.normal(0, 0.05, 30) + rng.normal(0, 0.1, (8, 30))
    averaged = differences.mean(axis=1)
    within = differences.var(axis=0, ddof=1).mean() / 8
    between = differences.mean(axis=0).var(ddof=1)
    added = variance_of_copies(differences)
    assert added + averaged.var(ddof=1) / 8 == pytest.approx(within + 31 / 30 * between)
    wide = widened(np.array([averaged, averaged]), np.array([added, 0.0]))
    assert wide[0].mean() == pytest.approx(averaged.mean())
    assert wide[0].var(ddof=1) / 8 == pytest.approx(within + 31 / 30 * between)
    assert (wide[1] == averaged).all()
    assert variance_of_copies(np.full((8, 30), 0.25)) == 0
    assert variance_of_copies(np.full((8, 30), math.nan)) == 0
