"""How sure a model was of its decisions, by the log-probabilities of its tokens."""

import math
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from analysis.pipeline import analyze
from commands import foundry, refusal, succeeds
from foundry.storing.store import SweepFolder
from openai_server import Body, ChatCase, OpenAIServer, grid_reply


def telling(**chances: float) -> Callable[[Body], ChatCase]:
    """Return an answerer that decides the first of these labels and tells the chances of all."""
    first = next(iter(chances))
    rows = [{"token": name, "logprob": math.log(chance)} for name, chance in chances.items()]
    tokens = [
        {"token": '{"action": "', "logprob": 0.0},
        {**rows[0], "top_logprobs": rows},
        {"token": '"}', "logprob": 0.0},
    ]
    return lambda body: ChatCase(text=f'{{"action": "{first}"}}', logprobs=tokens if body.get("logprobs") else None)


def test_a_sweep_with_log_probabilities_has_them_in_its_log_and_certainties_in_its_steps(tmp_path: Path):
    options = ("model.options.temperature=0.5", "model.options.top_p=1.0")
    sweep = ("model=openai/a", *options, "world=bar", "world.agents=3", "world.steps=2", "seed=0", "analyze=false")
    with OpenAIServer(telling(go=0.8, stay=0.2)) as server:
        plain = foundry(*sweep, "output.dir=plain", cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
        finished = foundry(*sweep, "model.logprobs=2", "output.dir=kept", cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
        assert plain.returncode == finished.returncode == 0, finished.stderr
        assert [body.get("top_logprobs") for body in server.bodies] == [None] * 6 + [2] * 6
    (run,) = SweepFolder.open(tmp_path / "kept").runs()
    assert all([place.token for place in call.logprobs] == ['{"action": "', "go", '"}'] for call in run.calls())
    analyze(tmp_path / "kept", plots=False)
    steps = pd.read_parquet(tmp_path / "kept" / "analysis" / "steps.parquet")
    assert steps["probability"].tolist() == pytest.approx([0.8] * 6)
    assert steps["covered"].tolist() == pytest.approx([1.0] * 6)
    measures = pd.read_csv(tmp_path / "kept" / "analysis" / "signatures.csv").iloc[0]
    assert measures["certainty.probability"] == pytest.approx(0.8) and measures["certainty.n_told"] == 6
    assert measures["certainty.expected_go"] == pytest.approx(0.64 / 0.68)
    assert measures["action.share_go"] == 1
    succeeds("verify", "kept", "--workers=1", cwd=tmp_path)
    analyze(tmp_path / "plain", plots=False)
    assert "probability" not in pd.read_parquet(tmp_path / "plain" / "analysis" / "steps.parquet")
    assert not [name for name in pd.read_csv(tmp_path / "plain" / "analysis" / "signatures.csv") if "certainty" in name]


@pytest.mark.slow
def test_a_2d_world_is_played_and_measured_with_log_probabilities(tmp_path: Path):
    def answer(body: Body) -> ChatCase:
        text = grid_reply(body)
        return ChatCase(text=text, logprobs=[{"token": text, "logprob": 0.0, "top_logprobs": []}])

    sweep = ("model=openai/a", "model.logprobs=2", "world.agents=2", "world.steps=2", "seed=0", "output.dir=asked")
    with OpenAIServer(answer) as server:
        done = foundry(*sweep, cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "certainty.n_told" in pd.read_csv(tmp_path / "asked" / "analysis" / "signatures.csv")


QUIZ = """
from foundry import Actions, RoundStep
from foundry.worlds.rounds.rounds_world import RoundsScenario

class Asked(RoundStep, frozen=True, kw_only=True):
    truth: str

class Quiz(RoundsScenario):
    kinds = ("even",)
    records = (Asked,)

    def actions(self):
        return {"even": Actions(labels=("yes", "no"), idle="no")}

    def play(self, table):
        for number in table.rounds(self.steps):
            (one,) = yield [table.ask(0, "even", number=number)]
            table.record(one, truth="no" if number % 2 else "yes")
"""


def test_where_the_world_knows_what_is_right_probabilities_are_held_against_it(tmp_path: Path):
    prompt = "_target_: foundry.prompts.prompt.Prompt\nname: quiz\ntemplates: {even: 'Even? {{ number }}'}\n"
    for file, text in {
        "prompt/quiz.yaml": prompt,
        "quiz.py": QUIZ,
        "world/quiz.yaml": "_target_: quiz.Quiz\nname: quiz\nagents: 1\nsteps: 5\n",
    }.items():
        (tmp_path / "mine" / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "mine" / file).write_text(text, encoding="utf-8")
    sweep = ("--config-dir", "mine", "world=quiz", "prompt=quiz", "model=openai/a", "model.logprobs=2", "seed=0")
    with OpenAIServer(telling(yes=0.7, no=0.3)) as server:
        done = foundry(*sweep, "output.dir=asked", cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
    assert done.returncode == 0, done.stdout + done.stderr
    measures = pd.read_csv(tmp_path / "asked" / "analysis" / "signatures.csv").iloc[0]
    assert measures["certainty.n_right"] == 5  # 2 and 4 are even
    assert measures["certainty.brier"] == pytest.approx((2 * 0.18 + 3 * 0.98) / 5)
    assert measures["certainty.overconfidence"] == pytest.approx(0.7 - 2 / 5)


def test_more_tokens_than_servers_tell_are_refused(tmp_path: Path):
    assert "from 1 to 20" in refusal(
        "model=openai/a", "model.logprobs=21", cwd=tmp_path, OPENAI_BASE_URL="http://127.0.0.1:9/v1"
    )
