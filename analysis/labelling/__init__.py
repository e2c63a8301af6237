"""Who says which messages are warnings: the rule, or a model; and how well each agrees with labels given by reading.

The rule is `warning_rule`. A model's labels are those that `foundry label` keeps in a sweep's folder. Both are
held against texts of `hand_labelled.jsonl`, labelled one by one after the definition in `question.txt`: those that were
held out, so that nobody saw them while the rule was changed, and written apart from the rule. `TEXTS_BY` says whose
they are. Agreement with the others, those for tuning above all, says nothing of other texts.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Literal

import msgspec
import numpy as np

from analysis.agreement import Interval, cohen_kappa, kappa_interval
from analysis.formulas import ratio
from analysis.labelling.warning_rule import RULE_VERSION, is_warning
from foundry.errors import InputError
from foundry.labels import Labelled
from foundry.storing.store import SweepFolder

FIRES = ("fire1", "fire2", "east_fire")
"""Names of fires in the texts that were labelled by hand."""

TEXTS_BY = (
    "an upper bound: one language model wrote and labelled these texts, imitating many writers; how well it holds for "
    "the messages of this sweep is not known"
)
"""Whose the held-out texts are, and what that means for the figures."""

TextSet = Literal["tuning", "held_out"]
"""What a text that was labelled by hand is for."""

Writing = Literal["beside_rule", "apart"]
"""How a text came to be: beside the rule, by its author, or apart from it, in the styles of many writers."""


class HandLabelled(msgspec.Struct, frozen=True):
    """A text that was labelled one by one: what it is for, how it came to be, its language by code, and its style."""

    set: TextSet
    written: Writing
    language: str
    text: str
    warning: bool
    style: str = ""


@dataclass(frozen=True)
class Agreement:
    """How well a labeller agrees with labels that were given by reading.

    Attributes:
        texts: number of texts.
        unlabelled: those that the labeller gave no label; left out of the rest.
        true_warnings: warnings that it calls warnings.
        false_warnings: others that it calls warnings.
        missed: warnings that it does not call warnings.
        kappa: Cohen's, -1..1.
        interval: that of kappa over the texts.
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
        """Whether the interval of kappa lies above 0."""
        return self.interval.low > 0

    @property
    def precision(self) -> float:
        """Share of what it calls warnings that are some, 0..1."""
        return ratio(self.true_warnings, self.true_warnings + self.false_warnings)

    @property
    def recall(self) -> float:
        """Share of the warnings that it calls so, 0..1."""
        return ratio(self.true_warnings, self.true_warnings + self.missed)

    def __str__(self) -> str:
        called, are = self.true_warnings + self.false_warnings, self.true_warnings + self.missed
        return (
            f"precision {self.precision:.2f} ({self.true_warnings} of {called}), "
            f"recall {self.recall:.2f} ({self.true_warnings} of {are}), Cohen's kappa {self.kappa:.2f}"
        )


@dataclass(frozen=True)
class Labelling:
    """A labeller and what it says.

    Attributes:
        labeller: what it is, for people.
        version: changes whenever any label could be another one.
        agreement: with labels given by reading.
        by_fires: labels by text, by the names of the world's fires; None for the rule, which needs no list.
        unlabelled: why a message may have no label.
    """

    labeller: str
    version: str
    agreement: Agreement
    by_fires: Mapping[tuple[str, ...], Mapping[str, bool]] | None = None
    unlabelled: str = "not asked about, or answered with neither yes nor no"

    def note(self) -> str:
        """Return one line for the readers of tables."""
        found = self.agreement
        missing = f", {found.unlabelled} of them without a label ({self.unlabelled})" if found.unlabelled else ""
        said = f"warnings by {self.labeller}: {found} on {found.texts} held-out texts{missing}; {TEXTS_BY}"
        return "; ".join(filter(None, [self.doubt(), said]))

    def brief(self) -> str:
        """Return the same in short."""
        found = self.agreement
        said = f"precision at most {found.precision:.2f}, recall at most {found.recall:.2f}"
        return "; ".join(filter(None, [self.doubt(), f"warnings by {self.labeller}: {said}"]))

    def doubt(self) -> str:
        """Return why no measure of warnings can be trusted; "" where the labeller agrees better than chance does."""
        found = self.agreement
        if found.is_better_than_chance:
            return ""
        interval = f"{found.kappa:.2f} [{found.interval.low:.2f}, {found.interval.high:.2f}]"
        return f"labels of {self.labeller} are not shown to be better than chance (Cohen's kappa {interval})"


@lru_cache(maxsize=4)
def hand_labelled(which: TextSet = "held_out", written: Writing = "apart") -> tuple[HandLabelled, ...]:
    """Return the texts of a set that were labelled by hand; agreement is that on the held-out ones written apart."""
    content = files(__name__).joinpath("hand_labelled.jsonl").read_bytes()
    texts = msgspec.json.Decoder(HandLabelled).decode_lines(content)
    return tuple(one for one in texts if (one.set, one.written) == (which, written))


def question() -> str:
    """Return the template of the question to a model, with `$message` and `$fires`."""
    return files(__name__).joinpath("question.txt").read_text(encoding="utf-8")


def reading_question() -> str:
    """Return the template of the question what a reply decides, with `$reply` and `$options`."""
    return files(__name__).joinpath("reading.txt").read_text(encoding="utf-8")


def rule_labelling() -> Labelling:
    """Return the rule."""
    agreed = agreement([is_warning(one.text, FIRES) for one in hand_labelled()])
    version = f"rule {RULE_VERSION}"
    return Labelling(version, version, agreed, unlabelled="in neither English nor Japanese")


def model_labelling(sweep: SweepFolder) -> Labelling:
    """Return what a model says of the messages of a sweep.

    Raises:
        InputError: no model has labelled them.
        RecordError: the labels cannot be read.
    """
    kept = sweep.labels()
    if kept is None:
        raise InputError(
            f"No model has labelled the messages of '{sweep.path}': "
            f"run foundry label {sweep.path} --model <name> first, or take the rule."
        )
    by_fires: dict[tuple[str, ...], dict[str, bool]] = {}
    for one in kept.labels:
        if one.warning is not None:
            by_fires.setdefault(one.fires, {})[one.text] = one.warning
    version = hashlib.sha256(msgspec.json.encode(kept)).hexdigest()[:16]
    digest = f" ({kept.digest[:12]})" if kept.digest else ""
    labeller = f"{kept.labeller}{digest}, question {kept.question_sha256[:8]}"
    return Labelling(labeller, f"model {version}", agreement(_in_order(kept.hand_labelled)), by_fires)


def agreement(labels: Sequence[bool | None]) -> Agreement:
    """Return how well labels of the held-out texts, in their order, agree with those given; None is no label."""
    pairs = [(label, one.warning) for label, one in zip(labels, hand_labelled(), strict=True) if label is not None]
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


def _in_order(labelled: Sequence[Labelled]) -> list[bool | None]:
    """Return the labels of the held-out texts as they are now; one that was added since has none."""
    by_text = {one.text: one.warning for one in labelled}
    return [by_text.get(one.text) for one in hand_labelled()]
