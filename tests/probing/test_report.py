"""The report of a probe."""

import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from analysis.report.overview import Claims, Matrix
from analysis.report.probes.probe_sections import limits, unread_grid
from analysis.report.templating import rendered
from probing.conftest import done, refused


@pytest.mark.slow
def test_the_page_begins_with_what_was_asked_and_found_and_tells_what_was_left_out(report: Path):
    page = report.read_text(encoding="utf-8")
    assert "5 models, 18 moments of 3 seeds, 2 edits · " in page and " · 45 runs · exploratory</p>" in page
    parts = ("first", "claims", "summary", "figures", "moments", "limits", "tables", "commands")
    order = [page.index(f'id="{name}"') for name in parts]
    assert order == sorted(order)
    cards, matrix = page.split('<article class="finding">')[1:], page.partition('<table class="matrix">')[2]
    assert len(cards) == 3 and all(card.count('<p class="reply">') == 2 and "<mark>" in card for card in cards)
    heads, *rows = re.split("</tr>", matrix.partition("</table>")[0])[:-1]
    assert ">no_fire<" in heads and ">mirror<" in heads and heads.count(">from ") == len(rows) == 5
    assert all(row.count(">itself<") == 1 and "not declared" not in row for row in rows)
    assert "No claim can be made: fewer than 6 seeds only describe these runs." in page
    assert "<code>foundry preregister pilot " in page and "moments_seed=4 --family " in page
    for title in ("Distances between models", "Effects of the edits"):
        assert f'aria-label="{title}. ' in page
    assert "<code>foundry probe pilot " in page
    articles = page.split("<article>")[1:]
    assert len(articles) == 10
    excesses = [float(found) for found in re.findall(r"<p>Distance [0-9.]+, excess (-?[0-9.]+)\.</p>", page)]
    assert len(excesses) == 10 and excesses == sorted(excesses, reverse=True)
    for article in articles:
        assert 'src="data:image/png;base64,' in article
        assert article.count("<h4>") == 5
        assert "You are Agent" in article
    assert re.search(r"no_fire changes nothing in \d+ of 18 moments", page)
    assert "Number of answers, and of answers without a readable decision." in page


@pytest.mark.slow
def test_what_a_probe_has_not_is_refused(probed: Path):
    assert "is a probe" in refused("report", "probed", "--margin", "idle_rate.chosen=0.1", cwd=probed.parent)
    card = ("report", "probed", "--model", "scripted/avoid", "--family", "x")
    assert "only --out is allowed" in refused(*card, cwd=probed.parent)


@pytest.mark.slow
def test_a_card_names_a_probe_and_measures_only_whole_runs(probed: Path):
    model = "scripted/avoid"
    assert f"card of {model} in 1 setting:" in done(
        "report", "--model", model, "pilot", "probed", "--out", "c.html", cwd=probed.parent
    )
    text = (probed.parent / "c.md").read_text(encoding="utf-8")
    assert [line.rpartition(", ")[2] for line in text.splitlines() if line.startswith("## ")] == ["pilot"]
    assert "| probed | " in text and "Probes are not shown" in text


def frame(**columns: Any) -> pd.DataFrame:
    return pd.DataFrame({"kind": "all", **columns})


def test_an_edit_that_changes_every_moment_leaves_none_out():
    edits = frame(edit=["x", "y"], asked=[9, 9], moments=[9, 7])
    assert list(limits({"edits": edits})) == ["y changes nothing in 2 of 9 moments; its numbers omit these moments."]


def test_unread_answers_are_counted_for_each_model_and_counts_of_one_are_not_told():
    rows = [("a", "none", "left", 3), ("a", "none", "unreadable", 1), ("b", "none", "left", 4)]
    moments = pd.DataFrame(rows, columns=["model", "format", "choice", "count"])
    moments = moments.assign(run="r", step=1, agent=0, kind="action", again=0, seed=0, edit="none")
    assert [[cell.text for cell in row] for row in unread_grid(moments).rows] == [
        ["a", "none", "none", "4", "1", "25 %"],
        ["b", "none", "none", "4", "0", "0 %"],
    ]
    in_brackets = moments[moments["model"] == "b"].assign(format="spread/0", choice="unreadable")
    told = [[cell.text for cell in row] for row in unread_grid(pd.concat([moments, in_brackets])).rows]
    assert told[1:] == [["b", "none", "none", "4", "0", "0 %"], ["b", "none", "spread/0", "4", "4", "100 %"]]


def test_replies_stay_text_on_the_page():
    page = rendered("probe.html", {
        "title": "<b>", "facts": ["<b>"], "warnings": [], "cards": [], "overview": Matrix("", (), (), 0),
        "claims": Claims("", "", ""), "summary": ["<script>1</script>"], "shapes": (), "moments": [], "limits": [],
        "unread": unread_grid(pd.DataFrame(
            {"model": ["<i>"], "edit": ["none"], "format": ["none"], "choice": ["left"], "count": [1]}
        )),
        "determinism": None, "tables": [], "asked": [],
    })  # fmt: skip
    assert "<script>1" not in page
    assert "<i>" not in page
