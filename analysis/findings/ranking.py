"""Turns the rows of the contrasts into ranked findings, such as `herd stays more often than every other model`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from analysis.paper.sentence import (
    DIFFERENT,
    NOTHING,
    Row,
    Sides,
    compared_words,
    kind_of,
    named,
    nothing_words,
    sentence,
    weaknesses,
)
from analysis.prose import joined
from analysis.stats.factors import MODEL
from analysis.stats.plan import DECLARED
from analysis.tables.texts import number, p_value, rounded, with_interval
from foundry.texts import counted

MOST_TESTED = 3
"""Maximum number of measures in a suggested command for new seeds."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Finding:
    """A result such as "model a moves more than models b and c": a level that differs from others in one direction.

    If no test shows a difference in the measure, the finding is the largest gap: the two levels with the largest
    difference.

    Attributes:
        rows: the rows of the contrasts on which it is based, one per level from which it differs; one row for a gap.
        higher: whether the level has the higher values.
        compared: number of other levels that the rows of the measure compare with the level.
        further: number of other pairs of levels that differ in the measure.
    """

    rows: tuple[Row, ...]
    level: str
    higher: bool
    compared: int
    means: Mapping[str, float]
    further: int = 0

    @property
    def measure(self) -> str:
        """Name of the measure."""
        return str(self.rows[0]["measure"])

    @property
    def differs(self) -> bool:
        """True if a test shows the difference, False for a gap, which no test shows."""
        return kind_of(self.rows[0]) == DIFFERENT

    @property
    def stands(self) -> bool:
        """True if every row of the finding is significant and was declared before the runs."""
        return self.differs and all(row["claim"] == DECLARED for row in self.rows)

    @property
    def is_equal(self) -> bool:
        """True if the smallest difference of the finding is zero up to rounding."""
        return bool(abs(self.closest["difference"]) < _ROUNDING)

    @property
    def closest(self) -> Row:
        """The row of the contrasts, among `rows`, with the smallest absolute difference."""
        return min(self.rows, key=lambda row: abs(row["difference"]))

    @property
    def note(self) -> str:
        """The note of that row; if there are several rows and the note states a difference, it names the two levels."""
        note = str(self.closest["note"])
        return note if len(self.rows) == 1 else _of_pair(note, self.closest)

    @property
    def excludes_zero(self) -> bool:
        """True if the interval of the smallest difference excludes 0."""
        return bool(self.closest["low"] > 0 or self.closest["high"] < 0)

    @property
    def effect(self) -> float:
        """The smallest standardised difference among the rows; infinite if no difference varies between seeds."""
        return min(map(effect, self.rows))

    @property
    def p(self) -> float:
        """The largest adjusted p value among the finding's rows."""
        return max(float(row["p_adjusted"]) for row in self.rows)

    def others_in(self, sides: Sides) -> int:
        """Return the number of other levels, including levels that no row of the finding's measure compares."""
        row = self.rows[0]
        return max(self.compared, len(sides.levels.get((row["factor"], row["context"]), ())) - 1)

    def is_of_all(self, sides: Sides) -> bool:
        """Return True if the level differs from all other levels, and there are at least two others."""
        return 1 < len(self.rows) == self.others_in(sides)

    def others(self, names: Mapping[str, str]) -> str:
        """Return the names of the levels from which the finding's level differs, as text."""
        return joined(named(self.rows[0], names.get(level, level)) for level in self.other_levels)

    @property
    def other_levels(self) -> tuple[str, ...]:
        """The levels from which the finding's level differs."""
        return tuple(other_level(row, self.level) for row in self.rows)

    @property
    def own(self) -> float:
        """The level's mean in the first comparison of the finding; other comparisons can rest on other seeds."""
        return _means(self.rows[0], self.level)[0]

    @property
    def others_range(self) -> tuple[float, float]:
        """The smallest and the largest mean of the levels from which the finding's level differs."""
        means = [_means(row, self.level)[1] for row in self.rows]
        return min(means), max(means)

    def sentence(self, sides: Sides) -> str:
        """Return the finding in full, with its limitations."""
        row = self.rows[0]
        if len(self.rows) == 1:
            return f"{sentence(row, sides).removesuffix('.')}{self._further()}."
        least, most = map(number, self.others_range)
        values = f"{number(self.own)} against {least}" + (f" to {most}" if least != most else "")
        ends = [self.closest[name] for name in ("difference", "low", "high")]
        gap = with_interval(*(ends if ends[0] >= 0 else (-ends[0], -ends[2], -ends[1])))
        seeds = counted(self.seeds, "seed")
        p = "p < .001" if self.p < 0.001 else f"p at most {p_value(self.p)}"
        claim = self._claim(sides, {}, f"every other {row['factor']}" if self.is_of_all(sides) else self.others({}), {})
        weakened = dict.fromkeys(_of_pair(weak, other) for other in self.rows for weak in weaknesses(other, sides))
        tests = counted(row["family"], "test")
        said = f"{claim}: {row['measure']} {values}, smallest difference {gap}, {seeds}, {p} corrected for {tests}"
        return "; ".join([said, *weakened]) + f"{self._further()}."

    @property
    def seeds(self) -> int:
        """The smallest number of seeds among the finding's rows."""
        return min(int(row["n_pairs"]) for row in self.rows)

    def plain(self, sides: Sides, contexts: Mapping[str, str]) -> str:
        """Return the finding as a sentence without its test.

        A declared test without a difference is said as such. For another gap, the sentence begins with "In these runs".
        """
        row = self.rows[0]
        if row["claim"] == DECLARED and kind_of(row) == NOTHING:
            return self._nothing(contexts)
        said = self.line(sides, {}, contexts)
        if len(self.rows) > 1:
            said += f", smallest difference {upright(self.closest)}"
        if not self.differs:
            said = f"In these runs {said}"
            if not self.excludes_zero and not math.isnan(self.closest["low"]):
                said += " (the interval includes 0)"
        return f"{said}, {counted(self.seeds, 'seed')}."

    def _nothing(self, contexts: Mapping[str, str]) -> str:
        row, own, other = self.rows[0], *rounded([self.own, self.others_range[0]])
        nothing = nothing_words(row, self.level, other_level(row, self.level), contexts)
        apart = "; the uncorrected interval excludes 0" if self.excludes_zero else ""
        return f"{nothing}: {own} against {other}, difference {upright(row)}, {counted(self.seeds, 'seed')}{apart}."

    def line(self, sides: Sides, names: Mapping[str, str], contexts: Mapping[str, str]) -> str:
        """Return the finding in one line, with short names of levels and contexts."""
        own, least, most = rounded([self.own, *self.others_range])
        values = f"{own} against {least}" + (f" to {most}" if least != most else "")
        if len(self.rows) == 1:
            values += f", difference {upright(self.rows[0])}"
        every = f"every other {self.rows[0]['factor']}"
        several = (
            f"{len(self.rows)} of the {self.others_in(sides)} others" if len(self.rows) > 2 else self.others(names)
        )
        return f"{self._claim(sides, names, every if self.is_of_all(sides) else several, contexts)}: {values}"

    def _claim(self, sides: Sides, names: Mapping[str, str], others: str, contexts: Mapping[str, str]) -> str:
        level = names.get(self.level, self.level)
        mark = f" ({whose})" if (whose := sides.reading(self.rows[0]).short) else ""
        words = compared_words(self.rows[0], level, others, higher=self.higher, sides=sides, contexts=contexts)
        return f"{words}{mark}"

    def _further(self) -> str:
        if not self.further:
            return ""
        return f"; {counted(self.further, 'further pair')} also differ{'s' * (self.further == 1)}"


def _of_pair(weakness: str, row: Row) -> str:
    """Return a weakness of one of several rows; if it states a difference, name the two levels."""
    return f"{row['level']} - {row['reference']}: {weakness}" if "the difference" in weakness else weakness


def findings(rows: Sequence[Row]) -> list[Finding]:
    """Return one finding for each measure, swept setting (factor) and combination of the other settings (context).

    If differences are significant, the finding is about the level that differs from most other levels in one direction.
    If none is significant, the finding is the largest gap. Significant findings come first, then findings about models,
    then the largest standardised differences.
    """
    by_measure: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row["n_pairs"]:
            by_measure.setdefault((str(row["measure"]), str(row["factor"]), str(row["context"])), []).append(row)
    ranked = [_difference(own) or _gap(own) for own in by_measure.values()]
    return sorted(
        ranked, key=lambda finding: (not finding.differs, finding.rows[0]["factor"] != MODEL, -finding.effect)
    )


def _difference(rows: Sequence[Row]) -> Finding | None:
    different = [row for row in rows if kind_of(row) == DIFFERENT]
    candidates: dict[tuple[str, bool], list[Row]] = {}
    for row in different:
        higher = bool(row["difference"] > 0)
        candidates.setdefault((str(row["level"]), higher), []).append(row)
        candidates.setdefault((str(row["reference"]), not higher), []).append(row)
    if not candidates:
        return None
    sided = [_finding(own, level, higher, rows) for (level, higher), own in candidates.items()]
    best = max(sided, key=lambda finding: (len(finding.rows), finding.effect, finding.higher))
    return replace(best, further=len(different) - len(best.rows))


def _gap(rows: Sequence[Row]) -> Finding:
    row = max(rows, key=lambda row: abs(row["difference"]))
    return _finding([row], str(row["level" if row["difference"] >= 0 else "reference"]), True, rows)


def _finding(own: Sequence[Row], level: str, higher: bool, rows: Sequence[Row]) -> Finding:
    means: dict[str, float] = {}
    for row in rows:
        means.setdefault(str(row["level"]), float(row["mean_level"]))
        means.setdefault(str(row["reference"]), float(row["mean_reference"]))
    compared = sum(level in (row["level"], row["reference"]) for row in rows)
    return Finding(tuple(own), level, higher, compared, means)


def measures_to_test(ranked: Sequence[Finding]) -> list[str]:
    """Return at most MOST_TESTED measures to test with new seeds; gaps whose interval includes 0 are left out."""
    measures = dict.fromkeys(finding.measure for finding in ranked if finding.excludes_zero or finding.differs)
    return list(measures)[:MOST_TESTED]


def effect(row: Row) -> float:
    """Return the standardised difference of a row: infinite if it is the same in all seeds, 0 with too few seeds."""
    size = abs(float(row["g_z"]))
    if math.isnan(size):
        return math.inf if abs(row["difference"]) > 0 else 0.0
    return 0.0 if math.isnan(row["low"]) else size


def upright(row: Row) -> str:
    """Return the difference of a row's two levels without sign, with the interval if there is one."""
    difference, low, high = (float(row[name]) for name in ("difference", "low", "high"))
    size, least, most = rounded((difference, low, high) if difference >= 0 else (-difference, -high, -low))
    return size if math.isnan(low) else f"{size} [{least}, {most}]"


def other_level(row: Row, level: str) -> str:
    """Return the other one of the two levels that a row compares."""
    return str(row["reference"] if str(row["level"]) == level else row["level"])


def _means(row: Row, level: str) -> tuple[float, float]:
    first, second = float(row["mean_level"]), float(row["mean_reference"])
    return (first, second) if str(row["level"]) == level else (second, first)
