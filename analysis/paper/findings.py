"""Differences that stand, one finding a measure: `herd stays more often than each other model`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from analysis.paper.gaps import effect, upright
from analysis.paper.sentence import DIFFERENT, Row, Sides, compared_words, kind_of, named, sentence, weaknesses
from analysis.prose import joined
from analysis.stats.factors import MODEL
from analysis.tables.texts import number, p_value, rounded, with_interval
from foundry.texts import counted


@dataclass(frozen=True)
class Finding:
    """One level of a factor that differs from others in one direction, in one measure.

    Attributes:
        rows: the rows of the contrasts that show it, one a level that it differs from.
        level: the level, such as a model.
        higher: whether its values are the higher ones.
        compared: how many other levels it was compared with.
        further: how many other pairs of levels differ in the measure.
    """

    rows: tuple[Row, ...]
    level: str
    higher: bool
    compared: int
    further: int = 0

    @property
    def effect(self) -> float:
        """The least standardised difference of its rows; infinite where a difference is the same in every seed."""
        return min(map(effect, self.rows))

    @property
    def p(self) -> float:
        """The greatest adjusted p of its rows."""
        return max(float(row["p_adjusted"]) for row in self.rows)

    @property
    def is_of_all(self) -> bool:
        """Whether it differs from several others, and from all that it was compared with."""
        return 1 < len(self.rows) == self.compared

    def others(self, names: Mapping[str, str]) -> str:
        """Return the names of the levels that it differs from, in words; some levels are called differently."""
        levels = [_other(row, self.level) for row in self.rows]
        return joined(named(self.rows[0], names.get(level, level)) for level in levels)

    @property
    def own(self) -> float:
        """Its mean over seeds; where the pairs have different seeds, that over the seeds of the first."""
        return _means(self.rows[0], self.level)[0]

    @property
    def others_range(self) -> tuple[float, float]:
        """The least and the greatest mean of the others."""
        means = [_means(row, self.level)[1] for row in self.rows]
        return min(means), max(means)

    def sentence(self, sides: Sides) -> str:
        """Return the finding in full, with what weakens it."""
        row = self.rows[0]
        if len(self.rows) == 1:
            return f"{sentence(row, sides).removesuffix('.')}{self._further()}."
        least, most = map(number, self.others_range)
        values = f"{number(self.own)} against {least}" + (f" to {most}" if least != most else "")
        smallest = min(self.rows, key=lambda other: abs(other["difference"]))
        gap = with_interval(smallest["difference"], smallest["low"], smallest["high"])
        seeds = counted(min(int(other["n_pairs"]) for other in self.rows), "seed")
        p = "p < .001" if self.p < 0.001 else f"p at most {p_value(self.p)}"
        claim = self._claim(sides, {}, f"each other {row['factor']}" if self.is_of_all else self.others({}), {})
        weakened = dict.fromkeys(weakness for other in self.rows for weakness in weaknesses(other, sides))
        tests = counted(row["family"], "test")
        said = f"{claim}: {row['measure']} {values}, smallest difference {gap}, {seeds}, {p} corrected over {tests}"
        return "; ".join([said, *weakened]) + f"{self._further()}."

    def line(self, sides: Sides, names: Mapping[str, str], contexts: Mapping[str, str]) -> str:
        """Return the finding in a line.

        Args:
            sides: what is known of the groups.
            names: what each level is called.
            contexts: what each context is called.
        """
        own, least, most = rounded([self.own, *self.others_range])
        values = f"{own} against {least}" + (f" to {most}" if least != most else "")
        if len(self.rows) == 1:
            values += f", difference {upright(self.rows[0])}"
        several = f"{len(self.rows)} of {self.compared} others" if len(self.rows) > 2 else self.others(names)
        return f"{self._claim(sides, names, 'all others' if self.is_of_all else several, contexts)}: {values}"

    def _claim(self, sides: Sides, names: Mapping[str, str], others: str, contexts: Mapping[str, str]) -> str:
        level = names.get(self.level, self.level)
        return compared_words(self.rows[0], level, others, higher=self.higher, sides=sides, contexts=contexts)

    def _further(self) -> str:
        if not self.further:
            return ""
        return f"; {counted(self.further, 'further pair')} differ{'s' * (self.further == 1)}"


def findings(rows: Sequence[Row]) -> list[Finding]:
    """Return what stands among rows of the contrasts: of models first, the largest standardised effect first.

    Of each measure, factor and context one finding is returned: that of the level which differs in one direction from
    the most others.
    """
    by_measure: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        by_measure.setdefault((str(row["measure"]), str(row["factor"]), str(row["context"])), []).append(row)
    found = [finding for own in by_measure.values() for finding in _finding(own)]
    return sorted(found, key=lambda finding: (finding.rows[0]["factor"] != MODEL, -finding.effect))


def _finding(rows: Sequence[Row]) -> Iterator[Finding]:
    """Yield the finding of one measure, if there is one."""
    standing = [row for row in rows if kind_of(row) == DIFFERENT]
    candidates: dict[tuple[str, bool], list[Row]] = {}
    for row in standing:
        higher = bool(row["difference"] > 0)
        candidates.setdefault((str(row["level"]), higher), []).append(row)
        candidates.setdefault((str(row["reference"]), not higher), []).append(row)
    if not candidates:
        return
    found = [
        Finding(tuple(own), level, higher, sum(level in (row["level"], row["reference"]) for row in rows))
        for (level, higher), own in candidates.items()
    ]
    best = max(found, key=lambda finding: (len(finding.rows), finding.effect, finding.higher))
    yield replace(best, further=len(standing) - len(best.rows))


def _other(row: Row, level: str) -> str:
    """Return the level that a row compares with this one."""
    return str(row["reference"] if str(row["level"]) == level else row["level"])


def _means(row: Row, level: str) -> tuple[float, float]:
    """Return the mean of a level of a row and that of the other."""
    first, second = float(row["mean_level"]), float(row["mean_reference"])
    return (first, second) if str(row["level"]) == level else (second, first)
