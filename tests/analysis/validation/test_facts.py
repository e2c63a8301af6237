"""What is known of worlds is read from their files, and the shipped files speak of what is there."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.signatures import discover
from analysis.validation.facts import all_facts, facts_of
from foundry import paths
from foundry.errors import InputError
from foundry.own_code import VARIABLE

KNOWN = list(all_facts())
CONF = paths.conf_dir()
LEAST = "world: bar\nscore: bar.score\n"


@pytest.fixture
def mine(tmp_path, monkeypatch) -> Path:
    folder = tmp_path / "mine" / "validation"
    folder.mkdir(parents=True)
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    return folder


@pytest.mark.parametrize("facts", KNOWN, ids=lambda facts: facts.world)
def test_a_shipped_file_names_a_world_policies_and_measures_that_exist(facts):
    assert (CONF / "world" / f"{facts.world}.yaml").is_file()
    policies = {facts.random, *filter(None, [facts.best]), *(one.policy for one in facts.closed_forms)}
    assert {one for one in policies if not (CONF / "model" / f"{one}.yaml").is_file()} == set()
    measures = {signature.name: signature for signature in discover()}
    for column in {facts.score, *(one.column for one in facts.closed_forms)}:
        name, _, measure = column.partition(".")
        told = measures[name].describe(measure).label
        assert told != measure or measure.startswith("n_"), f"{column} is no measure"


@pytest.mark.parametrize("facts", KNOWN, ids=lambda facts: facts.world)
def test_no_policy_that_is_told_the_answers_is_held_against_being_right(facts):
    rows = {(one.policy, one.column) for one in facts.closed_forms}
    assert (
        rows
        & {
            ("scripted/oracle", "path_efficiency.success"),
            ("scripted/oracle", "path_efficiency.spl"),
            ("scripted/knower", "map_probe.accuracy"),
        }
        == set()
    )


def test_a_file_of_the_users_own_is_read_and_stands_before_the_shipped_one(mine):
    (mine / "bar.yaml").write_text(LEAST)
    (mine / "kibo_paper.yaml").write_text("world: kibo_paper\nscore: own.score\n")
    assert facts_of("bar").score == "bar.score" and facts_of("kibo_paper").score == "own.score"
    assert facts_of("nothing_of_it") is None


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("world: [", "does not say what is known of a world"),
        (LEAST + "scores: 3\n", "scores"),
        (LEAST + "better: more\n", "better"),
        (LEAST + "closed_forms: [{name: coins}]\n", "policy"),
        ("world: pub\nscore: bar.score\n", "name the file pub.yaml"),
    ],
)
def test_a_file_that_cannot_be_read_is_told_by_its_name_and_what_is_wrong(mine, content: str, told: str):
    (mine / "bar.yaml").write_text(content)
    with pytest.raises(InputError, match=r"bar\.yaml") as caught:
        facts_of("bar")
    assert told in str(caught.value)


def test_a_world_of_which_nothing_is_known_is_answered_with_those_of_which_something_is():
    with pytest.raises(InputError, match="kibo_papr.*cafe_library"):
        list(all_facts(("kibo_papr",)))
