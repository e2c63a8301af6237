"""A label whose shares are a signature of their own."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from analysis.labelling.correcting import Correction
from foundry.labels.definition import Label


@dataclass(frozen=True)
class OwnLabel:
    """A label whose shares are a signature of their own.

    Attributes:
        label: the label.
        judge: name of the model that labelled the texts; "" where the rule does.
        judged: what a model says of each text, by all that it was shown; None where the rule is asked.
        correction: the labels of people; None where there are none, or too few.
    """

    label: Label
    judge: str
    judged: Mapping[bytes, str] | None
    correction: Correction | None

    @property
    def has_surrogate(self) -> bool:
        """Whether a rule or a model labels all texts."""
        return self.judged is not None or bool(self.label.rule)

    @property
    def version(self) -> str:
        """Changes whenever any label could be another one."""
        content = msgspec.json.encode((self.label, sorted((self.judged or {}).items())))
        corrected = self.correction.version if self.correction else ""
        return hashlib.sha256(content).hexdigest()[:16] + corrected
