"""A declared sweep stops at the look at which its question is answered: `until=answered`."""

from __future__ import annotations

import pytest

from commands import foundry, statuses
from foundry.storing.store import SweepFolder
from ollama_cases import BAD_OPTION
from ollama_server import OllamaServer
from own_market import write_market

SMALL = ("seed=0-7", "world.agents=2", "world.steps=2", "analyze=false", "output.dir=out")
LOOKS = ("--family", "idle_rate.chosen", "--looks", "6,8")
UNLIKE = ("-m", "model=scripted/random,scripted/stay", *SMALL)
ALIKE = ("-m", "model=scripted/random", "prompt=paper,paper_prefix", *SMALL)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sweep", "seeds", "said"),
    [
        (UNLIKE, 6, "answered at look 1 of 2, at 6 seeds"),
        pytest.param(ALIKE, 8, "not answered at look 2 of 2, at 8 seeds", marks=pytest.mark.exhaustive),
    ],
)
def test_a_sweep_goes_on_to_the_next_look_until_it_is_answered(tmp_path, sweep, seeds, said):
    assert foundry("preregister", *sweep, *LOOKS, cwd=tmp_path).returncode == 0
    done = foundry(*sweep, "until=answered", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    recorded = SweepFolder.open(tmp_path / "out").sweep
    assert {one.seeds for one in recorded.conditions} == {tuple(range(seeds))}
    assert len(recorded.history) == (1 if seeds == 6 else 2)


@pytest.mark.slow
def test_what_goes_on_with_it_later_is_analysed_as_the_sweep_asked(tmp_path):
    asked = [*(word for word in UNLIKE if word != "analyze=false"), "world=bar"]  # has few pictures to draw
    assert foundry("preregister", *asked, "--family", "bar.score", "--looks", "6,8", cwd=tmp_path).returncode == 0
    done = foundry(*asked, "until=answered", cwd=tmp_path)
    assert done.stdout.count("tables: out/analysis") == 1
    assert SweepFolder.open(tmp_path / "out").settings["analyze"] is True
    assert "tables: out/analysis" in foundry("resume", "out", "seed=6-7", cwd=tmp_path).stdout


@pytest.mark.slow
def test_a_run_that_fails_each_time_is_missing_from_the_look_as_planned_and_holds_up_none(tmp_path):
    own = ("--config-dir", str(write_market(tmp_path)))
    market = ("-m", "world=market", "prompt=market", "world.leaky=[2]", "model=bidder,miser", "seed=0-7", *SMALL[-2:])
    assert foundry("preregister", *own, *market, *LOOKS, cwd=tmp_path).returncode == 0
    done = foundry(*own, *market, "until=answered", cwd=tmp_path)
    assert done.returncode == 3
    assert "not answered at look 1 of 2, at 6 seeds" in done.stdout
    assert "\nstill open: idle_rate.chosen (" in done.stdout
    assert "; as planned, without the pairs of 2 failed runs" in done.stdout
    assert "\nanswered at look 2 of 2, at 8 seeds" in done.stdout
    assert "try the failed runs again with: foundry resume out" in done.stdout
    assert sorted(statuses(tmp_path / "out")) == ["complete"] * 14 + ["failed"] * 2


@pytest.mark.slow
def test_runs_that_have_not_ended_hold_up_the_look(tmp_path):
    served = ("-m", "model=qwen3:4b,llama3.2", *SMALL, "runner.open_runs=1")
    with OllamaServer(lambda body: BAD_OPTION) as server:
        assert foundry("preregister", *served, *LOOKS, cwd=tmp_path, OLLAMA_HOST=server.url).returncode == 0
        done = foundry(*served, "until=answered", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert done.returncode == 3
    assert "the sweep was stopped" in done.stderr and "answered" not in done.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((*UNLIKE, "until=answered"), "'out' has none: foundry preregister makes it"),
        ((*UNLIKE[:-1], "until=answered"), "no output.dir is named"),
        ((*UNLIKE, "until=soon"), "until=soon is neither null nor answered"),
    ],
)
def test_nothing_is_answered_that_was_not_declared(tmp_path, words, message):
    done = foundry(*words, cwd=tmp_path)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert message in done.stderr


def test_another_sweep_than_was_declared_is_refused(tmp_path):
    assert foundry("preregister", *UNLIKE, *LOOKS, cwd=tmp_path).returncode == 0
    done = foundry(*UNLIKE, "world.steps=3", "until=answered", cwd=tmp_path)
    assert done.returncode == 2
    assert "of 16 runs in preregistration.yaml 16 are not asked for, and 16 are asked for beside them" in done.stderr
