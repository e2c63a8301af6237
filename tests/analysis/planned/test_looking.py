"""Looks that nobody declared are counted."""

import json

import numpy as np
import pytest

from analysis import analyze
from analysis.planned.looking import counted, error_after_looks
from analysis.stats.contrasts import contrasts
from foundry.errors import RecordError
from signature_tables import MEASURE, runs, table
from walkers import WORLD, make_condition, write_sweep

SECOND = np.random.default_rng(1).random(30)


@pytest.fixture
def look(tmp_path):
    """Return a function that looks at the first seeds of models, and returns the rows of what is declared."""

    def at(seeds: int, models: str = "ab"):
        rows = [run for place, one in enumerate(models) for run in runs(one, np.roll(SECOND, place)[:seeds].tolist())]
        return counted(contrasts(table(rows), family=[MEASURE]), tmp_path, {})

    return at


def test_a_model_that_came_later_was_looked_at_less_often(look):
    look(8)
    found = look(12, "abc").set_index(["level", "reference"])["look"]
    assert found.to_dict() == {("b", "a"): 2, ("c", "a"): 1, ("c", "b"): 1}


def test_each_number_of_seeds_is_a_look_fewer_than_can_be_tested_are_none_and_further_ones_say_what_they_cost(look):
    found = [look(n)[["look", "note"]].iloc[0].tolist() for n in (5, 8, 8, 12, 18, 12)]
    assert [number for number, _ in found] == [0, 1, 1, 2, 3, 3]
    assert found[1][1] == ""
    assert found[3][1] == "second undeclared look: tests at 5% wrongly find a difference in 8% of cases"
    assert found[4][1] == "third undeclared look: tests at 5% wrongly find a difference in 10% of cases"
    assert (
        error_after_looks(range(6, 61)) == "undeclared look 55: tests at 5% wrongly find a difference in 28% of cases"
    )


@pytest.mark.slow
def test_a_pair_keeps_its_looks_when_another_setting_is_swept_or_left_out(tmp_path):
    seeds, factors, world = range(10), ("model", "prompt"), {**WORLD, "agents": 2, "steps": 3}
    conditions = [
        make_condition(model, seeds, factors, sampling_seed=place, prompt=prompt, world=world)
        for place, model in enumerate("ab")
        for prompt in ("paper", "japanese")
    ]
    path = write_sweep(tmp_path / "sweep", conditions).path

    def looks(*only: str) -> dict[str, int]:
        rows = analyze(path, plots=False, only=only).contrasts
        rows = rows[(rows["measure"] == "idle_rate.chosen") & (rows["factor"] == "model")]
        return dict(zip(rows["context"], rows["look"], strict=True))

    assert looks("prompt=paper", "seed=0-5") == {"": 1}
    lines = [json.loads(line) for line in (path / "looks.jsonl").read_text().splitlines()]
    assert [(line["level"], line["reference"], line["pairs"]) for line in lines] == [("b", "a", 6)]
    assert looks("seed=0-7") == {"prompt=paper": 2, "prompt=japanese": 1}
    assert looks("prompt=paper") == {"": 3}
    assert looks("prompt=japanese") == {"": 2}


@pytest.mark.slow
def test_looks_that_were_kept_without_settings_count_by_their_names(tmp_path):
    world = {**WORLD, "agents": 2, "steps": 3}
    conditions = [make_condition(model, range(8), sampling_seed=place, world=world) for place, model in enumerate("ab")]
    path = write_sweep(tmp_path / "sweep", conditions).path
    line = {"factor": "model", "level": "b", "reference": "a", "context": "", "pairs": 6, "at": "2026-11-01T00:00:00"}
    looks = path / "looks.jsonl"
    looks.write_text(json.dumps(line) + "\n")

    def count() -> set[int]:
        rows = analyze(path, plots=False).contrasts
        return set(rows["look"][rows["measure"] == "idle_rate.chosen"])

    assert count() == count() == {2}
    kept = looks.read_text()
    with_settings = {**json.loads(kept.splitlines()[-1]), "pairs": 6, "context": "prompt=paper"}
    looks.write_text(kept + json.dumps(with_settings) + "\n")
    assert count() == {2}, "six pairs are one look by both names"


def test_a_damaged_count_is_refused(look, tmp_path):
    (tmp_path / "looks.jsonl").write_text("nothing\n")
    with pytest.raises(RecordError, match=r"looks\.jsonl cannot be read"):
        look(8)
