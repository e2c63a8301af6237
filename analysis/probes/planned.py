"""What is declared before a probe, and how its runs are held against it."""

from __future__ import annotations

import datetime
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.lines import COMPLETE
from analysis.load import status
from analysis.planned.holding import made_late, other_versions
from analysis.probes.choices import NONE, Subject
from analysis.probes.probe_declaring import Family
from analysis.stats.contrasts import ALPHA
from foundry.errors import InputError
from foundry.naming import names_of
from foundry.storing.preregistration import (
    PREREGISTRATION_FILE,
    PlannedCondition,
    PlannedLook,
    PlannedMeasure,
    Preregistration,
    preregistration_of,
)
from foundry.storing.store import SweepFolder

METHOD = (
    "Total variation between the choices in the same moments, less what one chance would give. One-sided exact "
    "sign-flip test of its mean over seeds (9,999 drawn signs above 16 seeds), corrected by Holm's method over the "
    "declared pairs of models and edits."
)
LEFT_OUT = (
    "A moment that was not asked of both sides, or that an edit does not change.",
    "Pairs of models and edits that are not named here, formats and curves: they explore.",
)


@dataclass(frozen=True)
class HeldProbe:
    """The plan of a probe held against its runs.

    Attributes:
        names: the declared models and edits; none where nothing counts as declared.
        known: what was known of the runs before the plan, in words; "" where nothing was.
        notes: what is to be said of the plan, one line each.
    """

    names: tuple[str, ...] = ()
    known: str = ""
    notes: tuple[str, ...] = ()


def declared_probe(
    conditions: Sequence[PlannedCondition], configs: Sequence[Mapping[str, Any]], names: Sequence[str], **said: Any
) -> Preregistration:
    """Return what is declared before a probe.

    Args:
        conditions: of the probe; their worlds hold the hash of its moments, and its edits.
        configs: the configuration of each.
        names: the models and edits that are compared.
        **said: what else `Preregistration` holds: `foundry`, `commit`, `asked`, `models`, `answers_known`,
            `runs_known`.

    Raises:
        InputError: a name is no model or edit of the probe, nothing is named, or nothing is compared.
    """
    if not names:
        raise InputError("Nothing is declared: name a model or an edit of the probe with --family, such as no_fire.")
    subjects = names_of(Subject.of(config) for config in configs)
    edits = [config["world"]["edit"] for config in configs]
    edited = list(dict.fromkeys(edit["name"] for edit in edits if edit["name"] != NONE and not edit.get("moves")))
    family = Family.named(names, subjects, edited)
    pairs = sum(family.holds_pair(set(pair)) for pair in itertools.combinations(subjects.values(), 2))
    changes = sum(family.holds_edit(*row) for row in itertools.product(subjects.values(), edited))
    tests = {what: count for what, count in (("pairs of models", pairs), ("edits", changes)) if count}
    if not tests:
        raise InputError(f"{', '.join(names)} is compared with nothing: ask two models, or an edit.")
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


def held_probe(folder: SweepFolder, asked: Sequence[str]) -> HeldProbe:
    """Return what was declared before a probe began, held against its runs.

    Args:
        folder: the probe.
        asked: the models and edits that the analysis is asked for, which the plan alone declares.

    Raises:
        InputError: a plan holds, and others are asked for.
        RecordError: the plan cannot be read.
    """
    found = preregistration_of(folder.path)
    if found is None:
        return HeldProbe()
    if late := made_late(folder):
        return HeldProbe(notes=(f"{PREREGISTRATION_FILE} counts as no plan, so all of this explores: {late}",))
    if asked:
        raise InputError(f"{folder.path / PREREGISTRATION_FILE} says what is tested: leave --family out.")
    plan, sha256 = found
    names = tuple(one.name for one in plan.measures)
    differs = [f"differs from the plan: {line}" for line in _differences(plan, folder)]
    held = f"{PREREGISTRATION_FILE} (sha256 {sha256[:12]}): {', '.join(names)}"
    end = "" if differs else "nothing differs from the plan"
    return HeldProbe(names, plan.known, ("; ".join(filter(None, [held, plan.known, end])), *differs))


def _differences(plan: Preregistration, folder: SweepFolder) -> Iterator[str]:
    runs = {run.id: run for run in folder.runs()}
    complete = sum(status(run, run.summary()) == COMPLETE for run in runs.values() if run.id in plan.runs)
    if complete < len(plan.runs):
        yield f"{len(plan.runs) - complete} of {len(plan.runs)} runs are not complete"
    if further := runs.keys() - plan.runs.keys():
        yield f"{len(further)} further runs are in the tests"
    yield from other_versions(plan, folder)
