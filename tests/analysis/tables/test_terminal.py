"""The short tables of a terminal."""

from __future__ import annotations

import math

import pytest

from analysis.stats.contrasts import contrasts
from analysis.tables import terminal
from analysis.tables.comparison import compare
from analysis.tables.table import Table
from analysis.tables.texts import text_width
from signature_tables import runs, table

FIRST, SECOND = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4], [0.2, 0.7, 0.35, 0.6, 0.95, 0.8]
CHOSEN = "idle_rate.chosen"


def shown_means(rows, width=200, brief=False, served=()):
    made = table(rows)
    return terminal.means(compare(made, made.frame[["model"]].astype(str)), [CHOSEN], width, brief=brief, served=served)


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


def test_every_group_is_shown_in_rows_where_its_columns_do_not_fit():
    found = shown_means([run for model in "abcdef" for run in runs(model, [0.5])], width=30)
    assert [len(one.columns) for one in found] == [3, 3, 3]
    (found,) = shown_means([run for model in "abcdef" for run in runs(model, FIRST)], width=10, brief=True)
    assert found.columns == ("group", CHOSEN)
    assert [row[0] for row in found.rows] == list("abcdef")


def test_no_measure_is_said_to_be_left_out_where_all_are_shown():
    shares = {f"action.share_{name}": 0.5 for name in "pqrst"}
    (found,) = shown_means([{**run, **shares} for run in runs("a", FIRST)])
    assert len(found.rows) == 6 and "measures" not in found.caption
    made = table([*runs("x", FIRST), *runs("y", SECOND)])
    (shown,) = terminal.differences(contrasts(made, made.frame[["model"]].astype(str)), 200, brief=False)
    assert "contrasts.md" not in shown.caption


def test_measures_that_no_longer_fit_are_counted_and_said_to_be_in_the_files():
    shares = {f"action.share_{name}": 0.5 for name in "pqrst"}
    found = shown_means([{**run, **shares} for model in "abcdef" for run in runs(model, FIRST)], width=20)
    assert [row[0] for row in found[0].rows] == list("abcdef")
    assert "4 of 6 measures, all are in comparison.md" in found[-1].caption


def test_served_models_come_first_and_baselines_last():
    rows = [{**run, "baseline": run["model"] == "a"} for model in "abc" for run in runs(model, FIRST)]
    assert shown_means(rows, served={"c"})[0].columns == ("measure", "c", "b", "a (baseline)")
    made = table([run for model in ("x", "y", "z") for run in runs(model, FIRST if model == "x" else SECOND)])
    found = contrasts(made, made.frame[["model"]].astype(str))
    (shown,) = terminal.differences(found, 200, brief=False, served={"y", "z"})
    assert shown.columns == ("measure", "z\n- y", "y\n- x", "z\n- x")


def test_the_middle_of_long_names_is_left_out_unless_two_would_be_alike():
    assert terminal.shortened(["short", "a" * 10 + "b" * 10], 12) == {
        "short": "short",
        "a" * 10 + "b" * 10: "aaaaaa…bbbbb",
    }
    first, second = "model-aaaa1-instruct", "model-aaaa2-instruct"
    found = terminal.shortened([first, second], 8)
    assert len(set(found.values())) == 2


@pytest.mark.parametrize("models", [3, 12])
def test_at_80_columns_every_model_is_shown_whatever_its_name(models: int):
    names = [
        f"huggingface.co/somebody/A-Very-Long-Name-Of-A-Model-{n}B-Instruct-GGUF:Q4_K_M" for n in range(10, 10 + models)
    ]
    found = shown_means([run for name in names for run in runs(name, FIRST)], 80)
    told = {text for one in found for text in (*one.columns, *(row[0] for row in one.rows))}
    assert sum(text.endswith("Q4_K_M") for text in told) == models
    for one in found:
        columns = zip(one.columns, *one.rows, strict=True)
        assert sum(max(map(text_width, column)) + 2 for column in columns) <= 82


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
    assert "over 1 test of 1 pair," in found.caption


def test_differences_from_baselines_are_left_to_the_files():
    rows = [{**run, "baseline": run["model"] == "c"} for model in "abc" for run in runs(model, FIRST)]
    (found,) = shown_differences(rows)
    assert found.columns == ("measure", "b\n- a")
    assert "those from baselines are in contrasts.md" in found.caption


def test_one_group_has_no_table_of_differences():
    assert shown_differences(runs("a", FIRST)) == []


def test_a_row_that_has_nothing_in_a_block_is_left_out_of_it():
    rows = (("bar.score", "1", ""), ("naming.success", "", "2"), ("utility.mean", "3", "4"))
    first, second = terminal.blocks(Table("t", "", ("measure", "bar", "naming"), rows), width=20, most=4)
    assert first.rows == (("bar.score", "1"), ("utility.mean", "3"))
    assert second.rows == (("naming.success", "2"), ("utility.mean", "4"))
