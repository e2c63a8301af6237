"""The card of a model: all worlds that it was in, beside null, best policy and the other models."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from analysis.paper.card import card
from commands import foundry
from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from foundry.trust.bundling import write_bundle


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory: pytest.TempPathFactory, write_sweep: Callable[..., SweepFolder], make_condition: Any):
    """Two sweeps of one model, one with another model and baselines."""
    path = tmp_path_factory.mktemp("cards")
    first = write_sweep(path / "first", [make_condition(name, range(2)) for name in ("mine", "<b>other</b>")])
    write_sweep(first.baselines_dir, [make_condition("scripted/random", range(2))])
    return first, write_sweep(path / "second", [make_condition("mine", range(2, 4))])


@pytest.fixture(scope="module")
def made(sweeps: tuple[SweepFolder, ...]):
    return card("mine", [one.path for one in sweeps])


def test_a_card_has_a_table_of_every_sweep_that_the_model_was_in(made):
    assert [one.title.rpartition(", ")[2] for one in made.settings] == ["first", "second"]
    assert [row[0] for row in made.facts.rows] == ["first", "second"]
    assert [row[4:6] for row in made.facts.rows] == [("2", "2"), ("2", "2")]


def test_each_measure_stands_beside_null_policy_and_the_other_models(made):
    first, second = (one.table for one in made.settings)
    assert first.columns[1:] == ("mine", "null", "best", "<b>other</b>", "scripted/random (baseline)")
    assert second.columns[1:] == ("mine", "null", "best")
    rows = {row[0].partition(":")[0]: row for row in first.rows}
    assert rows["hazard.away_beyond_blind"][2] == "0"
    assert len(rows) > 20


def test_a_card_holds_the_numbers_of_its_model_and_of_no_other(sweeps: tuple[SweepFolder, ...]):
    by_model = {name: card(name, [sweeps[0].path]).settings[0].table for name in ("mine", "<b>other</b>")}
    mine, other = ({row[0].partition(":")[0]: row for row in table.rows} for table in by_model.values())
    assert mine["idle_rate.chosen"][1] == other["idle_rate.chosen"][4]
    assert mine["idle_rate.chosen"][4] == other["idle_rate.chosen"][1]


def test_names_of_models_are_no_markup(made):
    assert "<b>other" not in made.html()
    assert "&lt;b&gt;other" in made.html()
    assert "\\<b\\>other" in made.markdown()


def test_a_card_writes_no_table_of_the_sweep(sweeps: tuple[SweepFolder, ...], made):
    assert [file.name for file in sweeps[1].analysis_dir.iterdir()] == ["measured.sqlite"]


def test_a_model_that_ran_in_none_is_refused_with_the_closest(sweeps: tuple[SweepFolder, ...]):
    with pytest.raises(InputError, match="Did you mean 'mine'"):
        card("mime", [one.path for one in sweeps])


def test_the_command_writes_page_and_text_from_folders_and_bundles(sweeps: tuple[SweepFolder, ...], tmp_path: Path):
    bundle = tmp_path / "second.tar.zst"
    write_bundle(sweeps[1].path, bundle)
    page = tmp_path / "out" / "card.html"
    found = foundry("card", "mine", str(sweeps[0].path), str(bundle), "--out", str(page), cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert ", second" in page.with_suffix(".md").read_text(encoding="utf-8")


def test_the_command_refuses_a_sweep_that_is_given_twice_in_a_bundle_too(
    sweeps: tuple[SweepFolder, ...], tmp_path: Path
):
    write_bundle(sweeps[1].path, tmp_path / "second.tar.zst")
    for again in (str(sweeps[1].path), "second.tar.zst"):
        found = foundry("card", "mine", str(sweeps[1].path), again, cwd=tmp_path)
        assert (found.returncode, len(found.stderr.splitlines())) == (2, 1)
        assert "is given more than once" in found.stderr


def test_the_command_refuses_to_write_the_page_over_the_text(sweeps: tuple[SweepFolder, ...], tmp_path: Path):
    found = foundry("card", "mine", str(sweeps[1].path), "--out", "card.md", cwd=tmp_path)
    assert found.returncode == 2
    assert "name a page" in found.stderr
