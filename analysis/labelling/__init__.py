"""Labels of warnings: a rule or a model decides which messages are warnings, and labels by people correct the result.

The rule is in the module `warning_rule`. A model's labels are written by `foundry label` into a sweep's folder. The
labels of the rule and of the model are compared with the labels in `hand_labelled.jsonl`. The texts in this file were
labelled one by one with the question of the label `warning`. Only the held-out texts count for accuracy: they were
written independently of the rule, and nobody looked at them to change the rule. `TEXTS_BY` says who wrote and labelled
the texts. Agreement with texts that are not held out says little about new texts, above all agreement with the texts
that were used to tune the rule.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib.resources import files
from typing import Literal

import msgspec
import numpy as np

from analysis.agreement import Interval, cohen_kappa, kappa_interval
from analysis.formulas import ratio
from analysis.labelling.correcting import Correction, correction_of
from analysis.labelling.own_label import OwnLabel
from analysis.labelling.warning_rule import RULE_VERSION
from foundry.errors import InputError
from foundry.labels.definition import YES, Label, label_files, label_named
from foundry.labels.folder import Judge, Judgement, LabelFolder, label_names
from foundry.labels.items import content_of
from foundry.storing.store import SweepFolder

WARNING, SIGHT_CLAIM = "warning", "sight_claim"
BUILT_IN = (WARNING, SIGHT_CLAIM)
"""Labels from which shipped signatures compute their measures; every other label is a signature of its own."""

FIRES = ("fire1", "fire2", "east_fire")
"""Names of the fires of the worlds to which the hand-labelled texts refer."""

TEXTS_BY = (
    "these values are upper bounds, because one language model wrote and labelled these texts in the styles of many "
    "writers; the accuracy for the messages of this sweep is unknown"
)
"""A note that says who wrote the held-out texts, and why precision and recall are therefore upper bounds."""

NO_CORRECTION = " (not corrected by people's labels)"
"""A note for a measure that cannot be corrected, beside corrected measures of the same label."""

TextSet = Literal["tuning", "held_out"]
"""The use of a hand-labelled text: to tune the rule, or only to test it."""

Writing = Literal["beside_rule", "apart"]
"""The origin of a text: written by the rule's author, or independently of the rule in the styles of many writers."""


class HandLabelled(msgspec.Struct, frozen=True):
    """A text that was labelled by hand, with the use (`TextSet`) and the origin (`Writing`) of the text."""

    set: TextSet
    written: Writing
    language: str
    text: str
    warning: bool
    style: str = ""


@dataclass(frozen=True)
class Agreement:
    """How well the labels of a rule or a model agree with labels by hand, as numbers of texts.

    Attributes:
        unlabelled: texts that the rule or the model left without a label; the numbers below leave them out.
        false_warnings: other texts that were labelled as warnings.
    """

    texts: int
    unlabelled: int
    true_warnings: int
    false_warnings: int
    missed: int
    kappa: float
    interval: Interval

    @property
    def is_better_than_chance(self) -> bool:
        """True if the whole interval of Cohen's kappa is above 0."""
        return self.interval.low > 0

    @property
    def precision(self) -> float:
        """Of the texts that the rule or model labels as warnings, the share that are warnings by hand, 0..1."""
        return ratio(self.true_warnings, self.true_warnings + self.false_warnings)

    @property
    def recall(self) -> float:
        """Of the texts that are warnings by hand, the share that the rule or model labels as warnings, 0..1."""
        return ratio(self.true_warnings, self.true_warnings + self.missed)

    def __str__(self) -> str:
        called, are = self.true_warnings + self.false_warnings, self.true_warnings + self.missed
        return (
            f"precision {self.precision:.2f} ({self.true_warnings} of {called}), "
            f"recall {self.recall:.2f} ({self.true_warnings} of {are}), Cohen's kappa {self.kappa:.2f}"
        )


RULE_AGREEMENT = Agreement(
    texts=131,
    unlabelled=47,
    true_warnings=38,
    false_warnings=4,
    missed=4,
    kappa=0.8095238095238095,
    interval=Interval(0.6810738235238813, 0.9379737955237377),
)
"""Agreement of the rule's labels with labels by hand, on texts that were not used to write the rule.

A test checks the numbers of this agreement, because computing them takes a second.
"""


@dataclass(frozen=True)
class Reading:
    """Who labelled the texts behind a measure.

    Attributes:
        short: in a word or two, such as `rule 4` or `corrected`.
        text: in full, such as `as labelled by rule 4`.
    """

    short: str
    text: str


@dataclass(frozen=True)
class Labelling:
    """A labeller (the rule or a model) with its labels of messages.

    Attributes:
        labeller: the rule, or the model with its digest and question.
        version: a hash or rule number; it changes whenever a label may change.
        by_fires: labels of texts, by the names of the world's fires; None for the rule, which computes them.
        name: short name of the labeller, if it differs.
        unlabelled: the reason why a message may have no label.
        corrections: corrections of measures by people's labels, by the name of a label.
        why: the reason why people's labels correct nothing, by the name of a label.
    """

    labeller: str
    version: str
    agreement: Agreement
    by_fires: Mapping[tuple[str, ...], Mapping[str, bool]] | None = None
    name: str = ""
    unlabelled: str = "the model was not asked, or answered neither yes nor no"
    corrections: Mapping[str, Correction] = field(default_factory=dict)
    why: Mapping[str, str] = field(default_factory=dict)
    own: tuple[OwnLabel, ...] = ()

    def note(self) -> str:
        """Return a note: who labelled messages as warnings, and how accurate these labels are."""
        agreement = self.agreement
        missing = (
            f", {agreement.unlabelled} of them without a label because {self.unlabelled}"
            if agreement.unlabelled
            else ""
        )
        said = f"{self._whose()}: {agreement} on {agreement.texts} held-out texts{missing}; {TEXTS_BY}"
        return "; ".join(filter(None, [self.doubt(), said, self._uncorrected()]))

    def brief(self) -> str:
        """Return a short note: who labelled messages as warnings, and how accurate these labels are."""
        agreement = self.agreement
        said = f"precision at most {agreement.precision:.2f}, recall at most {agreement.recall:.2f}"
        return "; ".join(filter(None, [self.doubt(), f"{self._whose()}: {said}", self._uncorrected()]))

    def reading(self, label: str, *, corrected: bool, correctable: bool) -> Reading:
        """Return who labelled the texts of a measure: a rule or a model, perhaps corrected by people.

        Args:
            label: name of the label.
            corrected: whether labels of people correct the measure, if there are any.
            correctable: whether the measure, or the measure next to which it is shown, has a correction.
        """
        if corrected and label in self.corrections:
            return Reading("corrected", self.corrections[label].note())
        judge = next((own.judge for own in self.own if own.label.name == label), "")
        short, full = (self.name or self.labeller, self.labeller) if label == WARNING else (judge or "the rule",) * 2
        note = "" if correctable or label not in self.corrections else NO_CORRECTION
        return Reading(short, f"as labelled by {full}{note}")

    def _whose(self) -> str:
        correction, labels = self.corrections.get(WARNING), f"labels of warnings by {self.labeller}"
        return labels if correction is None else f"warnings are {correction.note()}; {labels}, without this correction"

    def _uncorrected(self) -> str:
        return f"not corrected by people's labels, because {self.why[WARNING]}" if WARNING in self.why else ""

    def doubt(self) -> str:
        """Return the reason why the measures of warnings cannot be trusted, or "" if they can."""
        agreement = self.agreement
        if agreement.is_better_than_chance or WARNING in self.corrections:
            return ""
        interval = f"{agreement.kappa:.2f} [{agreement.interval.low:.2f}, {agreement.interval.high:.2f}]"
        return f"the labels of {self.labeller} are not better than chance (Cohen's kappa {interval})"


@lru_cache(maxsize=4)
def hand_labelled(which: TextSet = "held_out", written: Writing = "apart") -> tuple[HandLabelled, ...]:
    """Return the hand-labelled texts of one use and origin; by default, the texts with which labellers are compared."""
    content = files(__name__).joinpath("hand_labelled.jsonl").read_bytes()
    texts = msgspec.json.Decoder(HandLabelled).decode_lines(content)
    return tuple(text for text in texts if (text.set, text.written) == (which, written))


def rule_labelling() -> Labelling:
    """Return the rule as labeller of warnings, with its accuracy."""
    version = f"rule {RULE_VERSION}"
    return Labelling(version, version, RULE_AGREEMENT, unlabelled="the rule covers only English and Japanese")


def labelling_of(sweep: SweepFolder, *, by_model: bool = False) -> Labelling:
    """Return the labels of a sweep's texts, with corrections if people labelled enough of the texts.

    Args:
        sweep: the sweep.
        by_model: whether the labels are those of a model instead of a rule.

    Raises:
        InputError: no model has labelled the messages of the sweep.
        RecordError: the labels cannot be read.
    """
    surrogate = _model_labelling(sweep) if by_model else rule_labelling()
    known = (label_named(name) for name in label_names(sweep) if name in label_files())
    labels = [label for label in known if label.choices]
    corrected = {label.name: correction_of(sweep, label) for label in labels}
    own = tuple(
        _own_label(sweep, label, corrected[label.name].correction, by_model=by_model)
        for label in labels
        if label.name not in BUILT_IN
    )
    corrections = {name: result.correction for name, result in corrected.items() if result.correction is not None}
    versions = [*(correction.version for correction in corrections.values()), *(own_label.version for own_label in own)]
    return replace(
        surrogate,
        version=" ".join([surrogate.version, *versions]),
        corrections=corrections,
        why={name: result.why for name, result in corrected.items() if result.why},
        own=own,
    )


def _model_labelling(sweep: SweepFolder) -> Labelling:
    judge = judge_of(sweep, label_named(WARNING))
    if judge is None:
        raise InputError(
            f"No model has labelled the messages of '{sweep.path}': run foundry label {sweep.path} --model <name> "
            "first, or use the rule."
        )
    by_fires: dict[tuple[str, ...], dict[str, bool]] = {}
    for judgement in judge.judgements:
        if judgement.label is not None:
            by_fires.setdefault(tuple(judgement.context["fires"]), {})[judgement.text] = judgement.label == YES
    version = hashlib.sha256(msgspec.json.encode(judge)).hexdigest()[:16]
    digest = f" ({judge.digest[:12]})" if judge.digest else ""
    labeller = f"{judge.labeller}{digest}, question {judge.question_sha256[:8]}"
    return Labelling(labeller, f"model {version}", agreement(_in_order(judge.by_hand)), by_fires, judge.labeller)


def judge_of(sweep: SweepFolder, label: Label) -> Judge | None:
    """Return the labels of the model that last labelled a sweep's texts with the label's current question, or None."""
    judges = LabelFolder.of(sweep, label.name).judges()
    return next((judge for judge in judges if judge.question_sha256 == label.question_sha256), None)


def _own_label(sweep: SweepFolder, label: Label, correction: Correction | None, *, by_model: bool) -> OwnLabel:
    """Return a label with its own signature.

    Labels that a model gave are used if `by_model` is true, or if no rule exists for this label.
    """
    judge = judge_of(sweep, label) if by_model or not label.rule else None
    if judge is None:
        return OwnLabel(label, "", None, correction)
    judged = {
        content_of(judgement.text, judgement.context): judgement.label
        for judgement in judge.judgements
        if judgement.label is not None
    }
    return OwnLabel(label, judge.labeller, judged, correction)


def agreement(labels: Sequence[bool | None]) -> Agreement:
    """Compare labels of the held-out texts, given in the texts' order, with the labels by hand; None means no label."""
    pairs = [
        (label, labelled.warning) for label, labelled in zip(labels, hand_labelled(), strict=True) if label is not None
    ]
    given, truth = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return Agreement(
        texts=len(labels),
        unlabelled=len(labels) - len(pairs),
        true_warnings=int((given & truth).sum()),
        false_warnings=int((given > truth).sum()),
        missed=int((given < truth).sum()),
        kappa=cohen_kappa(given, truth),
        interval=kappa_interval(given, truth),
    )


def _in_order(judged: Sequence[Judgement]) -> list[bool | None]:
    """Return a model's label for each held-out text; None for a text that was added after the model labelled."""
    by_text = {judgement.text: None if judgement.label is None else judgement.label == YES for judgement in judged}
    return [by_text.get(labelled.text) for labelled in hand_labelled()]
