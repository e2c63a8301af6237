"""Converts findings to records, with numbers and example moments."""

import math
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from itertools import product
from typing import Protocol

import numpy as np
import pandas as pd

from analysis.figures.members import Member
from analysis.findings.finding_records import DESCRIBES, STANDS, FindingRecord
from analysis.findings.moments import MESSAGE, Moment, first_moment
from analysis.findings.ranking import Finding, other_level
from analysis.paper.sentence import Row, Sides
from analysis.paper.study import short_contexts
from analysis.signature_modules import parts
from analysis.stats.factors import find_factors, sides_of
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from foundry.texts import counted

MOST_MOMENTS = 3
"""Maximum number of example moments of a finding."""
MOST_SEEDS = 12
"""Maximum number of seeds in which example moments are searched, lowest seed first."""


class Runs:
    """The complete runs of each group with the values of their measures; example moments are searched in these runs."""

    def __init__(self, compared: Comparison, members: Sequence[Member], table: pd.DataFrame) -> None:
        factors = find_factors(
            compared.group_columns, [group for group in compared.groups if group not in compared.baselines]
        )
        self._groups: Mapping[tuple[str, str, str], Group] = {
            side: group
            for group in compared.groups
            if group not in compared.baselines
            for side in sides_of(compared.group_columns, group, factors)
        }
        self._rows: dict[Group, list[tuple[int, Member]]] = {}
        for place, member in enumerate(members):
            if member.complete:
                self._rows.setdefault(member.shown.group, []).append((place, member))
        self._table = table
        self._first_moment = cache(first_moment)  # many measures need the same pairs of runs
        self._questions = {part.name: part.question for part in parts()}

    def moments(self, row: Row, level: str, reference: str) -> tuple[tuple[Moment, ...], str]:
        """Return the earliest example moments of a row, one per seed, or the reason why there are none."""
        measure = str(row["measure"])
        sides = [
            self._typical(self._groups[str(row["factor"]), name, str(row["context"])], measure)
            for name in (level, reference)
        ]
        seeds = [seed for seed in sorted(sides[0]) if seed in sides[1]][:MOST_SEEDS]
        if not seeds:
            return (), "in no seed do both groups have a run with a typical value (between the quartiles of the group)"
        question = self._questions.get(measure.partition(".")[0], "")
        sought = [
            moment
            for seed in seeds
            for first, second in product(sides[0][seed], sides[1][seed])
            if (moment := self._first_moment(first.folder, second.folder, seed, question)) is not None
        ]
        if not sought:
            event = "only one of two agents spoke" if question == MESSAGE else "two agents decided differently"
            typical = f"in the typical runs of {counted(len(seeds), 'seed')}"
            return (), f"{typical}, it never happened that {event} after equal prompts"
        by_seed: dict[int, Moment] = {}
        for moment in sorted(
            sought, key=lambda moment: (moment.step, moment.seed, moment.agent, moment.level_run, moment.reference_run)
        ):
            by_seed.setdefault(moment.seed, moment)
        return tuple(by_seed.values())[:MOST_MOMENTS], ""

    def _typical(self, group: Group, measure: str) -> dict[int, list[Member]]:
        """Return, by seed, the runs with a typical value: between the quartiles of the group, rounded outwards."""
        column = self._table[measure].to_numpy(dtype=np.float64)
        known = [(place, member) for place, member in self._rows.get(group, []) if not math.isnan(column[place])]
        if not known:
            return {}
        values = [column[place] for place, _ in known]
        low, high = np.quantile(values, 0.25, method="lower"), np.quantile(values, 0.75, method="higher")
        typical: dict[int, list[Member]] = {}
        for place, member in known:
            if low <= column[place] <= high:
                typical.setdefault(member.seed, []).append(member)
        return typical


class Examples(Protocol):
    """Finds moments that show the difference of a finding in recorded runs."""

    def moments(self, row: Row, level: str, reference: str) -> tuple[tuple[Moment, ...], str]:
        """Return the earliest example moments of a row, one per seed, or the reason why there are none."""


def records_of(
    ranked: Sequence[Finding], sides: Sides, examples: Examples, doubted: Collection[str] = ()
) -> list[FindingRecord]:
    """Return the findings with a difference as records; for a doubted signature, `standing` is DESCRIBES."""
    contexts = short_contexts(str(finding.rows[0]["context"]) for finding in ranked)
    return [
        _record(
            finding,
            finding.plain(sides, contexts),
            sides,
            examples,
            trusted=finding.measure.partition(".")[0] not in doubted,
        )
        for finding in ranked
        if not finding.is_equal
    ]


def _record(finding: Finding, sentence: str, sides: Sides, examples: Examples, *, trusted: bool) -> FindingRecord:
    row = finding.closest
    reference = other_level(row, finding.level)
    turned = str(row["level"]) != finding.level
    mean, reference_mean = (float(row[name]) for name in ("mean_level", "mean_reference"))
    difference, low, high = (float(row[name]) for name in ("difference", "low", "high"))
    moments, why = examples.moments(row, finding.level, reference)
    return FindingRecord(
        sentence=sentence,
        measure=finding.measure,
        label=sides.describe(row).label,
        factor=str(row["factor"]),
        level=finding.level,
        reference=reference,
        others=finding.other_levels,
        context=str(row["context"]),
        value=_number(reference_mean if turned else mean),
        reference_value=_number(mean if turned else reference_mean),
        difference=_number(-difference if turned else difference),
        low=_number(-high if turned else low),
        high=_number(-low if turned else high),
        p=_number(finding.p),
        family=int(row["family"]),
        claim=str(row["claim"]),
        standing=STANDS if finding.stands and trusted else DESCRIBES,
        seeds=finding.seeds,
        note=finding.note,
        moments=moments,
        no_moments=why,
    )


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
