"""Whether one and the same prompt gets one and the same answer, over runs that are sampled again."""

import math
from collections import Counter, defaultdict

import msgspec
import numpy as np
import pytest

from analysis.retest import Decisions, counted, retest
from commands import succeeds
from foundry.storing.store import SweepFolder
from walkers import make_condition, rewrite_run


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    """Two seeds, each sampled three times, of a model that draws its answers and of one that does not."""
    folder = tmp_path_factory.mktemp("sampled")
    succeeds(
        "-m", "model=scripted/random,scripted/stay,scripted/flaky", "seed=0-1", "sampling_seed=1-3", "world.agents=6",
        "world.steps=3", "world.communication_distance=8", "analyze=false", "runner.workers=1", "output.dir=sweep",
        cwd=folder,
    )  # fmt: skip
    return SweepFolder.open(folder / "sweep")


@pytest.fixture(scope="module")
def frame(sampled):
    return retest([sampled])


def recounted(sweep: SweepFolder, model: str, seed: int, kind: str) -> list[Counter]:
    """Return the choices by prompt that was put in two runs or more, from the files, with plain loops."""
    states: dict[tuple, Counter] = defaultdict(Counter)
    for run in sweep.runs():
        if (run.config()["model"]["name"], run.config()["seed"]) != (model, seed):
            continue
        rows: dict[tuple, list] = defaultdict(list)
        for row in map(msgspec.json.decode, run.steps_bytes().splitlines()):
            rows[row["step"], row["agent"]].append(row)
        asked = Counter()
        for call in run.calls():
            place = call.step, call.agent
            if call.kind == kind:
                row = rows[place][asked[place]]
                outcome = row["message_outcome" if kind == "message" else "outcome"]
                choice = row["message"] is not None if kind == "message" else str((row["action"], row.get("direction")))
                unread = outcome not in ("chosen", "repaired")
                states[place, asked[place], str(call.messages)]["?" if unread else choice] += 1
                asked[place] += 1
    return [choices for choices in states.values() if choices.total() > 1]


def agreement(states: list[Counter]) -> float:
    pairs = [sum(n * (n - 1) for n in state.values()) / (state.total() * (state.total() - 1)) for state in states]
    return float(np.mean(pairs))


@pytest.mark.parametrize("model", ["scripted/random", "scripted/flaky"])
@pytest.mark.parametrize("kind", ["action", "message"])
def test_agreement_is_that_of_the_same_prompts(sampled, frame, model, kind):
    for seed in (0, 1):
        states = recounted(sampled, model, seed, kind)
        row = frame[(frame["model"] == model) & (frame["seed"] == seed) & (frame["kind"] == kind)].iloc[0]
        assert row["runs"] == 3
        assert row["prompts"] == len(states)
        assert row["decisions"] == sum(map(Counter.total, states))
        if states:
            agreed = agreement(states)
            assert row["agreement"] == pytest.approx(agreed)
            whole = sum(states, Counter())
            chance = sum((n / whole.total()) ** 2 for n in whole.values())
            assert row["kappa"] == pytest.approx(
                (agreed - chance) / (1 - chance) if chance < 1 else math.nan, nan_ok=True
            )


def test_the_same_prompts_are_compared_and_a_model_that_never_varies_agrees_with_itself(sampled, frame):
    messages = frame[(frame["kind"] == "message") & (frame["model"] == "scripted/random")]
    calls = [sum(call.step == 1 and call.kind == "message" for call in run.calls()) for run in sampled.runs()]
    assert (messages["prompts"] >= min(calls)).all()
    actions = frame[(frame["model"] == "scripted/stay") & (frame["kind"] == "action")]
    assert actions["prompts"].tolist() == [18, 18]
    assert actions["agreement"].tolist() == [1, 1]
    assert actions["kappa"].isna().all()


def test_agents_that_are_asked_twice_in_a_step_are_compared_by_the_same_question(tmp_path):
    succeeds(
        "-m", "model=scripted/random", "world=naming", "world.agents=4", "world.names=[ama,bodo,ceri]", "seed=0",
        "world.steps=2",
        "sampling_seed=0-5", "analyze=false", "output.dir=sweep", cwd=tmp_path,
    )  # fmt: skip
    sweep = SweepFolder.open(tmp_path / "sweep")
    choices = recounted(sweep, "scripted/random", 0, "say")
    (row,) = retest([sweep]).to_dict("records")
    assert row["prompts"] == len(choices) > 1
    assert row["agreement"] == pytest.approx(agreement(choices))


def test_without_a_log_of_calls_no_prompt_is_known_and_failed_runs_and_those_sampled_once_are_not_compared(make_sweep):
    conditions = [make_condition("a", [0], factors=("sampling_seed",), sampling_seed=seed) for seed in (1, 2)]
    sweep = make_sweep(conditions)
    frame = retest([sweep])
    assert (frame["prompts"].tolist(), frame["runs"].tolist()) == ([0, 0], [2, 2])
    assert frame[["agreement", "kappa", "agreement_readable", "kappa_readable"]].isna().all(axis=None)
    rewrite_run(sweep.runs()[0], "failed")
    assert len(retest([sweep])) == 0
    assert len(retest([make_sweep([make_condition("a", range(3))], name="once")])) == 0


def test_what_could_not_be_read_is_a_choice_of_its_own_or_left_out():
    unread = Decisions(np.array([[0]]), np.array([[False]]))
    stay, up = (Decisions(np.array([[choice]]), np.array([[True]])) for choice in (0, 1))
    states = {(1, 0, 0, b""): [0, 1, 2]}
    assert counted(states, [unread, stay, up], readable_only=False).tolist() == [[1, 1, 1]]
    assert counted(states, [unread, stay, up], readable_only=True).tolist() == [[1, 1, 0]]
    assert counted(states, [unread, unread, up], readable_only=True).tolist() == []
