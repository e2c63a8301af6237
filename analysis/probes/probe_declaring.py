"""Which comparisons of a probe claims may rest on: those of the models and edits that are declared beforehand."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.arrays import BoolArray, FloatArray
from analysis.probes.choices import Answers, Change, Subject
from analysis.probes.comparing import ALL
from analysis.stats.multiplicity import holm
from foundry.errors import not_found
from foundry.texts import counted


@dataclass(frozen=True)
class Family:
    """The models and edits that are declared; nothing of both is all of them.

    Attributes:
        models: their names in the tables.
        edits: their names.
    """

    models: frozenset[str] = frozenset()
    edits: frozenset[str] = frozenset()

    @property
    def is_given(self) -> bool:
        """Whether anything is declared."""
        return bool(self.models or self.edits)

    @classmethod
    def of(cls, names: Sequence[str], answers: Answers) -> Family:
        """Return the family that these names declare; see `named`."""
        return cls.named(names, answers.names, [change.name for change in answers.changes.values() if change.is_edit])

    @classmethod
    def named(cls, names: Sequence[str], subjects: Mapping[Subject, str], edits: Sequence[str]) -> Family:
        """Return the family that these names declare; a model is named by itself, or as in the tables.

        Args:
            names: of models and edits.
            subjects: what each subject is called in the tables.
            edits: the names of the edits.

        Raises:
            InputError: one is neither a model nor an edit of this probe.
        """
        models = {shown: {shown} for shown in subjects.values()}
        for subject, shown in subjects.items():
            models.setdefault(subject.model, set()).add(shown)
        for name in names:
            if name not in models and name not in edits:
                raise not_found("Model or edit of this probe", name, [*models, *edits])
        chosen = frozenset(shown for name in names for shown in models.get(name, ()))
        return cls(chosen, frozenset(names) & frozenset(edits))

    def rows(self, frame: pd.DataFrame) -> BoolArray:
        """Return which rows of a table are declared (rows,)."""
        is_pair = "first" in frame
        names = zip(*(frame[name] for name in (("first", "second") if is_pair else ("model", "edit"))), strict=True)
        declared = [self.holds_pair(set(pair)) if is_pair else self.holds_edit(*pair) for pair in names]
        return (frame["kind"] == ALL).to_numpy(dtype=np.bool_) & np.array(declared, dtype=np.bool_)

    def correct(self, agreement: pd.DataFrame, edits: pd.DataFrame) -> None:
        """Fill `p_holm`: over each table, or over all that is declared where anything is."""
        pairs, edited = self.rows(agreement), self.rows(edits)
        p = [frame.loc[rows, "p"].to_numpy(dtype=np.float64) for frame, rows in ((agreement, pairs), (edits, edited))]
        found = np.split(holm(np.concatenate(p)), [len(p[0])]) if self.is_given else [holm(p[0]), holm(p[1])]
        agreement.loc[pairs, "p_holm"], edits.loc[edited, "p_holm"] = found

    def choices(self, frame: pd.DataFrame) -> BoolArray:
        """Return which rows of a table of choices are declared (rows,): by model and edit, without edits by model."""
        if "edit" in frame:
            declared = [self.holds_edit(*row) for row in zip(frame["model"], frame["edit"], strict=True)]
        else:
            declared = [not self.models or model in self.models for model in frame["model"]]
        return np.array(declared, dtype=np.bool_)

    def corrected(self, frame: pd.DataFrame) -> FloatArray:
        """Return p after Holm's correction over the declared rows of a table of choices (rows,); NaN elsewhere."""
        return holm(np.where(self.choices(frame), frame["p"].to_numpy(dtype=np.float64), np.nan))

    def note(self, agreement: pd.DataFrame, edits: pd.DataFrame) -> list[str]:
        """Return the line that says over how many rows p is corrected; none where nothing is declared."""
        if not self.is_given:
            return []
        rows = counted(int(agreement["p_holm"].notna().sum() + edits["p_holm"].notna().sum()), "row")
        names = ", ".join([*sorted(self.models), *sorted(self.edits)])
        return [
            f"family {names}: p is corrected over {rows} of both tables, all others are exploratory; in tables of "
            "choices p is corrected over the rows of this family"
        ]

    def pairs(self, answers: Answers) -> list[tuple[Subject, Subject]]:
        """Return the declared pairs: those of a declared model, of two where several are; none with edits alone."""
        pairs = itertools.combinations(answers.names, 2)
        return [pair for pair in pairs if self.holds_pair({answers.names[one] for one in pair})]

    def edited(self, answers: Answers) -> list[tuple[Subject, Change]]:
        """Return the declared edits of each subject: declared edits of declared models."""
        return [
            (subject, change)
            for subject, change in answers.edited()
            if self.holds_edit(answers.names[subject], change.name)
        ]

    def holds_pair(self, models: set[str]) -> bool:
        """Return whether the pair of these two models is declared."""
        if not self.models:
            return not self.edits
        return len(models & self.models) == min(len(self.models), 2)

    def holds_edit(self, model: str, edit: str) -> bool:
        """Return whether an edit of a model is declared."""
        return (not self.models or model in self.models) and (not self.edits or edit in self.edits)


EVERYTHING = Family()
"""Nothing is declared, so that p is corrected over all rows."""
