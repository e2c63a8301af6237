"""The measures of a user-defined label: the share of each choice among a run's texts, corrected by people's labels."""

import math
from collections.abc import Iterable

import numpy as np

from analysis.any.any_run import AnyRun, LabelledTexts
from analysis.arrays import FloatArray
from analysis.labelling.correcting import Correction, corrected_mean
from analysis.labelling.own_label import OwnLabel
from analysis.measure import Measure, share
from foundry.labels.definition import NO, YES, Label
from foundry.labels.items import Item, items_in
from foundry.storing.store import RunFolder

UNCORRECTED = "_uncorrected"
"""If people's labels correct a measure, the uncorrected value is a second measure, with this suffix in its name."""
_TEXTS = {"message": "messages", "decision": "replies", "reply": "replies", "moment": "replies"}


def names_of(label: Label) -> dict[str, str]:
    """Return the names of a label's measures, each with the choice whose share it measures."""
    if label.choices == (YES, NO):
        return {"share": YES}
    return {f"share_{choice}": choice for choice in label.choices}


def measures_of(label: Label) -> dict[str, Measure]:
    """Return the measures of a label."""
    title, texts = label.name.replace("_", " "), _TEXTS[label.unit]
    return {
        name: share(
            f"{title.capitalize()}: {choice} (share of {texts})",
            says=f"gets the label '{title}: {choice}' {{more|less}} often",
        )
        for name, choice in names_of(label).items()
    }


def about(label: Label) -> str:
    """Return the description of a label's measures, in the form of the docstring of a signature."""
    texts = _TEXTS[label.unit]
    items = [
        f"- {name}: {texts} with the label '{choice}' / {texts}; 0..1." for name, choice in names_of(label).items()
    ]
    return "\n".join([f"The question to a labeller: {label.question}", "", *items])


def measure(run: AnyRun, label: Label) -> dict[str, float]:
    """Return the share of each choice of a label among the texts of a run, corrected if people labelled enough texts.

    With a corrected share comes the uncorrected one, which uses the rule or the model alone. Denominators: n_texts,
    n_labelled (by people).
    """
    texts = run.labels[label.name]
    used = texts.counted if run.readable_only else np.ones(len(texts.weight), dtype=np.bool_)
    measures: dict[str, float] = {}
    for place, name in enumerate(names_of(label)):
        surrogate = np.zeros(len(used)) if texts.surrogate is None else texts.surrogate[:, place]
        alone = float(surrogate[used].mean()) if used.any() else math.nan
        if texts.is_corrected:
            measures[name] = corrected_mean(surrogate[used], texts.truth[used, place], texts.weight[used])
        if texts.surrogate is not None:
            measures[f"{name}{UNCORRECTED}" if texts.is_corrected else name] = alone
    labelled = int((~np.isnan(texts.truth[used, 0])).sum())
    return {**measures, "n_texts": float(used.sum()), "n_labelled": float(labelled)}


def applies(run: AnyRun, label: Label) -> bool:
    """Return whether the texts of a run have labels, from a rule, a model or people."""
    texts = run.labels.get(label.name)
    return texts is not None and (texts.is_corrected or texts.surrogate is not None)


def labelled_texts(folder: RunFolder, own: OwnLabel) -> LabelledTexts:
    """Return the texts of a run with their labels."""
    label, items = own.label, list(items_in(folder, own.label))
    correction = own.correction if own.correction and folder.id in own.correction.strata_of_run else None
    truth, weight = _by_people(items, label, correction)
    return LabelledTexts(
        surrogate=_surrogate(items, own),
        truth=truth,
        weight=weight,
        counted=np.array([item.is_readable for item in items], dtype=np.bool_),
        is_corrected=correction is not None,
    )


def _surrogate(items: Iterable[Item], own: OwnLabel) -> FloatArray | None:
    rule = own.label.rule_function()
    if own.judged is not None:
        said = [own.judged.get(item.content) for item in items]
    elif rule is not None:
        said = [rule(item.text, item.context) for item in items]
    else:
        return None
    rows = [[float(label == choice) for choice in own.label.choices] for label in said]
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(own.label.choices))


def _by_people(items: list[Item], label: Label, correction: Correction | None) -> tuple[FloatArray, FloatArray]:
    truth, weight = np.full((len(items), len(label.choices)), math.nan), np.ones(len(items))
    place = {(item.step, item.agent, item.kind): number for number, item in enumerate(items)}
    for weighed in correction.by_run.get(items[0].run, ()) if correction and items else ():
        number = place[weighed.step, weighed.agent, weighed.kind]
        truth[number] = [weighed.shares.get(choice, 0.0) for choice in label.choices]
        weight[number] = weighed.weight
    return truth, weight
