"""How sure a model was of its decisions, by the log-probabilities of its tokens."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd
import pytest

from analysis.measuring.certainty import certainty_of
from analysis.pipeline import analyze
from commands import foundry
from foundry.canary import TokenLogprobs
from foundry.storing.store import SweepFolder
from openai_server import Body, ChatCase, OpenAIServer

LABELS = ("go", "stay")


def token(text: str, **top: float) -> TokenLogprobs:
    return TokenLogprobs(text, -0.1, {name: math.log(share) for name, share in top.items()})


def test_the_shares_of_the_labels_are_those_of_the_tokens_that_begin_them():
    tokens = [token('{"action": "'), token("go", go=0.6, stay=0.2, Go=0.1), token('"}')]
    found = certainty_of('{"action": "go"}', tokens, "go", LABELS)
    assert found is not None
    assert (found.probability, found.covered) == (pytest.approx(0.75), pytest.approx(0.8))
    assert found.entropy == pytest.approx(-0.75 * math.log2(0.75) - 0.25 * math.log2(0.25))


def test_a_token_may_hold_the_mark_before_or_after_a_label():
    top = {' "go"': math.log(0.9), ' "st': math.log(0.1)}
    found = certainty_of(
        '{"action": "go"}', [token('{"action":'), TokenLogprobs(' "go"', -0.1, top), token("}")], "go", LABELS
    )
    assert found is not None and found.probability == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("text", "decided", "labels"),
    [
        ("I go, they go", "go", LABELS),  # which of them decides?
        ("go", "go", ("go", "goal")),  # labels that begin alike
        ("goes", "stay", LABELS),  # a decision that is not in the text
    ],
)
def test_where_no_one_token_decides_nothing_is_said(text: str, decided: str, labels: tuple[str, ...]):
    assert certainty_of(text, [TokenLogprobs(text, 0.0, {text: 0.0, "go": -1.0})], decided, labels) is None


def test_a_reply_whose_tokens_are_not_its_text_says_nothing():
    assert certainty_of("go", [token("stay", stay=1.0)], "go", LABELS) is None


def told(body: Body) -> ChatCase:
    """Answer `go`, told with .8 beside `stay` with .2."""
    rows = [{"token": name, "logprob": math.log(share)} for name, share in (("go", 0.8), ("stay", 0.2))]
    tokens = [
        {"token": '{"action": "', "logprob": 0.0},
        {**rows[0], "top_logprobs": rows},
        {"token": '"}', "logprob": 0.0},
    ]
    return ChatCase(text='{"action": "go"}', logprobs=tokens if body.get("logprobs") else None)


def test_a_sweep_with_log_probabilities_has_them_in_its_log_and_certainties_in_its_steps(tmp_path: Path):
    sweep = ("model=openai/a", "world=bar", "world.agents=3", "world.steps=2", "seed=0", "analyze=false")
    with OpenAIServer(told) as server:
        plain = foundry(*sweep, "output.dir=plain", cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
        kept = foundry(*sweep, "model.logprobs=2", "output.dir=kept", cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
        assert plain.returncode == kept.returncode == 0, kept.stderr
        assert [body.get("top_logprobs") for body in server.bodies] == [None] * 6 + [2] * 6
    (run,) = SweepFolder.open(tmp_path / "kept").runs()
    assert all([place.token for place in call.logprobs] == ['{"action": "', "go", '"}'] for call in run.calls())
    analyze(tmp_path / "kept", plots=False)
    steps = pd.read_parquet(tmp_path / "kept" / "analysis" / "steps.parquet")
    assert steps["probability"].tolist() == pytest.approx([0.8] * 6)
    assert steps["covered"].tolist() == pytest.approx([1.0] * 6)
    assert foundry("verify", "kept", "--workers=1", cwd=tmp_path).returncode == 0
    analyze(tmp_path / "plain", plots=False)
    assert "probability" not in pd.read_parquet(tmp_path / "plain" / "analysis" / "steps.parquet")


def test_more_tokens_than_servers_tell_are_refused(tmp_path: Path):
    refused = foundry("model=openai/a", "model.logprobs=21", cwd=tmp_path, OPENAI_BASE_URL="http://127.0.0.1:9/v1")
    assert refused.returncode == 2 and "from 1 to 20" in refused.stderr
