"""Populations: every agent has exactly one model, and the records say which."""

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from commands import foundry, refusal
from foundry.models.mixed import Rule, assign
from ollama_server import OllamaServer
from trust.conftest import MIX, SMALL, play, run_of, runs


@given(st.lists(st.integers(1, 20), min_size=1, max_size=5), st.integers(0, 60), st.integers(0, 2**32))
def test_shares_are_kept_to_less_than_one_agent(weights: list[int], agents: int, seed: int):
    rules = {str(number): Rule(share=weight / sum(weights)) for number, weight in enumerate(weights)}
    labels = assign("mix", rules, [{}] * agents, seed)
    counts = Counter(labels)
    assert len(labels) == agents
    assert all(abs(counts[label] - (rule.share or 0) * agents) < 1 for label, rule in rules.items())


def test_shares_and_ids_and_personas_are_exact_and_the_seed_draws_the_rest():
    rules = {"a": Rule(share=0.5), "b": Rule(share=0.5)}
    drawn = {tuple(assign("mix", rules, [{}] * 20, seed)) for seed in range(5)}
    assert len(drawn) == 5 and assign("mix", rules, [{}] * 20, 3) in [list(one) for one in drawn]
    personas = [{"age": "old"} if agent % 3 == 0 else {"age": "young"} for agent in range(6)]
    rules = {"ids": Rule(agents=frozenset({1})), "old": Rule(persona={"age": "old"}), "rest": Rule(share=1.0)}
    assert assign("mix", rules, personas, 0) == ["old", "ids", "rest", "old", "rest", "rest"]


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        ("mix/scripted/random@50%+scripted/herd@40%", "the shares add up to 0.9"),
        ("mix/scripted/random@0-1", "no member answers for agents 2, 3"),
        ("mix/scripted/random", "'scripted/random' is not a member"),
        ("mix/scripted/randam@100%", "Did you mean 'scripted/random'"),
        ("mix/scripted/random@3-1+scripted/stay@100%", "'3-1' is neither"),
        ("mix/scripted/random@gender:robot", "no member answers"),
        ("mix/scripted/random@0+scripted/stay@0-3", "agent 0 (seed 0) belongs to members m1 and m2"),
        ("mix/scripted/random@0-4", "there is no agent 4. The world has agents 0 to 3"),
    ],
)
def test_a_population_that_cannot_be_is_refused_before_anything_runs(model: str, expected: str, tmp_path: Path):
    assert expected in refusal(f"model={model}", *SMALL, cwd=tmp_path)


def test_records_say_which_model_answered_for_which_agent(grid_sweep: Path):
    run = run_of(grid_sweep, MIX)
    summary = run.summary()
    answered = {call.agent: call.model for call in run.calls()}
    assert {agent: member.model for member in summary.members for agent in member.agents} == answered
    assert Counter(answered.values()) == {"qwen3:4b": 2, "scripted/herd": 2}
    digests = {member.model: member.digest for member in summary.members}
    assert digests["scripted/herd"] is None and digests["qwen3:4b"]
    assert {call.digest for call in run.calls() if call.model == "qwen3:4b"} == {digests["qwen3:4b"]}


def test_a_member_has_the_cached_answers_of_its_model(tmp_path: Path):
    alone = ("model=qwen3:4b", "world.agents=2", "world.steps=1", "analyze=false", "runner.workers=1")
    with OllamaServer() as server:
        first = play(tmp_path, *alone, OLLAMA_HOST=server.url)
        first.rename(tmp_path / "first")
        mixed = play(tmp_path, "model=mix/qwen3:4b@0+scripted/stay@1", *alone[1:], OLLAMA_HOST=server.url)
        planned = foundry(
            "plan", "model=mix/qwen3:4b@0+scripted/stay@1", *alone[1:], cwd=tmp_path,
            OLLAMA_HOST=server.url, FOUNDRY_CACHE=str(tmp_path / "answers.sqlite"),
        )  # fmt: skip
    calls = {(call.agent, call.kind): call for call in runs(mixed)[0].calls()}
    assert calls[0, "message"].cached and not calls[1, "message"].cached
    assert planned.returncode == 0 and "at most 0 calls would be sent" in planned.stdout, planned.stdout


def test_a_file_of_ones_own_composes_its_members(tmp_path: Path):
    folder = tmp_path / "mine" / "model"
    folder.mkdir(parents=True)
    (folder / "pair.yaml").write_text(
        "defaults:\n- /model@members.calm.model: scripted/stay\n"
        "- /model@members.rest.model: scripted/random\n- _self_\n"
        "_target_: foundry.models.mixed.MixedModel\nname: pair\n"
        "members:\n  calm: {agents: [0, 2-3]}\n  rest: {share: 1}\n"
    )
    options = ("--config-dir", str(tmp_path / "mine"), "model.members.rest.model.stay_probability=1")
    sweep = play(tmp_path, *options, "model=pair", *SMALL)
    summary = runs(sweep)[0].summary()
    assert summary.model == "pair"
    assert [(member.model, member.agents) for member in summary.members] == [
        ("scripted/stay", (0, 2, 3)),
        ("scripted/random", (1,)),
    ]
    assert b'"action":"move"' not in runs(sweep)[0].steps_bytes()
