"""Compares a preregistration with the runs: which looks are reached, and what differs from the plan."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

import pandas as pd

from analysis.lines import COMPLETE, FAILED
from analysis.planned.declaring import code_of
from analysis.prose import group_label, joined
from analysis.stats.plan import DECLARED, Plan
from analysis.stats.values import Group, is_baseline
from analysis.tables.groups import group_keys
from analysis.tables.signature_table import SignatureTable
from foundry.errors import InputError
from foundry.storing.preregistration import PREREGISTRATION_FILE, Preregistration, preregistration_of
from foundry.storing.store import SweepFolder
from foundry.version import __version__


@dataclass(frozen=True)
class PlanCheck:
    """A preregistration compared with the runs."""

    declared: Preregistration
    sha256: str
    plan: Plan
    differs: tuple[str, ...]

    @property
    def look(self) -> str:
        """The last look so far, in words."""
        looks, reached = self.declared.looks, self.plan.reached
        if not reached:
            return f"before the first look, at {looks[0].seeds} seeds"
        now = looks[reached - 1]
        return f"look {reached} of {len(looks)}, at {now.seeds} seeds, level {now.alpha:.2g} of a single test"

    def notes(self) -> list[str]:
        """Return lines about the declaration: the last look so far, and each deviation from the plan."""
        plan_line = f"{PREREGISTRATION_FILE} (sha256 {self.sha256[:12]}): {self.look}"
        known = [self.plan.known] if self.plan.known else []
        differs = [f"differs from the plan: {line}" for line in self.differs]
        return [plan_line, *known, *differs] if differs else [f"{plan_line}; nothing differs from the plan", *known]


def answered(contrasts: pd.DataFrame) -> bool:
    """Return whether every declared row shows a difference or equality."""
    rows = contrasts[contrasts["claim"] == DECLARED]
    return bool(len(rows) and (rows["significant"] | rows["equivalent"]).all())


def open_rows(contrasts: pd.DataFrame) -> list[str]:
    """Return the declared rows that show neither a difference nor equality, as `measure (level against level)`."""
    rows = contrasts[(contrasts["claim"] == DECLARED) & ~(contrasts["significant"] | contrasts["equivalent"])]
    return [f"{row.measure} ({row.level} against {row.reference})" for row in rows.itertuples()]


def plans_of(
    sweeps: Sequence[SweepFolder], table: SignatureTable, groups: pd.DataFrame, *, asked: bool = False
) -> tuple[PlanCheck | None, list[str]]:
    """Return the first plan among the sweeps, and notes on other plans, which are not used.

    Raises:
        InputError: as in `plan_check`.
        RecordError: a file cannot be read.
    """
    notes: list[str] = []
    first: PlanCheck | None = None
    for sweep in sweeps:
        file = sweep.path / PREREGISTRATION_FILE
        late = made_late(sweep)
        if late:
            notes.append(late)
        elif first is not None and preregistration_of(sweep.path):
            notes.append(f"{file} is not used for several sweeps: to use it, analyse its sweep alone")
        elif first is None:
            first = plan_check(sweep, table, groups, asked=asked)
    return first, notes


def made_late(sweep: SweepFolder) -> str:
    """Return a note if there is evidence that the plan did not exist when its sweep began, or "".

    Raises:
        RecordError: the file cannot be read.
    """
    plan_and_hash = preregistration_of(sweep.path)
    if plan_and_hash is None:
        return ""
    late = _late(sweep, *plan_and_hash)
    return (
        f"{sweep.path / PREREGISTRATION_FILE} does not count as a plan, so all findings are exploratory: {late}"
        if late
        else ""
    )


def _late(sweep: SweepFolder, declared: Preregistration, sha256: str) -> str:
    if sweep.plan is None:
        return "the sweep began without a plan (sweep.yaml names none)"
    if sweep.plan != sha256:
        return f"the sweep began with a different plan (SHA-256 {sweep.plan[:12]} in sweep.yaml, {sha256[:12]} here)"
    ends = (run.summary() for run in sweep.runs() if run.id in declared.runs)
    started = min((end.started for end in ends if end is not None and end.started), default="")
    if started and datetime.fromisoformat(started) < datetime.fromisoformat(declared.made):
        return f"the plan was made at {declared.made}, after the first run had started at {started}"
    return ""


def plan_check(
    sweep: SweepFolder, table: SignatureTable, groups: pd.DataFrame, *, asked: bool = False
) -> PlanCheck | None:
    """Return the preregistration of a sweep compared with its runs, or None if it has none.

    Raises:
        InputError: the user named a family or margins.
        RecordError: the file cannot be read.
    """
    plan_and_hash = plan_alone(sweep, asked=asked)
    if plan_and_hash is None:
        return None
    declared, sha256 = plan_and_hash
    frame, keys = table.frame, group_keys(groups)
    own = frame["run"].isin(declared.runs)
    plan = Plan(
        family=tuple(measure.name for measure in declared.measures if measure.name in table.measures),
        groups=frozenset(key for key, mine in zip(keys, own, strict=True) if mine),
        looks=tuple(look.seeds for look in declared.looks),
        seeds=tuple(declared.seeds),
        reached=_reached(declared, set(frame["run"][frame["status"].isin((COMPLETE, FAILED))])),
        margins={
            measure.name: measure.margin
            for measure in declared.measures
            if measure.margin and measure.name in table.measures
        },
        widest={measure.name: measure.widest for measure in declared.measures if measure.widest},
        changed=frozenset(_changed(declared)),
        known=declared.known,
    )
    return PlanCheck(declared, sha256, plan, tuple(_differences(declared, plan, sweep, table, keys)))


def plan_alone(sweep: SweepFolder, *, asked: bool) -> tuple[Preregistration, str] | None:
    """Return the preregistration of a sweep and the hash of its file, or None if it has none.

    Raises:
        InputError: the user named a family or margins, although the plan declares them.
        RecordError: the file cannot be read.
    """
    plan_and_hash = preregistration_of(sweep.path)
    if plan_and_hash is not None and asked:
        raise InputError(
            f"{sweep.path / PREREGISTRATION_FILE} already declares the tests: leave --family and --margin out."
        )
    return plan_and_hash


def _reached(declared: Preregistration, ended: set[str]) -> int:
    open_seeds = {seed for run, seed in declared.runs.items() if run not in ended}
    first = next((place for place, seed in enumerate(declared.seeds) if seed in open_seeds), len(declared.seeds))
    return sum(look.seeds <= first for look in declared.looks)


def _changed(declared: Preregistration) -> Iterator[str]:
    """Yield the declared measures that have other code than when they were declared, or that no longer exist."""
    for measure in declared.measures:
        try:
            now = code_of(measure.name, list(measure.code_sha256))
        except InputError:
            now = {}
        if now != measure.code_sha256:
            yield measure.name


def _differences(
    declared: Preregistration, plan: Plan, sweep: SweepFolder, table: SignatureTable, keys: Sequence[Group]
) -> Iterator[str]:
    frame = table.frame
    runs = set(frame["run"])
    lacking = sum(runs.isdisjoint(condition.runs) for condition in declared.conditions)
    if lacking:
        yield f"{lacking} of the {len(declared.conditions)} planned conditions are missing"
    others = [
        key for key, beside in zip(keys, is_baseline(frame), strict=True) if not beside and key not in plan.groups
    ]
    if others:
        yield f"{joined([group_label(key) for key in dict.fromkeys(others)])} was added later and is exploratory"
    yield from _of_seeds(declared, plan, table, keys)
    if plan.changed:
        yield f"the code of {joined(sorted(plan.changed))} has changed since the plan, so these results are exploratory"
    absent = [measure.name for measure in declared.measures if measure.name not in table.measures]
    if absent and frame["status"].eq(COMPLETE).any():
        yield f"no run has {joined(absent)}"
    yield from other_versions(declared, sweep)


def _of_seeds(declared: Preregistration, plan: Plan, table: SignatureTable, keys: Sequence[Group]) -> Iterator[str]:
    rows = zip(keys, table.frame["seed"], table.frame["status"], strict=True)
    seeds = {seed for key, seed, status in rows if key in plan.groups and status in (COMPLETE, FAILED)}
    further = seeds - set(declared.seeds)
    if further:
        yield f"{len(further)} seeds were run, but are not in the plan, so they are not tested"
    known = len(seeds) - len(further)
    if known and known not in plan.looks:
        tested = (
            f"the tests were made at {plan.looks[plan.reached - 1]} seeds" if plan.reached else "nothing is tested yet"
        )
        yield f"there are {known} seeds, but looks are planned at {', '.join(map(str, plan.looks))}: {tested}"


def other_versions(declared: Preregistration, sweep: SweepFolder) -> Iterator[str]:
    """Yield a line for each difference of a sweep from the declared version of foundry and the declared weights."""
    if declared.foundry != __version__:
        yield f"the plan was made with foundry {declared.foundry}; this is foundry {__version__}"
    now = {model["name"]: model.get("digest") for model in sweep.models}
    for model in declared.models:
        if model["name"] in now and model.get("digest") and now[model["name"]] not in (None, model["digest"]):
            yield f"{model['name']} has other weights"
