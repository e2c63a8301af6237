"""Declares comparisons of a probe before or with its analysis, by naming models and edits."""

import datetime
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import BoolArray
from analysis.lines import COMPLETE
from analysis.load import status
from analysis.planned.holding import PlanCheck, made_late, other_versions, plan_alone
from analysis.probes.choices import NONE, Answers, Subject
from analysis.probes.comparing import ALL
from analysis.stats.contrasts import ALPHA
from analysis.stats.plan import Plan
from analysis.stats.testing import holm
from foundry.errors import InputError, not_found
from foundry.naming import names_of
from foundry.storing.preregistration import PlannedCondition, PlannedLook, PlannedMeasure, Preregistration
from foundry.storing.store import SweepFolder
from foundry.texts import counted

METHOD = (
    "Total variation between the choices in the same moments, less its floor by chance. One-sided exact sign-flip "
    "test of its mean over seeds (9,999 random signs above 16 seeds), corrected by Holm's method over the declared "
    "pairs of models and edits."
)
LEFT_OUT = (
    "A moment that was not asked of both sides, or that an edit does not change.",
    "Pairs of models and edits that are not named here, formats and curves: they are exploratory.",
)


@dataclass(frozen=True)
class Family:
    """The declared models and edits; if none are declared, every comparison counts as declared."""

    models: frozenset[str] = frozenset()
    edits: frozenset[str] = frozenset()

    @property
    def is_given(self) -> bool:
        """True if models or edits are declared."""
        return bool(self.models or self.edits)

    @classmethod
    def of(cls, names: Sequence[str], answers: Answers) -> "Family":
        """Return the family of tests that is declared by these names of models and edits of a recorded probe."""
        return cls.named(names, answers.names, [change.name for change in answers.changes.values() if change.is_edit])

    @classmethod
    def named(cls, names: Sequence[str], subjects: Mapping[Subject, str], edits: Sequence[str]) -> "Family":
        """Return the family of tests that is declared by these names of models and edits.

        Name a model as in the tables, or by its tag alone.

        Raises:
            InputError: a name is neither a model nor an edit of this probe.
        """
        models = {shown: {shown} for shown in subjects.values()}
        for subject, shown in subjects.items():
            models.setdefault(subject.model, set()).add(shown)
        for name in names:
            if name not in models and name not in edits:
                raise not_found("Model or edit of this probe", name, [*models, *edits])
        chosen = frozenset(shown for name in names for shown in models.get(name, ()))
        return cls(chosen, frozenset(names) & frozenset(edits))

    def holds(self, row: Mapping[Any, Any]) -> bool:
        """Return whether a row is declared.

        A pair of models is declared if both are declared, or if the only declared model is one of them. If only edits
        are declared, no pair is. Any other row is declared if its model is, and its edit, if it has one.
        """
        if "first" in row:
            models = {row["first"], row["second"]}
            return len(models & self.models) == min(len(self.models), 2) if self.models else not self.edits
        edit = row.get("edit")
        is_of_model = not self.models or row["model"] in self.models
        return is_of_model and (edit is None or not self.edits or edit in self.edits)

    def rows(self, frame: pd.DataFrame) -> BoolArray:
        """Return whether each row of a table is declared, (rows,).

        A row with a distance is declared only if the distance is over all kinds of question.
        """
        declared = np.array([self.holds(row) for row in frame.to_dict("records")], dtype=np.bool_)
        return declared & (frame["kind"] == ALL).to_numpy() if "distance" in frame else declared

    def correct(self, *frames: pd.DataFrame) -> None:
        """Correct the p values of the declared rows by Holm's method, and write them into the column `p_holm`.

        If models or edits are declared, all tables are corrected together, otherwise each table by itself.
        """
        rows = [self.rows(frame) for frame in frames]
        p = [frame["p"].to_numpy(dtype=np.float64)[own] for frame, own in zip(frames, rows, strict=True)]
        ends = np.cumsum([len(own) for own in p])[:-1]
        corrected = np.split(holm(np.concatenate(p)), ends) if self.is_given else map(holm, p)
        for frame, own, adjusted in zip(frames, rows, corrected, strict=True):
            frame.loc[own, "p_holm"] = adjusted

    def note(self, agreement: pd.DataFrame, edits: pd.DataFrame) -> list[str]:
        """Return a note with the number of rows over which p is corrected; none if no family is given."""
        if not self.is_given:
            return []
        rows = counted(int(agreement["p_holm"].notna().sum() + edits["p_holm"].notna().sum()), "row")
        names = ", ".join([*sorted(self.models), *sorted(self.edits)])
        return [
            f"family {names}: p is corrected over {rows} in the tables of agreement and edits; rows outside the "
            "family are exploratory; in tables of choices, p is corrected over the rows of the family"
        ]


EVERYTHING = Family()
"""The family without declared models or edits: p values are corrected over all rows of a table."""


def declared_probe(
    conditions: Sequence[PlannedCondition], configs: Sequence[Mapping[str, Any]], names: Sequence[str], **said: Any
) -> Preregistration:
    """Return the preregistration of a probe.

    Args:
        conditions: conditions of the probe; the settings of their worlds include edits and the hash of the moments.
        configs: configuration of each condition.
        names: models and edits to declare.
        **said: further fields of `Preregistration`: `foundry`, `commit`, `asked`, `models`, `answers_known`,
            `runs_known`.

    Raises:
        InputError: a name is not a model or edit of the probe, nothing is named, or nothing is compared.
    """
    if not names:
        raise InputError("Nothing is declared: name a model or an edit of the probe with --family, such as no_fire.")
    subjects = names_of(Subject.of(config) for config in configs)
    edits = [config["world"]["edit"] for config in configs]
    edited = list(dict.fromkeys(edit["name"] for edit in edits if edit["name"] != NONE and not edit.get("moves")))
    family = Family.named(names, subjects, edited)
    pairs = [{"first": first, "second": other} for first, other in itertools.combinations(subjects.values(), 2)]
    changes = [{"model": model, "edit": edit} for model in subjects.values() for edit in edited]
    counts = {"pairs of models": sum(map(family.holds, pairs)), "edits": sum(map(family.holds, changes))}
    tests = {what: count for what, count in counts.items() if count}
    if not tests:
        raise InputError(f"The probe has nothing to compare with {', '.join(names)}: use two models, or an edit.")
    seeds = list(dict.fromkeys(seed for condition in conditions for seed in condition.runs.values()))
    return Preregistration(
        made=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        conditions=list(conditions),
        seeds=seeds,
        measures=[PlannedMeasure(name=name, margin=None, code_sha256={}) for name in names],
        tests=tests,
        method=METHOD,
        alpha=ALPHA,
        looks=[PlannedLook(seeds=len(seeds), alpha=ALPHA, alpha_in_family=ALPHA / sum(tests.values()))],
        left_out=list(LEFT_OUT),
        **said,
    )


def held_probe(folder: SweepFolder, asked: Sequence[str]) -> tuple[PlanCheck | None, list[str]]:
    """Return the plan of a probe, compared with its runs, and notes on a plan that cannot be used.

    Args:
        folder: the probe.
        asked: models and edits that the user named with the analysis, which is an error if there is a plan.

    Raises:
        InputError: there is a plan, but the user named models or edits.
        RecordError: the plan cannot be read.
    """
    if late := made_late(folder):
        return None, [late]
    plan_and_hash = plan_alone(folder, asked=bool(asked))
    if plan_and_hash is None:
        return None, []
    declared, sha256 = plan_and_hash
    names, looks = tuple(measure.name for measure in declared.measures), tuple(look.seeds for look in declared.looks)
    plan = Plan(names, frozenset(), looks, tuple(declared.seeds), reached=1, known=declared.known)
    return PlanCheck(declared, sha256, plan, tuple(_differences(declared, folder))), []


def _differences(plan: Preregistration, folder: SweepFolder) -> Iterator[str]:
    runs = {run.id: run for run in folder.runs()}
    complete = sum(status(run, run.summary()) == COMPLETE for run in runs.values() if run.id in plan.runs)
    if complete < len(plan.runs):
        yield f"{len(plan.runs) - complete} of {len(plan.runs)} runs are incomplete"
    if further := runs.keys() - plan.runs.keys():
        yield f"the tests include {counted(len(further), 'run')} outside the plan"
    yield from other_versions(plan, folder)
