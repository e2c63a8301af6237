"""Computes how many labels by people are needed to detect a difference between two models."""

import itertools
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.labelling import WARNING, rule_labelling
from analysis.labelling.correcting import FEWEST
from analysis.tables.table import Table
from foundry.errors import InputError
from foundry.labels.definition import Label
from foundry.labels.folder import Labels
from foundry.labels.items import Item, items_of
from foundry.labels.sampling import NEAR, REST, shares_of, stratum_of
from foundry.storing.store import SweepFolder

DIFFERENCES = (0.05, 0.1, 0.15, 0.2, 0.3)
"""Differences between two models in the share of the label's first choice; the table has a row per difference."""
USUAL_ERROR = 0.15
"""The error rate that is assumed for the rule in a stratum without labels by people."""
_STEP = 10


@dataclass(frozen=True)
class _Stratum:
    """A model's texts in one stratum, for example all texts that the rule labels as warnings.

    Attributes:
        weight: share of the model's texts that are in this stratum, 0..1.
        error: share of these texts for which the rule is wrong, 0..1.
    """

    weight: float
    size: int
    error: float


def labels_needed(sweep: SweepFolder, label: Label, power: float = 0.8) -> Table:
    """Return how many texts of each model people must label to detect a difference in the share of the first choice.

    The variance of a corrected difference has two parts: the variance of the rule's difference over the seeds of the
    sweep; and, for each stratum, its squared weight times e (1 - e) (1 / n - 1 / N). N is the stratum's number of
    texts, n its number of labelled texts, and e the rule's error rate (Cochran 1977, chapter 5). The error rate comes
    from people's labels if there are any.

    Raises:
        InputError: fewer than two models have texts, or the seeds are too few.
    """
    items = [item for item in items_of(sweep, label) if label.choices]
    by_model: dict[str, list[Item]] = defaultdict(list)
    for item in items:
        by_model[item.model].append(item)
    if len(by_model) < 2:
        raise InputError(
            f"--labels {label.name} compares models, but only {len(by_model)} of the models of '{sweep.path}' have "
            "texts: name a sweep in which at least two models have texts."
        )
    errors = _errors(sweep, label)
    strata = {model: _strata(label, some, errors) for model, some in by_model.items()}
    seeds, variance = _over_seeds(label, by_model)
    rows = []
    for difference in DIFFERENCES:
        needed = _needed(difference, power, variance, list(strata.values()))
        rows.append((f"{difference:g}", "more seeds" if needed is None else str(needed)))
    known = "people's labels" if errors else "the rule's accuracy on other texts"
    caption = (
        f"Number of labels per model to detect a difference in the share of '{label.choices[0]}' with "
        f"probability {power:g}, for {seeds} seeds and two models; errors of the rule from {known}."
    )
    return Table("labels_needed", caption, ("difference", "labels per model"), tuple(rows), labels=0)


def _strata(label: Label, items: Sequence[Item], errors: Mapping[str, float]) -> list[_Stratum]:
    sizes: dict[str, int] = defaultdict(int)
    for item in items:
        sizes[stratum_of(label, item.text, item.context)] += 1
    usual = _usual_errors(label)
    return [
        _Stratum(size / len(items), size, errors.get(name, usual.get(name, USUAL_ERROR)))
        for name, size in sorted(sizes.items())
    ]


def _usual_errors(label: Label) -> dict[str, float]:
    if label.name != WARNING:
        return {REST: 0.5} if not label.rule else {}
    agreement = rule_labelling().agreement
    no = max(1, agreement.texts - agreement.unlabelled - agreement.true_warnings - agreement.false_warnings)
    return {"yes": 1 - agreement.precision, NEAR: 0.3, "no": agreement.missed / no}


def _errors(sweep: SweepFolder, label: Label) -> dict[str, float]:
    """Return the rule's error rate for each stratum with at least FEWEST texts that people labelled."""
    labels = Labels.of(sweep, label)
    if labels is None:
        return {}
    drawn = {text.item: text for text in labels.sample.drawn}
    wrong: dict[str, list[bool]] = defaultdict(list)
    rule = label.rule_function()
    for item, answers in labels.answers.items():
        text = drawn[item]
        said = rule(text.text, text.context) if rule else label.choices[1]
        stratum = labels.sample.strata[text.stratum].says
        wrong[stratum] += [answer != (said or label.choices[1]) for answer in answers]
    return {name: (sum(some) + 0.5) / (len(some) + 1) for name, some in wrong.items() if len(some) >= FEWEST}


def _over_seeds(label: Label, by_model: Mapping[str, Sequence[Item]]) -> tuple[int, float]:
    """Return the number of seeds that two models share, and the variance of their mean difference.

    The difference is that of the shares of the first choice by the rule. The number is the smallest of all pairs of
    models, the variance a mean over the pairs.
    """
    shares: dict[str, dict[int, float]] = {}
    for model, items in by_model.items():
        said: dict[int, list[bool]] = defaultdict(list)
        for item in items:
            said[item.seed].append(stratum_of(label, item.text, item.context) == label.choices[0])
        shares[model] = {seed: float(np.mean(some)) for seed, some in said.items()}
    pairs = [
        np.array([first[seed] - second[seed] for seed in first if seed in second])
        for first, second in itertools.combinations(shares.values(), 2)
    ]
    pairs = [pair for pair in pairs if len(pair) > 1]
    if not pairs:
        raise InputError("No two models have texts in the same two seeds or more: run more seeds, then plan labels.")
    return min(map(len, pairs)), float(np.mean([pair.var(ddof=1) / len(pair) for pair in pairs]))


def _needed(difference: float, power: float, variance: float, models: Sequence[Sequence[_Stratum]]) -> int | None:
    from scipy.special import ndtri

    most = max(sum(stratum.size for stratum in strata) for strata in models)
    allowed = (difference / float(ndtri(0.975) + ndtri(power))) ** 2
    for labels in itertools.count(_STEP, _STEP):
        added = float(np.mean([_variance(strata, labels) for strata in models])) * 2
        if variance + added <= allowed:
            return labels
        if labels >= most:
            return None
    raise AssertionError("the numbers never end")


def _variance(strata: Sequence[_Stratum], labels: int) -> float:
    drawn = shares_of({str(number): stratum.size for number, stratum in enumerate(strata)}, labels)
    return math.fsum(
        stratum.weight**2 * stratum.error * (1 - stratum.error) * (1 / drawn[str(number)] - 1 / stratum.size)
        for number, stratum in enumerate(strata)
    )
