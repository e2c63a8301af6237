"""Corrects measures of labels with a random sample of texts that people labelled.

A mean of labels is corrected in each run separately. A rule or a model (the surrogate) labels all texts of the run, and
foundry takes the mean of the surrogate's labels. The correction that foundry adds to this mean is a sum over the texts
that people labelled, divided by the number of all texts of the run. Each text that a person labelled adds (person's
label - surrogate's label) x N / n to the sum. N is the number of texts in its stratum, n the number that people
labelled. The difference estimator, as this correction is called, is unbiased whatever errors the surrogate makes
(Särndal, Swensson and Wretman 1992). The corrected mean is one value per run, so models can be compared in pairs of
seeds as for other measures.

Measures that are not means are computed on COPIES copies of a run. In each copy, every text that nobody labelled gets a
random label. The probability of the drawn label depends on the text's model, on its stratum, and on whether its agent
knew of a fire. If the probability ignored what the agent knew, chains of warnings would begin with agents that know of
no fire. The method with copies is multiple imputation; `analysis.stats.imputed` combines the values of the copies into
one.
"""

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from analysis.arrays import BoolArray, FloatArray
from foundry import seeding
from foundry.labels.definition import UNCLEAR, Context, Label
from foundry.labels.folder import Labels
from foundry.labels.items import complete_runs, content_of
from foundry.labels.sampling import Stratum, stratum_of
from foundry.storing.store import SweepFolder

COPIES = 30
"""Number of copies of each run; each copy has other random labels where people gave none."""
FEWEST = 5
"""Minimum number of labelled texts in each stratum; in smaller strata, all texts must be labelled."""
_PRIOR = 0.5
"""Jeffreys' prior for the rate of a choice: it counts as half a label for the choice and half a label against it."""

CellKey = tuple[int, str, str, bool]
"""Key of a cell, a set of texts that share one rate of a choice.

The key contains the number of the sample, the model, the stratum, and whether the agent knew of a fire.
"""


@dataclass(frozen=True)
class WeighedText:
    """A text labelled by people.

    Attributes:
        shares: for each choice, the share of people who chose it, without people who found the text unclear.
        weight: number of texts that it represents in its stratum.
    """

    step: int
    agent: int
    kind: str
    shares: Mapping[str, float]
    weight: float


@dataclass(frozen=True)
class Correction:
    """The labels by people that correct measures.

    Attributes:
        texts: number of labelled texts, without texts that every person found unclear, which count as not drawn.
        by_run: labelled texts by run.
        known: shares of the choices, by the content that a person saw; the same text may occur several times.
        rates: for each cell, the rate of the first choice in every copy, (COPIES,).
        strata_of_run: draw and model of each run.
        version: hash of the labels; it changes whenever a corrected measure may change.
    """

    label: Label
    people: tuple[str, ...]
    texts: int
    by_run: Mapping[str, tuple[WeighedText, ...]]
    known: Mapping[bytes, Mapping[str, float]]
    rates: Mapping[CellKey, FloatArray]
    strata_of_run: Mapping[str, tuple[int, str]]
    version: str

    def note(self) -> str:
        """Return the number of labels and people, in words."""
        people = f"{len(self.people)} people" if len(self.people) > 1 else "1 person"
        return f"corrected with {self.texts} labels of {people}"

    def copies(self, run: str, texts: Sequence[tuple[str, Context, bool]]) -> BoolArray:
        """Return, for each copy of the run and each text, whether the label is the first choice, (COPIES, texts).

        Within a copy, equal texts get equal labels.

        Args:
            run: id of the run.
            texts: the texts, each with its context and whether its agent knew of a fire.
        """
        first = self.label.choices[0]
        copied = np.zeros((COPIES, len(texts)), dtype=np.bool_)
        for number, (text, context, aware) in enumerate(texts):
            content = content_of(text, context)
            shares = self.known.get(content)
            rate = self._rates_of(run, text, context, aware) if shares is None else shares.get(first, 0.0)
            drawn = np.frombuffer(hashlib.shake_128(content).digest(4 * COPIES), dtype=np.uint32) / 2**32
            copied[:, number] = drawn < rate
        return copied

    def _rates_of(self, run: str, text: str, context: Context, aware: bool) -> FloatArray:
        """Return the probability that a text gets the label's first choice, one per copy of the run, (COPIES,).

        If people labelled no text of its cell, the probability is drawn from the prior.
        """
        cell = (*self.strata_of_run[run], stratum_of(self.label, text, context), aware)
        return self.rates[cell] if cell in self.rates else _rates(cell, self.label, {}, {})


def _rates(cell: CellKey, label: Label, counts: Mapping[str, float], together: Mapping[str, float]) -> FloatArray:
    """Draw, for each copy of the run, the probability of the label's first choice from its posterior, (COPIES,).

    Args:
        cell: the cell.
        label: the label.
        counts: number of labelled texts of the cell by choice.
        together: the same numbers for the whole stratum; they count as one label, which helps cells with few labels.
    """
    draw, model, says, aware = cell
    choice = label.choices[0]
    prior = (_PRIOR + together.get(choice, 0.0)) / (2 * _PRIOR + sum(together.values()))
    first = counts.get(choice, 0.0)
    rng = seeding.stream(draw, f"rates:{label.name}:{model}:{says}:{aware}")
    return rng.beta(prior + first, 1 - prior + sum(counts.values()) - first, size=COPIES)


@dataclass(frozen=True)
class Corrected:
    """A correction by people's labels, or the reason why there is none ("" if nobody labelled texts)."""

    correction: Correction | None = None
    why: str = ""


def correction_of(sweep: SweepFolder, label: Label) -> Corrected:
    """Return the correction of a label of a sweep by people's labels.

    Raises:
        RecordError: the labels cannot be read.
    """
    labels = Labels.of(sweep, label)
    if labels is None or not labels.answers:
        return Corrected()
    known = {run for runs in labels.sample.runs for run in runs}
    more = f"foundry play {sweep.path} --label {label.name}"
    if missing := [run for run in complete_runs(sweep) if run.id not in known]:
        return Corrected(why=f"no texts to label were drawn from {len(missing)} newer runs; to draw some, use {more}")
    return corrected_by(
        labels, label, {run.id: str(run.recorded_config()["model"]["name"]) for run in sweep.runs()}, more
    )


def corrected_by(labels: Labels, label: Label, models: Mapping[str, str], more: str = "") -> Corrected:
    """Return the correction by people's labels, or why there is none; `models` holds the model of each run.

    The command `more` continues the labelling.
    """
    shares = {item: _shares(answers) for item, answers in labels.answers.items()}
    clear = {item: share for item, share in shares.items() if share}
    labelled = Counter(drawn.stratum for drawn in labels.sample.drawn if drawn.item in clear)
    for number, stratum in enumerate(labels.sample.strata):
        if labelled[number] < min(FEWEST, stratum.size):
            return Corrected(why=_too_few(stratum, labelled[number], more))
    return Corrected(_correction(labels, label, clear, labelled, models))


def _shares(answers: Sequence[str]) -> dict[str, float]:
    counts = Counter(answer for answer in answers if answer != UNCLEAR)
    return {choice: count / counts.total() for choice, count in counts.items()}


def _too_few(stratum: Stratum, labelled: int, more: str) -> str:
    return (
        f"only {labelled} of {stratum.size} texts of {stratum.model} in stratum '{stratum.says}' have a label by a "
        f"person, but {min(FEWEST, stratum.size)} are needed: continue with {more}"
    )


def _correction(
    labels: Labels,
    label: Label,
    clear: Mapping[str, Mapping[str, float]],
    labelled: Mapping[int, int],
    models: Mapping[str, str],
) -> Correction:
    sample = labels.sample
    by_run: dict[str, list[WeighedText]] = {}
    counts: dict[CellKey, Counter[str]] = {}
    together: dict[tuple[int, str, str], Counter[str]] = {}
    known: dict[bytes, Mapping[str, float]] = {}
    for drawn in sample.drawn:
        if drawn.item not in clear:
            continue
        stratum = sample.strata[drawn.stratum]
        weight = stratum.size / labelled[drawn.stratum]
        by_run.setdefault(drawn.run, []).append(
            WeighedText(drawn.step, drawn.agent, drawn.kind, clear[drawn.item], weight)
        )
        known[content_of(drawn.text, drawn.context)] = clear[drawn.item]
        key = stratum.draw, stratum.model, stratum.says
        counts.setdefault((*key, drawn.aware), Counter()).update(clear[drawn.item])
        together.setdefault(key, Counter()).update(clear[drawn.item])
    content = msgspec.json.encode((sample, {name: dict(labels.by_person[name]) for name in sorted(labels.by_person)}))
    return Correction(
        label=label,
        people=tuple(sorted(name for name, labels_of_person in labels.by_person.items() if labels_of_person)),
        texts=len(clear),
        by_run={run: tuple(weighed) for run, weighed in by_run.items()},
        known=known,
        rates={
            (*key, aware): _rates((*key, aware), label, counts.get((*key, aware), {}), counted)
            for key, counted in together.items()
            for aware in (False, True)
        },
        strata_of_run={run: (draw, models[run]) for draw, runs in enumerate(sample.runs) for run in runs},
        version=hashlib.sha256(content).hexdigest()[:16],
    )


def corrected_mean(surrogate: FloatArray, truth: FloatArray, weight: FloatArray) -> float:
    """Return the mean of a rule's or a model's labels, corrected by people's labels; NaN without texts.

    Args:
        surrogate: labels by a rule or a model, 0 or 1, (n,).
        truth: labels by people, 0..1, (n,); NaN for texts that nobody labelled.
        weight: number of texts that each labelled text represents, (n,).
    """
    if not len(surrogate):
        return float("nan")
    return float(adjusted(surrogate, truth, weight).mean())


def adjusted(surrogate: FloatArray, truth: FloatArray, weight: FloatArray) -> FloatArray:
    """Return one corrected value per text, (n,): surrogate + (truth - surrogate) x weight. Take the mean over texts.

    Source: Särndal, Swensson and Wretman 1992, the difference estimator.
    """
    return np.where(np.isnan(truth), surrogate, surrogate + (truth - surrogate) * weight)
