"""A probe whose server tells log-probabilities: one reply stands for all where its probabilities say what all are."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from analysis.probes.probe_tables import analyze_probe
from foundry.probing.seen import SeenProbe
from foundry.storing.probed import ANSWERS, choices_in
from foundry.storing.store import SweepFolder
from openai_server import Body, ChatCase, OpenAIServer
from probing.conftest import QUIET, done, lines, runs

pytestmark = pytest.mark.slow

MOMENTS, REPEATS = 12, 10
OPENLY = ("model.options.temperature=1", "model.options.top_p=1", "+model.extra.top_k=0", "+model.extra.min_p=0")
ASKED = ("probe", "pilot", "-m", "model=openai/a,openai/b", f"moments={MOMENTS}", f"repeats={REPEATS}", "window=0")


def told(body: Body, go: float) -> list[tuple[str, dict[str, float]]]:
    """Return the tokens of a reply, each with the chances in its place; those of a reasoning model begin with words."""
    chances = {"go": go, "stay": 1 - go}
    words = {"Well: ": 0.5, "So: ": 0.5} if "reasoning" in body else {}
    rng = np.random.default_rng(body["seed"])
    drawn = str(rng.choice(list(chances), p=list(chances.values())))
    before = str(rng.choice(list(words))) if words else ""
    return [*([(before, words)] if words else []), ('{"action": "', {}), (drawn, chances), ('"}', {})]


def answer(body: Body) -> ChatCase:
    """Draw the decision by the chances that are told: .8 for model `a` to go, .3 for `b`."""
    tokens = told(body, {"a": 0.8, "b": 0.3}[body["model"]])
    rows = [
        {
            "token": token,
            "logprob": math.log(chances.get(token, 1.0)),
            "top_logprobs": [{"token": name, "logprob": math.log(chance)} for name, chance in chances.items()],
        }
        for token, chances in tokens
    ]
    return ChatCase(text="".join(token for token, _ in tokens), logprobs=rows if body.get("logprobs") else None)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pilot of six seeds, probed with probabilities, by repeats, and with words before the decision."""
    folder = tmp_path_factory.mktemp("told")
    bar = ("world=bar", "world.agents=2", "world.steps=2", *QUIET)
    done("-m", "model=scripted/random", "seed=0-5", *bar, "output.dir=pilot", cwd=folder)
    with OpenAIServer(answer) as server:
        for name, more in (
            ("told", ("model.logprobs=5",)),
            ("repeated", ()),
            ("reasoned", ("model.logprobs=5", "+model.extra.reasoning=true")),
        ):
            asked = (*ASKED, *OPENLY, *more, *QUIET, f"output.dir={name}")
            printed = done(*asked, cwd=folder, OPENAI_BASE_URL=server.base_url)
            assert ("one for all repeats where probabilities suffice" in printed) == (name != "repeated")
    return folder


def moments_of(folder: Path) -> pd.DataFrame:
    analyze_probe(SweepFolder.open(folder), plots=False)
    return pd.read_csv(folder / "analysis" / "moments.csv")


def test_one_call_a_moment_gives_the_shares_that_repeats_estimate(folder: Path):
    by_probability, by_repeats = moments_of(folder / "told"), moments_of(folder / "repeated")
    assert (by_probability["count"].sum(), by_repeats["count"].sum()) == (2 * MOMENTS, 2 * MOMENTS * REPEATS)
    assert set(by_probability["by"]) == {"probabilities"} and set(by_repeats["by"]) == {"repeats"}
    for model, go in (("openai/a", 0.8), ("openai/b", 0.3)):
        exact, sampled = (
            frame[(frame["model"] == model) & (frame["choice"] == "go")]["share"]
            for frame in (by_probability, by_repeats)
        )
        assert exact.tolist() == pytest.approx([go] * MOMENTS)
        assert abs(sampled.sum() / MOMENTS - go) < 3 * math.sqrt(go * (1 - go) / MOMENTS / REPEATS)


def test_models_are_as_far_apart_as_their_probabilities_with_a_floor_of_many_answers(folder: Path):
    probe_analysis = analyze_probe(SweepFolder.open(folder / "told"), plots=False)
    row = probe_analysis.frames["agreement"].iloc[0]
    assert row["distance"] == pytest.approx(0.5) and 0 < row["floor"] < 0.02 and row["standing_out"] == 1
    assert set(probe_analysis.contrasts["out_of_reach"]) == {""}
    repeated = analyze_probe(SweepFolder.open(folder / "repeated"), plots=False)
    assert repeated.frames["agreement"].iloc[0]["floor"] > 0.1


def test_after_drawn_words_repeats_are_asked_and_the_analysis_says_which(folder: Path):
    moments = moments_of(folder / "reasoned")
    assert moments["count"].sum() == 2 * MOMENTS * REPEATS and set(moments["by"]) == {"repeats"}
    moments_of(folder / "told")
    lead = (folder / "told" / "analysis" / "summary.md").read_text()
    assert f"{2 * MOMENTS} of {2 * MOMENTS} sets of choices come from the probabilities of one reply" in lead


def test_a_probe_by_probabilities_is_verified_and_shown_with_its_shares(folder: Path):
    assert "12 runs: 12 identical" in done("verify", "told", cwd=folder)
    assert "12 runs: 12 identical" in done("verify", "reasoned", cwd=folder)
    run = next(run for run in runs(folder / "told") if run.config()["model"]["name"] == "openai/a")
    assert [line["repeat"] for line in lines(run)] == [0] * len(lines(run))
    for choices in choices_in(run).values():
        assert choices.counts == {"go": 800, "stay": 200} and choices.counts.total() == ANSWERS
    seen = SeenProbe(SweepFolder.open(folder / "told"))
    assert {answered.counts["go"] for row in seen.overview().moments for answered in row.answered} == {800, 300}
    assert seen.seen(0).answers[0].expected == pytest.approx({"go": 0.8, "stay": 0.2})
