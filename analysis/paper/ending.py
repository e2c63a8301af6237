"""How an analysis ends on a terminal: findings, the largest gaps, what to look out for, what to do next."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from analysis.form import FormAnalysis
from analysis.paper.findings import Finding, findings
from analysis.paper.gaps import gap_lines, gaps, short_names, upright
from analysis.paper.sentence import DIFFERENT, SAME, SILENT, Row, Sides, kind_of, why_silent
from analysis.paper.study import short_contexts
from analysis.prose import group_label
from analysis.stats.factors import MODEL
from analysis.stats.plan import DECLARED
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.texts import number, p_value, text_width, with_interval
from foundry.texts import counted

MOST_LINES, WIDEST = 20, 100
"""Lines and columns of an ending."""
MOST_WARNINGS, FEWEST_WARNINGS = 4, 2
"""Lines of what to look out for, and those that are left to it where findings have no room."""
MOST_TESTED = 3
"""Measures that the command for new seeds declares."""
_CUT = "further finding"
LEAST_TABLE = 4
"""Lines that a table needs: an empty one, its head, a row, and how many rows are left out."""


@dataclass(frozen=True)
class Told:
    """What an ending is made of.

    Attributes:
        contrasts: the table of contrasts.
        compared: the groups.
        declared: the measures that claims rest on.
        forms: the form of each group's worlds.
        notes: what a reader of the tables must know.
        study: what was run, in a line.
        folders: the sweeps, as a command names them.
        tables: the folder of tables.
        again: returns the command that declares measures on new seeds, to be tested between so many pairs.
    """

    contrasts: pd.DataFrame
    compared: Comparison
    declared: Sequence[str]
    forms: Mapping[Group, FormAnalysis]
    notes: Sequence[str]
    study: str
    folders: str
    tables: str
    again: Callable[[Sequence[str], int], str]


def ending(told: Told, width: int, printed: int = 0) -> list[str]:
    """Return the lines with which an analysis ends: with those above it no more than MOST_LINES.

    Args:
        told: what it is made of.
        width: columns of the terminal.
        printed: lines that stand above it.
    """
    width = min(width, WIDEST)
    study = wrapped(told.study, width)
    room = MOST_LINES - printed - len(study) - len(_look_at(told)) - 2
    look_out = _look_out(told, width, MOST_WARNINGS)
    body = _body(told, width, room - len(look_out))
    if any(_CUT in line for line in body):  # findings come before notes
        look_out = _look_out(told, width, FEWEST_WARNINGS)
        body = _body(told, width, room - len(look_out))
    return [*study, "", *body, "", *look_out, *_look_at(told)]


def wrapped(text: str, width: int, indent: str = "", further: str | None = None) -> list[str]:
    """Return a text in lines, each behind an indent, all but the first behind a further one where that differs."""
    return textwrap.wrap(
        text,
        width,
        initial_indent=indent,
        subsequent_indent=indent if further is None else further,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _look_at(told: Told) -> list[str]:
    return [
        f"Look at   foundry view {told.folders}   every step, prompt and reply",
        f"          foundry report {told.folders}   one page; tables and plots: {told.tables}",
    ]


def _look_out(told: Told, width: int, most: int) -> list[str]:
    """Return the notes that have room, how many more there are and where, and an empty line; nothing without notes."""
    lines: list[str] = []
    shown = 0
    for note in told.notes:
        own = wrapped(note, width, " " * 10)
        if shown and len(lines) + len(own) > most - (shown + 1 < len(told.notes)):
            break
        lines, shown = [*lines, *own], shown + 1
    if not lines:
        return []
    left = len(told.notes) - shown
    more = [f"          {counted(left, 'further note')}: {told.tables}/summary.md"] if left else []
    return ["Look out" + lines[0].removeprefix("        "), *lines[1:], *more, ""]


def _body(told: Told, width: int, room: int) -> list[str]:
    rows = told.contrasts[told.contrasts["headline"].astype(bool)].to_dict("records")
    if not rows:
        return _alone(told, width, room)
    factors = sorted(dict.fromkeys(str(row["factor"]) for row in rows), key=lambda factor: factor != MODEL)
    names: dict[str, str] = {}
    for factor in factors:
        own = [row for row in rows if row["factor"] == factor]
        names |= short_names(str(row[side]) for row in own for side in ("reference", "level"))
    contexts = short_contexts(str(row["context"]) for row in rows)
    lines = _findings(told, rows, names, contexts, width, room)
    told_measures = {finding.rows[0]["measure"] for finding in findings(rows)}
    others = [row for row in rows if row["measure"] not in told_measures and row["factor"] == factors[0]]
    again = _again(told, rows, width) if not told_measures else []
    room -= len(lines) + len(again)
    if others and room >= LEAST_TABLE:
        lines += ["", *_table(told, others, names, contexts, width, room - 1)]
    return [*lines, *again]


def _findings(
    told: Told, rows: Sequence[Row], names: Mapping[str, str], contexts: Mapping[str, str], width: int, room: int
) -> list[str]:
    """Return what can be claimed, and of the rest that it cannot."""
    sides = Sides.of(told.contrasts, told.compared, told.forms)
    standing = findings(rows)
    declared = [row for row in rows if row["claim"] == DECLARED]
    others = [row for row in declared or rows if kind_of(row) == SAME or (declared and kind_of(row) != DIFFERENT)]
    if not standing and not others:
        return wrapped(_nothing(rows), width)
    entries = [
        *(finding.line(sides, names, contexts) for finding in standing),
        *(_verdict(row, names, contexts) for row in others),
    ]
    lines = wrapped(_title(rows, standing), width)
    for place, entry in enumerate(entries):
        own = wrapped(entry, width, "  ", "    ")
        left = len(entries) - place
        if len(lines) + len(own) + (left > 1) > room:
            return [*lines, f"  {counted(left, _CUT)}: {told.tables}/summary.md"]
        lines += own
    return lines


def _verdict(row: Row, names: Mapping[str, str], contexts: Mapping[str, str]) -> str:
    """Return in short what holds of a row that shows no difference."""
    factor = "" if row["factor"] == MODEL else f"{row['factor']}="
    context = contexts[str(row["context"])]
    both = f"{factor}{names[str(row['level'])]} and {factor}{names[str(row['reference'])]}"
    both += f" ({context})" if context else ""
    kind = kind_of(row)
    if kind == SILENT:
        return f"Nothing can be said of {row['measure']} of {both}: {why_silent(row)}"
    if kind == SAME:
        return f"{both} are the same in {row['measure']} within {number(row['margin'])}: {upright(row)}"
    return f"No difference was found between {both} in {row['measure']}: {upright(row)}"


def _title(rows: Sequence[Row], standing: Sequence[Finding]) -> str:
    tests = max(row["family"] for row in rows)
    differ = sum(kind_of(row) == DIFFERENT for row in rows)
    said = f"Findings: {differ} of {counted(tests, 'test')} show{'s' * (differ == 1 or tests == 1)} a difference"
    if not standing:
        return said
    p = p_value(max(finding.p for finding in standing))
    return f"{said} (p {'below ' + p[1:] if p.startswith('<') else 'at most ' + p}{', corrected' * (tests > 1)})"


def _nothing(rows: Sequence[Row]) -> str:
    """Return that nothing can be claimed, and the most frequent reason."""
    silent = Counter(why_silent(row) for row in rows if kind_of(row) == SILENT)
    if silent.total() == len(rows):
        return f"No claim can be made: {silent.most_common(1)[0][0]}."
    tests = counted(max(row["family"] for row in rows), "test")
    return f"No difference was found in {tests}; that does not show that the models are the same."


def _table(
    told: Told, rows: Sequence[Row], names: Mapping[str, str], contexts: Mapping[str, str], width: int, room: int
) -> list[str]:
    """Return the table of gaps with as many rows as there is room for, and how many are left out."""
    found = gaps(rows)
    runs = {str(row["context"]): told.forms[group].run for row in rows for group in told.forms}
    shown = found if len(found) < room else found[: room - 2]
    left = len(found) - len(shown)
    more = [f"  {counted(left, 'further measure')}: {told.tables}/comparison.md"] if left else []
    return [*(f"  {line}" for line in gap_lines(shown, names, contexts, runs, width - 2)), *more]


def _again(told: Told, rows: Sequence[Row], width: int) -> list[str]:
    """Return the command that tests the largest gaps on new seeds."""
    found = [gap for gap in gaps(rows) if gap.is_one_sided][:MOST_TESTED]
    if not found:
        return []
    pairs = {(row["level"], row["reference"], row["context"]) for row in rows}
    command = told.again(list(dict.fromkeys(gap.measure for gap in found)), len(pairs))
    return ["Test the largest on new seeds, declared before they run:", *wrapped(command, width, "  ", "    ")]


def _alone(told: Told, width: int, room: int) -> list[str]:
    """Return the means of groups that are compared with nothing."""
    own = [group for group in told.compared.groups if group not in told.compared.baselines]
    known = [
        (measure, group) for measure in told.declared for group in own if (measure, group) in told.compared.estimates
    ]
    if not known:
        return ["No measure is defined in these runs."]
    cells = [told.compared.estimates[key] for key in known]
    names = [measure + (f", {group_label(group)}" if len(own) > 1 else "") for measure, group in known]
    widest = max(map(text_width, names))
    lines = [
        f"  {name}{' ' * (widest - text_width(name))}  {with_interval(cell.mean, cell.low, cell.high)}"
        for name, cell in zip(names, cells, strict=True)
    ]
    head = wrapped("Nothing is compared. Means over seeds [95 %]:", width)
    left = len(lines) + len(head) - room
    if left <= 0:
        return [*head, *lines]
    return [
        *head,
        *lines[: room - len(head) - 1],
        f"  {counted(left + 1, 'further mean')}: {told.tables}/comparison.md",
    ]
