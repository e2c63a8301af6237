"""The tables as texts and files."""

import csv
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import foundry
from analysis.measuring.runs import Source, measure_run
from analysis.stats.contrasts import contrasts
from analysis.tables.comparison import compare
from analysis.tables.latex import split_by, to_latex
from analysis.tables.signature_table import build_table
from analysis.tables.table import Table
from analysis.tables.texts import (
    alike,
    comparison_table,
    contrast_table,
    number,
    p_value,
    to_markdown,
    with_interval,
    write_numbers,
    write_tables,
)
from foundry.texts import from_cell
from walkers import WORLD, make_condition, write_sweep

HARD = "50 % of a_b & {c} $x^2$ #1 \\ ~ <|>"
TABLE = Table("small", "What it is: 95 %", ("measure", "a_1"), (("x.y_z", "1 [0, 2]"), (HARD, "-")))


def test_latex_is_one_environment_with_rules_that_escapes_all_it_would_read():
    lines = to_latex(TABLE).splitlines()
    assert lines[:2] == [r"% needs \usepackage{booktabs}", r"\begin{table}"]
    assert lines[-1] == r"\end{table}"
    assert [line for line in lines if line.endswith("rule")] == [r"\toprule", r"\midrule", r"\bottomrule"]
    assert r"\begin{tabular}{lr}" in lines
    assert all(line.count(" & ") == 1 for line in lines if line.endswith(r"\\"))
    latex = to_latex(TABLE)
    assert r"50 \% of a\_b \& \{c\} \$x\textasciicircum{}2\$ \#1 \textbackslash{} \textasciitilde{}" in latex
    assert r"\textless{}\textbar{}\textgreater{}" in latex
    assert r"measure & a\_1 \\" in latex
    assert r"{[0, 1]} & a \\" in to_latex(Table("t", "c", ("one", "two"), (("[0, 1]", "a"),)))


def test_latex_of_more_rows_than_a_page_holds_goes_on_on_the_next_one_under_the_same_head():
    lines = to_latex(replace(TABLE, rows=(("x", "1"),) * 170)).splitlines()
    assert lines[:2] == [r"% needs \usepackage{booktabs,longtable}", r"\begin{longtable}{lr}"]
    assert lines[2] == r"\caption{What it is: 95 \%}\label{tab:small} \\"
    head = [r"\toprule", r"measure & a\_1 \\", r"\midrule"]
    assert lines[3:13] == [*head, r"\endfirsthead", *head, r"\endhead", r"\bottomrule", r"\endfoot"]
    assert lines[13:-1] == [r"x & 1 \\"] * 170 and lines[-1] == r"\end{longtable}"


@given(st.text())
@example("\U00010000" * 40)
def test_no_text_leaves_latex_open(text: str):
    row = to_latex(Table("t", "", ("a",), ((text,),))).split("\\midrule\n")[1].split("\\bottomrule")[0]
    bare = re.sub(r"\\(?:text[a-z]+\{\}|[{}$&#%_\\])", "", row)
    assert not set("$&#%_^~") & set(bare)
    assert bare.count("{") == bare.count("}")


def test_markdown_escapes_what_would_be_a_column_or_a_style():
    lines = to_markdown(TABLE).splitlines()
    assert lines[0] == r"| measure | a\_1 |"
    assert lines[1] == "| --- | ---: |"
    assert r"\<\|\>" in lines[3]
    assert re.findall(r"(?<!\\)\|", lines[3]) == ["|"] * 3


def test_no_text_of_a_csv_file_is_a_formula_and_all_are_read_back(tmp_path):
    texts = ["=1+1", "+cmd", "@sum(a1)", "-1 [-2, 1]", "'=1", "\t=1"]
    frame = pd.DataFrame(
        {"model": texts, "-x": [-1.5, math.nan, 2, 3, 4, 5], "as text": ["-1.5", "-", "", "'a", "b-c", "+2"]}
    )
    csv_file, parquet_file = write_numbers(tmp_path / "t", frame)
    with csv_file.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["model", "'-x", "as text"]
    assert [row[0] for row in rows] == [f"'{text}" for text in texts]
    assert [row[1] for row in rows] == ["-1.5", "", "2.0", "3.0", "4.0", "5.0"]
    assert [row[2] for row in rows] == frame["as text"].tolist()
    assert [from_cell(row[0]) for row in rows] == texts
    pd.testing.assert_frame_equal(pd.read_parquet(parquet_file), frame)


@pytest.mark.parametrize(
    ("value", "text"),
    [(math.nan, "-"), (0.0, "0"), (3.5e-19, "0"), (0.12345, "0.123"), (-2.0, "-2"), (1e-7, "1e-07"), (2601.0, "2601")],
)
def test_numbers_have_three_digits_and_the_undefined_is_no_zero(value: float, text: str):
    assert number(value) == text


@pytest.fixture(scope="module")
def compared(tmp_path_factory) -> Any:
    path = tmp_path_factory.mktemp("tables") / "sweep"
    world = {**WORLD, "agents": 3, "steps": 5}
    sweep = write_sweep(path, [make_condition(model, range(6), world=world) for model in ("a", "b")])
    table = build_table([measure_run(run, Source(sweep, "s")) for run in sweep.runs()])
    return compare(table), contrasts(table)


def test_tables_are_written_in_every_format(compared, tmp_path):
    written = write_tables(tmp_path, *compared)
    assert {path.name for path in written} == {
        f"{name}.{ending}" for name in ("comparison", "contrasts") for ending in ("csv", "parquet", "tex", "md")
    }
    frame = pd.read_csv(tmp_path / "contrasts.csv", keep_default_na=False, na_values=[""])
    assert len(frame) == len(compared[1]) == len(pd.read_parquet(tmp_path / "contrasts.parquet"))
    before = {path: path.read_bytes() for path in written}
    assert before == {path: path.read_bytes() for path in write_tables(tmp_path, *compared)}


def test_the_short_tables_hold_the_headline_measures_with_a_star_where_they_stand(compared):
    comparison, found = compared
    table = comparison_table(comparison)
    assert table.columns == ("measure", "a", "b")
    assert "idle_rate.chosen" in {row[0] for row in table.rows}
    assert not any("_readable" in row[0] for row in table.rows if not row[0].startswith("outcome"))
    short = contrast_table(found)
    assert short.columns[:5] == ("measure", "first", "second", "claim", "pairs")
    assert len(short.rows) == int(found["headline"].sum())
    found = compared[1].assign(significant=True, p_adjusted=0.01, equivalent=False)
    column = contrast_table(found).columns.index("p (adjusted)")
    assert {row[column] for row in contrast_table(found).rows} == {".010*"}


def test_numbers_of_one_column_share_their_decimals_and_none_is_written_as_0():
    assert alike([0.5, 0.0312, 0.0, -0.25]) == ["0.500", "0.031", "0.000", "-0.250"]
    assert alike([12.0, 3.0]) == ["12", "3"]
    assert alike([1234.5, 2.0, float("nan")]) == ["1234", "2", "-"]
    assert alike([0.5, 0.0001, -0.00004]) == ["0.500", "0.0001", "-4e-05"]
    assert [p_value(p) for p in (1e-9, 0.0214, 1.0, math.nan)] == ["<.001", ".021", "1.000", "-"]
    assert with_interval(0.5, math.nan, math.nan) == "0.5"
    assert with_interval(0.5, 0.25, 0.75) == "0.5 [0.25, 0.75]"


MOST_OVERFULL = 20.0
"""Points by which a line may be too wide."""
LONG = "a_name_of_a_setting.that_goes_on/and_on"
WIDE = Table(
    "wide",
    "Caption.",
    ("world", "measure", "claim", LONG, "w" * 80, f"{LONG} of another"),
    tuple((world, f"{LONG}.{row}", "exploratory", f"{row}.5", f"{row} [-0.123456, 0.123456]", LONG)
          for world in ("bar", "kibo") for row in range(3)),
    labels=3,
)  # fmt: skip


def test_a_wide_table_is_set_by_world_with_captions_that_tell_what_never_changes_and_one_that_fits_is_set_whole():
    latex = to_latex(WIDE, split_by(WIDE, "world"))
    captions = re.findall(r"\\caption\{(.*)\}\\label\{(.*)\}", latex)
    assert [label for _, label in captions] == [
        "tab:wide",
        *(f"tab:wide-{index}" for index in range(2, len(captions) + 1)),
    ]
    told = [text.split(";")[0] for text, _ in captions]
    assert set(told) == {f"Caption. World: {world}. In every row: claim: exploratory" for world in ("bar", "kibo")}
    assert all(LONG.replace("_", r"\_") in text for text, _ in captions)
    body = latex.replace(r"\allowbreak{}", "")
    assert body.count("1 [-0.123456, 0.123456]") == 2 and "exploratory &" not in body
    narrow = Table("narrow", "Caption.", ("world", "n"), (("bar", "1"), ("kibo", "1")))
    latex = to_latex(narrow, split_by(narrow, "world"))
    assert latex.count("tabular") == 2 and r"bar & 1 \\" in latex and "allowbreak" not in latex


@pytest.mark.exports
def test_no_table_of_several_worlds_is_wider_than_the_page(workspace):
    pdflatex = shutil.which("pdflatex") or pytest.skip("needs LaTeX: apt-get install texlive-latex-recommended")
    small = ("seed=0-1", "world.agents=4", "world.steps=8", "runner.workers=1", "output.dir=out")
    ran = foundry.sweep("world=cafe_library,bar,survival", "model=scripted/random,scripted/stay", *small)
    tables = [file for file in foundry.analyze(ran.path, plots=False).written if file.suffix == ".tex"]
    assert len(tables) >= 3
    Path("wide.tex").write_text(to_latex(WIDE), encoding="utf-8")
    for table in (*tables, Path("wide.tex")):
        text = table.read_text(encoding="utf-8")
        (packages,) = re.findall(r"\\usepackage\{.*\}", text.splitlines()[0])
        page = rf"\documentclass{{article}}{packages}\begin{{document}}\input{{{table.as_posix()}}}\end{{document}}"
        Path("page.tex").write_text(page, encoding="utf-8")
        done = subprocess.run([pdflatex, "-interaction=nonstopmode", "page.tex"], capture_output=True, check=False)
        log = done.stdout.decode("utf-8", "replace")
        assert done.returncode == 0, log
        assert [
            width for width in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log) if float(width) > MOST_OVERFULL
        ] == []
