"""Models stand beside what is known of their world, which is read from files."""

from pathlib import Path

import pytest

from analysis import analyze
from analysis.signatures import discover
from analysis.validation.facts import ClosedForm, Published, all_facts, facts_of
from analysis.validation.known_values import changed, elsewhere, nearest, validation_table
from commands import foundry
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
    policies = {facts.random, *filter(None, [facts.best]), *(closed_form.policy for closed_form in facts.closed_forms)}
    assert {policy for policy in policies if not (CONF / "model" / f"{policy}.yaml").is_file()} == set()
    measures = {signature.name: signature for signature in discover()}
    for column in {facts.score, *(closed_form.column for closed_form in facts.closed_forms)}:
        name, _, measure = column.partition(".")
        told = measures[name].describe(measure).label
        assert told != measure or measure.startswith("n_"), f"{column} is no measure"
    rows = {(closed_form.policy, closed_form.column) for closed_form in facts.closed_forms}
    told_the_answers = {
        ("scripted/oracle", "path_efficiency.success"),
        ("scripted/oracle", "path_efficiency.spl"),
        ("scripted/knower", "map_probe.accuracy"),
    }
    assert not rows & told_the_answers, "who is told the answers is not held against being right"


def test_a_file_of_the_users_own_is_read_and_stands_before_the_shipped_one(mine):
    (mine / "bar.yaml").write_text(LEAST)
    (mine / "kibo_paper.yaml").write_text("world: kibo_paper\nscore: own.score\n")
    assert facts_of("bar").score == "bar.score" and facts_of("kibo_paper").score == "own.score"
    assert facts_of("nothing_of_it") is None
    with pytest.raises(InputError, match="kibo_papr.*cafe_library"):
        list(all_facts(("kibo_papr",)))


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("world: [", "does not contain valid known results of a world"),
        (LEAST + "scores: 3\n", "scores"),
        (LEAST + "better: more\n", "better"),
        (LEAST + "closed_forms: [{name: coins}]\n", "policy"),
        ("world: pub\nscore: bar.score\n", "rename it to pub.yaml"),
    ],
)
def test_a_file_that_cannot_be_read_is_told_by_its_name_and_what_is_wrong(mine, content: str, told: str):
    (mine / "bar.yaml").write_text(content)
    with pytest.raises(InputError, match=r"bar\.yaml") as caught:
        facts_of("bar")
    assert told in str(caught.value)


FACTS = """
world: cafe_library
score: idle_rate.chosen
better: lower
best: scripted/avoid
closed_forms:
  - {name: idlers, policy: scripted/stay, column: idle_rate.chosen, value: 1, why: it stays}
  - {name: pairs, policy: scripted/stay, column: outcome.n_decisions, value: 8, why: counted}
published:
  - {model: "random:8b", value: 0.25, source: A table, certain: known}
differs: small
"""
PUBLISHED = [
    Published(model=name, value=1.0, source="s")
    for name in ("llama3.1:8b", "llama3.1:70b", "qwen2:72b", "gpt-4o", "mixtral:8x7b")
]


@pytest.mark.parametrize(
    ("model", "found"),
    [
        ("llama3.1:8b", "llama3.1:8b"),
        ("llama3.1:70b-instruct-q4_K_M", "llama3.1:70b"),
        ("openai/some-lab/Qwen2-72B", "qwen2:72b"),
        ("qwen2.5:72b", "qwen2:72b"),
        ("qwen3:4b", None),
        ("qwen2:7b", None),
        ("gemma2:70b", None),
        ("gpt-4o", "gpt-4o"),
        ("gpt-4o-mini", None),
        ("mixtral:latest", "mixtral:8x7b"),
        ("mixtral:8x22b", None),
        ("llama3.1", None),
        ("scripted/stay", None),
    ],
)
def test_the_published_figure_is_of_the_model_of_the_same_size_whose_name_is_nearest(model: str, found: str | None):
    near = nearest(model, PUBLISHED)
    assert (near.model if near else None) == found


def test_settings_that_are_not_the_files_and_closed_forms_of_other_settings_are_told():
    usual = {"half_size": 25, "agents": 20, "steps": 50, "communication_distance": 5}
    assert changed(usual, "cafe_library") == ""
    assert changed(usual | {"agents": 4}, "cafe_library") == "agents=4, not 20"
    assert changed(dict.fromkeys(usual, 7), "cafe_library") == "4 settings changed"
    assert changed({"agents": 3}, "of_no_file") == ""
    assert changed(usual | {"fires": [], "personas": None}, "cafe_library") == (
        "fires=[], not [...]; personas=null, not {...}"
    )
    coins, told_less, *_ = (
        closed_form
        for closed_form in facts_of("bar").closed_forms
        if "coins" in closed_form.name or closed_form.overrides
    )
    usual = {"agents": 10, "reports": "explicit"}
    assert [elsewhere(one, usual, "bar") for one in (coins, told_less)] == ["", ' (at reports="implicit")']
    assert elsewhere(told_less, usual | {"reports": "implicit"}, "bar") == ""
    assert elsewhere(coins, usual | {"agents": 20}, "bar") == " (at agents=10)"
    overrides = ("world.history={memory: 1}", "world.steps=7", "world.personas=null")
    nested = ClosedForm(name="one", policy="p", column="c", value=1, why="", overrides=overrides)
    found = {"steps": 7, "history": {"memory": 5, "messages": 10}, "personas": {}}
    assert elsewhere(nested, found, "cafe_library") == " (at personas=null, history.memory=1)"


@pytest.mark.slow
def test_each_group_has_its_null_its_best_policy_and_what_was_published(tmp_path, monkeypatch):
    (tmp_path / "mine" / "validation").mkdir(parents=True)
    (tmp_path / "mine" / "validation" / "cafe_library.yaml").write_text(FACTS)
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    asked = ("-m", "model=scripted/stay,scripted/random,scripted/avoid", "seed=0", "world.agents=2", "world.steps=2")
    foundry(*asked, "output.dir=s", "analyze=false", cwd=tmp_path)
    analysis = analyze(tmp_path / "s", plots=False)
    rows = analysis.validation.set_index("model")
    means = analysis.comparison[analysis.comparison["measure"] == "idle_rate.chosen"].set_index("model")["mean"]
    assert list(rows.index) == ["scripted/stay", "scripted/random", "scripted/avoid"]
    assert rows["mean"].to_dict() == means.to_dict() and rows.loc["scripted/stay", "mean"] == 1
    assert set(rows["random"]) == {means["scripted/random"]} and set(rows["best"]) == {means["scripted/avoid"]}
    assert set(rows["closed_forms"]) == {"idlers 1 (at agents=20, steps=50)"} and rows["n"].tolist() == [1, 1, 1]
    assert rows["differs"].tolist()[0] == "small; agents=2, not 20; steps=2, not 50"
    assert rows["published"].notna().tolist() == [False, True, False]
    assert (
        rows.loc["scripted/random", "source"] == "A table"
        and rows.loc["scripted/random", "published_certain"] == "known"
    )
    assert {file.name for file in analysis.written} >= {"validation.csv", "validation.md", "validation.tex"}
    assert "0.25 (random:8b, A table)" in (analysis.path / "validation.md").read_text().replace("\\", "")
    (tmp_path / "mine" / "validation" / "cafe_library.yaml").write_text("world: cafe_library\nscore: of.nothing\n")
    assert not len(analyze(tmp_path / "s", plots=False).validation) and not (analysis.path / "validation.md").exists()


@pytest.mark.slow
def test_rows_of_one_model_are_told_apart_by_what_else_was_swept(tmp_path):
    swept = ("prompt=paper,japanese", "world.agents=2,3", "world.steps=2", "output.dir=s", "analyze=false")
    foundry("-m", "model=scripted/stay", "seed=0", *swept, cwd=tmp_path)
    analysis = analyze(tmp_path / "s", plots=False)
    names = [f"prompt={prompt}, world.agents={agents}" for prompt in ("paper", "japanese") for agents in (2, 3)]
    assert sorted(analysis.validation["settings"]) == sorted(names)
    table = validation_table(analysis.validation)
    assert table.columns[:4] == ("world", "model", "settings", "measure")
    assert len({row[: table.labels] for row in table.rows}) == len(table.rows) == 4
