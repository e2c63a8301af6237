"""Writes the last lines of an analysis on a terminal: findings, largest gaps, notes, next steps."""

import math
import shlex
import textwrap
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from analysis.findings.ranking import Finding, findings, measures_to_test, upright
from analysis.findings.study_matrix import Matrix
from analysis.paper.gaps import aligned, gap_lines, short_names
from analysis.paper.sentence import DIFFERENT, SAME, SILENT, Row, Sides, kind_of, named, why_silent
from analysis.paper.study import short_contexts
from analysis.prose import group_label, text_width
from analysis.stats.factors import MODEL
from analysis.stats.plan import DECLARED
from analysis.tables.comparison import Comparison
from analysis.tables.texts import number, p_value, with_interval
from foundry.texts import counted

MOST_LINES, WIDEST = 20, 100
"""Maximum number of lines that an analysis prints on a terminal, and of characters in a line."""
MOST_NOTES, FEWEST_NOTES = 4, 2
"""Maximum number of lines of notes: usually MOST_NOTES, and FEWEST_NOTES if the findings need the room."""
MOST_THRESHOLDS = 3
"""Maximum number of sentences about thresholds."""
LEAST_TABLE = 4
"""Minimum number of lines of a table: an empty line, the head, one row, and a line that counts the omitted rows."""


@dataclass(frozen=True)
class EndingContent:
    """The content of the lines with which an analysis ends on a terminal.

    Attributes:
        folders: folders of the sweeps, as in a command.
        again: function that returns the command for new seeds, from the measures to declare and the number of pairs.
        alone: sentence for a study that compares no groups.
        means: names and values of means, to be shown below `alone`.
        one_sided: whether only values above 0 count as differences; then the means of groups are not shown.
        matrix: the matrix of groups by worlds, if there are several worlds.
    """

    contrasts: pd.DataFrame
    sides: Sides
    notes: Sequence[str]
    study: str
    folders: str
    tables: str
    again: Callable[[Sequence[str], int], str]
    thresholds: Sequence[str] = ()
    alone: str = "Nothing is compared."
    means: Sequence[tuple[str, str]] = ()
    one_sided: bool = False
    matrix: Matrix | None = None


def ending(results: EndingContent, width: int, printed: int = 0) -> list[str]:
    """Return the last lines of an analysis; with the `printed` lines above them, they are at most MOST_LINES lines."""
    width = min(width, WIDEST)
    study = [*wrapped(results.study, width), *_of_thresholds(results, width)]
    look_at = _look_at(results.folders, results.tables)
    room = MOST_LINES - printed - len(study) - len(look_at) - 2
    rows = results.contrasts[results.contrasts["headline"].astype(bool)].to_dict("records")
    shown = _Shown.of(results, rows, width) if rows else None
    look_out = _look_out(results.notes, results.tables, width, MOST_NOTES)
    if shown is not None and shown.is_cut(room - len(look_out)):  # findings come before notes
        look_out = _look_out(results.notes, results.tables, width, FEWEST_NOTES)
    room -= len(look_out)
    body = _alone(results, width, room) if shown is None else shown.body(room)
    return [*study, "", *body, "", *look_out, *look_at]


def wrapped(text: str, width: int, indent: str = "", further: str | None = None) -> list[str]:
    """Break a text into lines; `indent` begins the first line, `further` the other lines (by default `indent`)."""
    return textwrap.wrap(
        text,
        width,
        initial_indent=indent,
        subsequent_indent=indent if further is None else further,
        break_long_words=False,
        break_on_hyphens=False,
    )


def command_lines(command: str, width: int) -> list[str]:
    """Break a command between its arguments, so that a shell reads the indented lines as one command."""
    whole = " ".join(shlex.quote(word).replace(" ", "\0") for word in shlex.split(command))
    *lines, last = wrapped(whole, width - 2, "  ", "    ")
    return [line.replace("\0", " ") for line in (*(f"{line} \\" for line in lines), last)]


def _of_thresholds(results: EndingContent, width: int) -> list[str]:
    shown = results.thresholds[:MOST_THRESHOLDS]
    lines = [line for sentence in shown for line in wrapped(sentence, width, "", "  ")]
    left = len(results.thresholds) - len(shown)
    more = [f"{counted(left, 'further threshold')}: {results.tables}/thresholds.csv"] if left else []
    return ["", *lines, *more] if lines else []


def _look_at(folders: str, tables: str) -> list[str]:
    return [
        f"Look at   foundry view {folders}   every step, prompt and reply",
        f"          foundry report {folders}   one page; tables: {tables}",
    ]


def _look_out(notes: Sequence[str], tables: str, width: int, most: int) -> list[str]:
    lines: list[str] = []
    shown = 0
    for note in notes:
        own = wrapped(note, width, " " * 10)
        if shown and len(lines) + len(own) > most - (shown + 1 < len(notes)):
            break
        lines, shown = [*lines, *own], shown + 1
    if not lines:
        return []
    left = len(notes) - shown
    more = [f"          {counted(left, 'further note')}: {tables}/summary.md"] if left else []
    return ["Look out" + lines[0].removeprefix("        "), *lines[1:], *more, ""]


@dataclass(frozen=True)
class _Shown:
    """The comparisons in headline measures that the last lines of an analysis show, and the data to describe them.

    Attributes:
        ranked: the findings in these rows, including gaps.
        names: short name of each level, models first.
        contexts: short name of each context.
        main: factor in the table of gaps: the model, or else the first factor.
    """

    told: EndingContent
    rows: Sequence[Row]
    ranked: Sequence[Finding]
    sides: Sides
    names: Mapping[str, str]
    contexts: Mapping[str, str]
    main: str
    width: int

    @classmethod
    def of(cls, results: EndingContent, rows: Sequence[Row], width: int) -> "_Shown":
        factors = sorted(dict.fromkeys(str(row["factor"]) for row in rows), key=lambda factor: factor != MODEL)
        names: dict[str, str] = {}
        for factor in factors:
            own = [row for row in rows if row["factor"] == factor]
            names |= short_names(str(row[side]) for row in own for side in ("reference", "level"))
        contexts = short_contexts(str(row["context"]) for row in rows)
        ranked = findings([row for row in rows if row["difference"] > 0] if results.one_sided else rows)
        return cls(results, rows, ranked, results.sides, names, contexts, factors[0], width)

    @cached_property
    def different(self) -> Sequence[Finding]:
        """The significant findings."""
        return [finding for finding in self.ranked if finding.differs]

    @cached_property
    def entries(self) -> Sequence[Sequence[str]]:
        """The results, each as a list of lines: first the findings, then declared comparisons without a difference."""
        declared = [row for row in self.rows if row["claim"] == DECLARED]
        others = [
            row for row in declared or self.rows if kind_of(row) == SAME or (declared and kind_of(row) != DIFFERENT)
        ]
        texts = [
            *(finding.line(self.sides, self.names, self.contexts) for finding in self.different),
            *(_verdict(row, self.names, self.contexts, signed=self.told.one_sided) for row in others),
        ]
        return [wrapped(text, self.width, "  ", "    ") for text in texts]

    @cached_property
    def title(self) -> Sequence[str]:
        """The lines above the list of results; if the list is empty, they say why no claim is possible."""
        if not self.entries:
            return wrapped(nothing_claimed(self.rows), self.width)
        tests = tests_in(self.rows)
        differ = sum(kind_of(row) == DIFFERENT for row in self.rows)
        said = f"Findings: {differ} of {counted(tests, 'test')} show{'s' * (differ == 1 or tests == 1)} a difference"
        if self.different:
            p = p_value(max(finding.p for finding in self.different))
            said += f" (p {'below ' + p[1:] if p.startswith('<') else 'at most ' + p}{', corrected' * (tests > 1)})"
        return wrapped(said, self.width)

    def is_cut(self, room: int) -> bool:
        """Return whether the results need more than `room` lines."""
        return len(self.title) + sum(map(len, self.entries)) > room

    def body(self, room: int) -> list[str]:
        """Return at most `room` lines: the results, a table of the other measures, and the command for new seeds."""
        lines = list(self.title)
        for place, own in enumerate(self.entries):
            left = len(self.entries) - place
            if len(lines) + len(own) + (left > 1) > room:
                lines.append(f"  {counted(left, 'further finding')}: {self.told.tables}/summary.md")
                break
            lines += own
        again = [] if self.different else self._again()
        room -= len(lines) + len(again)
        measures = {finding.measure for finding in self.different}
        others = [
            finding
            for finding in self.ranked
            if finding.measure not in measures and finding.rows[0]["factor"] == self.main
        ]
        scores = self._scores()
        if scores and len(scores) < room:
            lines += ["", *scores]
        elif others and not self.told.one_sided and room >= LEAST_TABLE:
            lines += ["", *self._table(others, room - 1)]
        return [*lines, *again]

    def _scores(self) -> list[str]:
        """Return the table of scores with a row per world; no lines for a single world or if the table is too wide."""
        columns = self.told.matrix.columns if self.told.matrix else ()
        if self.told.matrix is None or len({column.world for column in columns}) < 2:
            return []
        rows = self.told.matrix.rows
        ends = [end for end in ("blind", "best") if any(getattr(column, end) is not None for column in columns)]
        lines = aligned(
            [
                ["score in", *(row.name for row in rows), *ends],
                *(
                    [
                        column.title,
                        *(row.cells[place].text.partition(" [")[0] for row in rows),
                        *("" if getattr(column, end) is None else number(getattr(column, end)) for end in ends),
                    ]
                    for place, column in enumerate(columns)
                ),
            ]
        )
        return [f"  {line}" for line in lines] if max(map(text_width, lines)) + 2 <= self.width else []

    def _table(self, findings: Sequence[Finding], room: int) -> list[str]:
        shown = findings if len(findings) < room else findings[: room - 2]
        left = len(findings) - len(shown)
        more = [f"  {counted(left, 'further measure')}: {self.told.tables}/comparison.md"] if left else []
        lines = gap_lines(shown, self.names, self.contexts, self.sides, self.width - 2)
        return [*(f"  {line}" for line in lines), *more]

    def _again(self) -> list[str]:
        measures = measures_to_test(self.ranked)
        if not measures:
            return []
        pairs = {(row["level"], row["reference"], row["context"]) for row in self.rows}
        command = self.told.again(measures, len(pairs))
        if not command:
            return []
        title = "To test the largest differences, declare them and run new seeds:"
        return [*wrapped(title, self.width), *command_lines(command, self.width)]


def _verdict(row: Row, names: Mapping[str, str], contexts: Mapping[str, str], *, signed: bool) -> str:
    context = contexts[str(row["context"])]
    both = " and ".join(named(row, names[str(row[side])]) for side in ("level", "reference"))
    both += f" ({context})" if context else ""
    kind = kind_of(row)
    if kind == SILENT:
        return f"{both} could not be compared in {row['measure']}: {why_silent(row)}"
    if kind == SAME:
        return f"{both} differ in {row['measure']} by less than {number(row['margin'])}: {upright(row)}"
    size = with_interval(row["difference"], row["low"], row["high"]) if signed else upright(row)
    return f"No difference was found between {both} in {row['measure']}: {size}"


def nothing_claimed(rows: Sequence[Row]) -> str:
    """Return a sentence that says that no difference was found; without any test, it gives the most frequent reason."""
    silent = Counter(why_silent(row) for row in rows if kind_of(row) == SILENT)
    if silent.total() == len(rows):
        return f"No claim can be made: {silent.most_common(1)[0][0]}."
    tests = counted(tests_in(rows), "test")
    return f"{tests} found no difference; this does not show that the models behave alike."


def tests_in(rows: Sequence[Row]) -> int:
    """Return the number of rows with a test."""
    return sum(not math.isnan(row["p_adjusted"]) for row in rows)


def means_of(compared: Comparison, declared: Sequence[str]) -> list[tuple[str, str]]:
    """For a study that compares nothing, return each declared measure's name and mean in each group."""
    own = [group for group in compared.groups if group not in compared.baselines]
    cells = {
        measure + (f", {group_label(group)}" if len(own) > 1 else ""): compared.estimates[measure, group]
        for measure in declared
        for group in own
        if (measure, group) in compared.estimates
    }
    return [(name, with_interval(cell.mean, cell.low, cell.high)) for name, cell in cells.items()]


def _alone(results: EndingContent, width: int, room: int) -> list[str]:
    head = wrapped(f"{results.alone} Means over seeds [95 %]:" if results.means else results.alone, width)
    lines = [f"  {line}" for line in aligned(results.means)] if results.means else []
    left = len(lines) + len(head) - room
    if left <= 0:
        return [*head, *lines]
    return [
        *head,
        *lines[: room - len(head) - 1],
        f"  {counted(left + 1, 'further mean')}: {results.tables}/comparison.md",
    ]
