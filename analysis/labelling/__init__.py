"""Who says which messages are warnings: the rule, or a model; and how well each agrees with people.

The rule is `analysis.warning_rule`. A model's labels are those that `foundry label` keeps in a sweep's folder. Both are
held against the held-out texts of `hand_labelled.jsonl`, labelled by hand after the definition in `question.txt`: long
messages as agents write them, in several languages. Its other texts, short and hard ("is there a fire?"), are those
that the rule was tuned on; agreement with them says nothing of other texts.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from typing import Literal

import msgspec
import numpy as np

from analysis.agreement import cohen_kappa
from analysis.camera_run import CameraRun
from analysis.formulas import mean
from analysis.run import GridRun
from analysis.warning_rule import RULE_VERSION, is_warning
from foundry.errors import InputError
from foundry.records import Labelled
from foundry.store import SweepFolder

FIRES = ("fire1",)
"""Names of fires in the texts that were labelled by hand."""


TextSet = Literal["tuning", "held_out"]
"""What a text that was labelled by hand is for."""


class HandLabelled(msgspec.Struct, frozen=True):
    """A text that was labelled by hand, what it is for, and the code of its language."""

    set: TextSet
    language: str
    text: str
    warning: bool


@dataclass(frozen=True)
class Agreement:
    """How well a labeller agrees with people.

    Attributes:
        texts: number of texts.
        unlabelled: those that the labeller gave no label; left out of the rest.
        accuracy: share of equal labels, 0..1.
        kappa: Cohen's, -1..1.
    """

    texts: int
    unlabelled: int
    accuracy: float
    kappa: float


@dataclass(frozen=True)
class Labelling:
    """A labeller and what it says.

    Attributes:
        labeller: what it is, for people.
        version: changes whenever any label could be another one.
        agreement: with people.
        by_fires: labels by text, by the names of the world's fires; None for the rule, which needs no list.
    """

    labeller: str
    version: str
    agreement: Agreement
    by_fires: Mapping[tuple[str, ...], Mapping[str, bool]] | None = None

    def label(self, run: GridRun | CameraRun) -> GridRun | CameraRun:
        """Return the run with its messages labelled; one of a 3D world, where nobody talks, as it is."""
        if self.by_fires is None or not isinstance(run, GridRun):
            return run
        fires = tuple(fire.name for fire in run.world.fires)
        return replace(run, labels=self.by_fires.get(fires, {}))

    def note(self) -> str:
        """Return one line for the readers of tables."""
        found = self.agreement
        missing = f" ({found.unlabelled} without a label)" if found.unlabelled else ""
        return (
            f"warnings by {self.labeller}: accuracy {found.accuracy:.2f}, Cohen's kappa {found.kappa:.2f} on "
            f"{found.texts} held-out texts labelled by hand{missing}"
        )


@lru_cache(maxsize=2)
def hand_labelled(which: TextSet = "held_out") -> tuple[HandLabelled, ...]:
    """Return the texts of a set that were labelled by hand; agreement is that on the held-out ones."""
    content = files(__name__).joinpath("hand_labelled.jsonl").read_bytes()
    return tuple(one for one in msgspec.json.Decoder(HandLabelled).decode_lines(content) if one.set == which)


def question() -> str:
    """Return the template of the question to a model, with `$message` and `$fires`."""
    return files(__name__).joinpath("question.txt").read_text(encoding="utf-8")


def rule_labelling() -> Labelling:
    """Return the rule."""
    agreed = agreement([is_warning(one.text, FIRES) for one in hand_labelled()])
    return Labelling(f"rule {RULE_VERSION}", f"rule {RULE_VERSION}", agreed)


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
    """Return how well labels of the held-out texts, in their order, agree with people; None is no label."""
    pairs = [(label, one.warning) for label, one in zip(labels, hand_labelled(), strict=True) if label is not None]
    given, truth = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return Agreement(len(labels), len(labels) - len(pairs), mean(given == truth), cohen_kappa(given, truth))


def _in_order(labelled: Sequence[Labelled]) -> list[bool | None]:
    """Return the labels of the held-out texts as they are now; one that was added since has none."""
    by_text = {one.text: one.warning for one in labelled}
    return [by_text.get(one.text) for one in hand_labelled()]
