"""The short tables of a terminal."""

from __future__ import annotations

import math

import pytest

from analysis.stats.contrasts import contrasts
from analysis.tables import terminal
from analysis.tables.comparison import compare
from analysis.tables.texts import text_width
from signature_tables import runs, table

FIRST, SECOND = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4], [0.2, 0.7, 0.35, 0.6, 0.95, 0.8]
CHOSEN = "idle_rate.chosen"


def shown_means(rows, width=200, brief=False):
    made = table(rows)
    return terminal.means(compare(made, made.frame[["model"]].astype(str)), [CHOSEN], width, brief=brief)


def shown_differences(rows, width=200, brief=False):
    made = table(rows)
    found = contrasts(made, made.frame[["model"]].astype(str))
    return terminal.differences(found, width, brief=brief)


def test_groups_stand_side_by_side_while_they_fit():
    (found,) = shown_means([*runs("a", [0.1, 0.2]), *runs("b", [0.5, math.nan])])
    assert found.columns == ("measure", "a", "b")
    assert found.rows == ((CHOSEN, "0.15 [0, 0.785]", "0.5 n=1"),)


@pytest.mark.parametrize("width", [40, 80, 120])
def test_no_line_is_wider_than_the_terminal(width):
    rows = [run for model in ("scripted/a", "scripted/b", "scripted/c") for run in runs(model, FIRST)]
    for found in shown_means(rows, width):
        columns = zip(found.columns, *found.rows, strict=True)
        assert sum(max(map(text_width, column)) + 2 for column in columns) <= width + 2


def test_what_no_longer_fits_is_counted_and_said_to_be_in_the_files():
    found = shown_means([run for model in "abcdef" for run in runs(model, [0.5])], width=30)
    assert [len(one.columns) for one in found] == [3, 3, 3]
    found = shown_means([run for model in "abcdef" for run in runs(model, FIRST)], width=10, brief=True)
    assert [one.columns for one in found] == [("measure", "a"), ("measure", "b")]
    assert "2 of 6 groups, all are in comparison.md" in found[-1].caption


def test_a_brief_table_has_the_declared_measures_and_names_the_others():
    rows = [{**run, "idle_rate.blocked": 0.1} for run in runs("a", FIRST)]
    assert [row[0] for row in shown_means(rows)[0].rows] == [CHOSEN, "idle_rate.blocked"]
    (found,) = shown_means(rows, brief=True)
    assert [row[0] for row in found.rows] == [CHOSEN]
    assert found.caption.endswith("further measures (1) are in comparison.md")


def test_a_difference_has_its_interval_and_p():
    (found,) = shown_differences([*runs("a", FIRST), *runs("b", SECOND)])
    assert found.columns == ("measure", "b\n- a")
    assert found.rows == ((CHOSEN, "0.2 [0.0276, 0.372] p=.031*"),)
    assert "in a family of 1," in found.caption


def test_differences_from_baselines_are_left_to_the_files():
    rows = [{**run, "baseline": run["model"] == "c"} for model in "abc" for run in runs(model, FIRST)]
    (found,) = shown_differences(rows)
    assert found.columns == ("measure", "b\n- a")
    assert "those from baselines are in contrasts.md" in found.caption


def test_one_group_has_no_table_of_differences():
    assert shown_differences(runs("a", FIRST)) == []
