"""A label with a signature of its own, which measures the share of each choice."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from analysis.labelling.correcting import Correction
from foundry.labels.definition import Label


@dataclass(frozen=True)
class OwnLabel:
    """A label with a signature of its own, which measures the share of each choice.

    Attributes:
        judge: name of the model that labelled the texts; "" if the rule labels them.
        judged: labels of the model, by the content that it saw; None if the rule labels the texts.
        correction: correction by people's labels, if there are enough.
    """

    label: Label
    judge: str
    judged: Mapping[bytes, str] | None
    correction: Correction | None

    @property
    def has_surrogate(self) -> bool:
        """True if a rule or a model labels all texts."""
        return self.judged is not None or bool(self.label.rule)

    @property
    def version(self) -> str:
        """A hash that changes whenever a label of a text may change."""
        content = msgspec.json.encode((self.label, sorted((self.judged or {}).items())))
        corrected = self.correction.version if self.correction else ""
        return hashlib.sha256(content).hexdigest()[:16] + corrected
