"""Tables in LaTeX are no wider than a page."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import foundry
from analysis.tables.latex import split_by, to_latex
from analysis.tables.table import Table

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


def test_a_wide_table_is_set_by_world_and_its_captions_tell_what_never_changes():
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


def test_a_table_that_fits_is_set_whole():
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
