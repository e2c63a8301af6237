"""Draws the texts that people label, each with a known probability.

A stratum contains the texts of one model for which the rule of the label gives the same result.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache

import msgspec
import numpy as np

from foundry import seeding
from foundry.labels.definition import Context, Label, Rule
from foundry.labels.items import Item

PER_MODEL = 200
"""Default number of texts that are drawn for each model."""
NEAR, REST = "near", "rest"
"""Two of the names for strata: `near` if the rule may be wrong about a text, `rest` if the label has no rule."""
_GOLDEN = (5**0.5 - 1) / 2


class SampledText(msgspec.Struct, frozen=True, kw_only=True):
    """A text that was drawn for people to label.

    Attributes:
        item: its name (`Item.id`).
        stratum: index of its stratum in `Sample.strata`.
        step: 1-based step.
        agent: id of the agent that wrote it.
        aware: whether the agent knew of a fire by then (`Item.aware`).
    """

    item: str
    stratum: int
    text: str
    context: dict[str, str | tuple[str, ...]]
    run: str
    seed: int
    step: int
    agent: int
    kind: str
    aware: bool = False


class Stratum(msgspec.Struct, frozen=True, kw_only=True):
    """A group of texts, from which texts are drawn: one model wrote them, and the label's rule says the same of each.

    Attributes:
        draw: index of the draw, from 0; runs that are added later belong to further draws.
        says: the rule's result: a choice, `near` or `rest`.
        size: number of texts in the stratum.
        probability: probability with which each of them was drawn, 0..1.
    """

    draw: int
    model: str
    says: str
    size: int
    probability: float


class Sample(msgspec.Struct, frozen=True, kw_only=True):
    """The texts that people label (`labels/<label>/sample.json`).

    Attributes:
        question_sha256: hash of the question; labels of another question do not count.
        per_model: number of texts for each model, one number per draw.
        runs: ids of the runs from which texts were drawn, by draw.
        strata: the strata of all draws.
        drawn: the drawn texts.
    """

    label: str
    question_sha256: str
    seed: int
    per_model: tuple[int, ...] = ()
    runs: tuple[tuple[str, ...], ...] = ()
    strata: tuple[Stratum, ...] = ()
    drawn: tuple[SampledText, ...] = ()


def stratum_of(label: Label, text: str, context: Context) -> str:
    """Return the stratum of a text: the rule's result, `near` if that result may be wrong, `rest` without a rule."""
    rule, near = _functions(label)
    if rule is None:
        return REST
    said = rule(text, context)
    is_first = said is not None and said == (label.choices or (None,))[0]
    return NEAR if said is None or (not is_first and near(text, context)) else said


@lru_cache(maxsize=8)
def _functions(label: Label) -> tuple[Rule | None, Callable[[str, Context], bool]]:
    return label.rule_function(), label.near_function()


def _strata_of(label: Label, items: Sequence[Item]) -> list[str]:
    contents = [item.content for item in items]
    by_content = dict(zip(contents, items, strict=True))
    known = {content: stratum_of(label, item.text, item.context) for content, item in by_content.items()}
    return [known[content] for content in contents]


def extended(sample: Sample, label: Label, items: Sequence[Item], runs: Iterable[str], per_model: int | None) -> Sample:
    """Return the sample with more texts: from new runs and, if `per_model` has grown, from runs that it already covers.

    No text ever leaves a sample.

    Args:
        sample: the sample so far.
        label: the label.
        items: all texts of the sweep.
        runs: ids of all complete runs, including those without any text.
        per_model: minimum number of texts for each model in each draw. None adds no texts of known runs, and takes the
            largest earlier number from new runs.
    """
    known = {run for runs in sample.runs for run in runs}
    fresh = tuple(run for run in runs if run not in known)
    draws = [*sample.runs, *([fresh] if fresh else [])]
    usual = max(sample.per_model, default=PER_MODEL)
    wanted = [max(per_model or 0, before) for before in sample.per_model] + ([per_model or usual] if fresh else [])
    draw_of = {run: draw for draw, drawn_from in enumerate(draws) for run in drawn_from}
    groups: dict[tuple[int, str], dict[str, list[Item]]] = {}
    for item, says in zip(items, _strata_of(label, items), strict=True):
        if item.run in draw_of:
            groups.setdefault((draw_of[item.run], item.model), {}).setdefault(says, []).append(item)
    strata: list[Stratum] = []
    drawn: list[SampledText] = []
    for (draw, model), by_stratum in sorted(groups.items(), key=lambda group: group[0][0]):
        shares = shares_of({says: len(some) for says, some in by_stratum.items()}, wanted[draw])
        for says, unsorted in sorted(by_stratum.items()):
            some = sorted(unsorted, key=lambda item: (item.seed, item.run, item.step, item.agent, item.kind))
            probability = shares[says] / len(some)
            offset = float(seeding.stream(sample.seed, f"labels:{label.name}:{draw}:{model}:{says}").random())
            drawn += [_drawn(some[index], len(strata)) for index in spread(len(some), probability, offset)]
            strata.append(Stratum(draw=draw, model=model, says=says, size=len(some), probability=probability))
    return msgspec.structs.replace(
        sample, per_model=tuple(wanted), runs=tuple(draws), strata=tuple(strata), drawn=tuple(drawn)
    )


def spread(count: int, probability: float, offset: float) -> list[int]:
    """Draw some of the indices 0 to `count` - 1, spread evenly, each with the same probability.

    Index i is drawn if the fractional part of `offset + i / golden ratio` is below the probability. With an offset that
    is uniformly random in 0..1, each index has exactly this probability. A larger probability only adds indices.
    """
    return np.flatnonzero((offset + _GOLDEN * np.arange(count)) % 1.0 < probability).tolist()


def shares_of(sizes: Mapping[str, int], most: int) -> dict[str, float]:
    """Return how many of `most` texts come from each stratum, given the number of texts in each stratum.

    All strata give equally many; if a stratum has too few texts, the others give more.
    """
    left, shares = float(most), dict[str, float]()
    for number, name in enumerate(sorted(sizes, key=lambda stratum: sizes[stratum])):
        shares[name] = min(float(sizes[name]), left / (len(sizes) - number))
        left -= shares[name]
    return shares


def _drawn(item: Item, stratum: int) -> SampledText:
    context: Context = {key: value if isinstance(value, tuple) else str(value) for key, value in item.context.items()}
    return SampledText(
        item=item.id, stratum=stratum, text=item.text, context=dict(context), run=item.run, seed=item.seed,
        step=item.step, agent=item.agent, kind=item.kind, aware=item.aware,
    )  # fmt: skip
