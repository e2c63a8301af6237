"""Texts that are drawn for people: with which probability, from which strata, and what a second draw adds."""

import numpy as np
import pytest

from foundry.labels.definition import Label
from foundry.labels.items import Item
from foundry.labels.sampling import PER_MODEL, Sample, extended, shares_of, spread

LABEL = Label(
    name="warning", question="?", choices=("yes", "no"), unit="message",
    rule="fire", rule_is_pattern=True, near="smoke", near_is_pattern=True,
)  # fmt: skip


def items(models: str = "ab", seeds: int = 10, each: int = 30) -> list[Item]:
    """Make texts of which a tenth are warnings by the rule and a fifth are near."""
    words = ["fire", "smoke", "smoke", *["hello"] * 7]
    return [
        Item(f"{model}-s{seed}", model, seed, step, 0, "message", f"{words[step % 10]} {model} {seed} {step}", {})
        for model in models for seed in range(seeds) for step in range(1, each + 1)
    ]  # fmt: skip


def empty(seed: int = 0, label: Label = LABEL) -> Sample:
    return Sample(label=label.name, question_sha256=label.question_sha256, seed=seed)


def drawn(items: list[Item], per_model: int | None, sample: Sample | None = None) -> Sample:
    return extended(sample or empty(), LABEL, items, dict.fromkeys(item.run for item in items), per_model)


def test_each_model_gives_a_third_of_its_texts_from_each_stratum_spread_over_seeds():
    sample = drawn(items(), 60)
    assert [(stratum.model, stratum.says, stratum.size) for stratum in sample.strata] == [
        (model, says, size) for model in "ab" for says, size in (("near", 60), ("no", 210), ("yes", 30))
    ]
    for number, stratum in enumerate(sample.strata):
        own = [picture for picture in sample.drawn if picture.stratum == number]
        assert stratum.probability == pytest.approx(20 / stratum.size)
        assert abs(len(own) - 20) <= 1
        by_seed = np.bincount([picture.seed for picture in own], minlength=10)
        assert by_seed.max() - by_seed.min() <= 2, "no seed gives much more than another"


@pytest.mark.parametrize("probability", [0.05, 1 / 3, 0.8])
def test_every_text_is_drawn_with_the_probability_that_is_kept(probability):
    offsets = (np.arange(4000) + 0.5) / 4000
    counts = np.zeros(37)
    for offset in offsets:
        counts[spread(37, probability, float(offset))] += 1
    assert counts / len(offsets) == pytest.approx(probability, abs=2 / 4000)


def test_a_stratum_with_few_texts_gives_all_of_them_and_the_others_more():
    assert shares_of({"yes": 4, "near": 100, "no": 1000}, 60) == {"yes": 4, "near": 28, "no": 28}
    assert shares_of({"rest": 5}, 60) == {"rest": 5}
    few = drawn(items("a", 1, 20), PER_MODEL)
    assert len(few.drawn) == 20 and {stratum.probability for stratum in few.strata} == {1}


def test_more_texts_for_each_model_keep_those_that_were_drawn_and_fewer_take_none_away():
    first = drawn(items(), 30)
    more = drawn(items(), 90, first)
    assert {picture.item for picture in first.drawn} < {picture.item for picture in more.drawn}
    assert drawn(items(), 12, first) == drawn(items(), None, first) == first
    assert drawn(items(), 30) == first, "the same is drawn again"
    assert extended(empty(1), LABEL, items(), [], 30).drawn == ()


def test_runs_that_a_sweep_grew_by_are_drawn_from_by_themselves_and_silent_runs_count_as_drawn_from():
    first = drawn(items(seeds=4), 30)
    grown = extended(first, LABEL, items(), [*dict.fromkeys(item.run for item in items()), "silent-s0"], None)
    assert grown.runs[1][-1] == "silent-s0" and len(grown.runs) == 2
    assert grown.per_model == (30, 30)
    assert {picture.item for picture in first.drawn} == {
        picture.item for picture in grown.drawn if grown.strata[picture.stratum].draw == 0
    }, "earlier draws stay as they were"
    assert {picture.seed for picture in grown.drawn if grown.strata[picture.stratum].draw == 1} == set(range(4, 10))


def test_without_a_rule_all_texts_of_a_model_are_one_stratum():
    label = Label(name="polite", question="?", choices=("yes", "no"), unit="message")
    sample = extended(empty(label=label), label, items(), ["a-s0"], 30)
    assert {stratum.says for stratum in sample.strata} == {"rest"}
