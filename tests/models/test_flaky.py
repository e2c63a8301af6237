from __future__ import annotations

import math
from collections import Counter

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from foundry import seeding
from foundry.errors import InputError
from foundry.models.base import Request
from foundry.models.scripted.flaky import Fault, Flaky
from foundry.paths import conf_dir
from foundry.records import Outcome
from foundry.worlds.base import Answer
from foundry.worlds.grid.grid_policies import Echo
from foundry.worlds.grid.parsing import read_action, read_message

CALLS = 2000
READ = {"message": read_message, "action": read_action}
OBSERVATION = {"x": 0, "y": 0, "half_size": 3, "received": [{"sender": 1, "text": 'Where\'s "it"?'}], "agent": 0}


def load() -> Flaky:
    flaky: Flaky = instantiate(OmegaConf.load(conf_dir() / "model" / "scripted" / "flaky.yaml"), _convert_="all")
    return flaky


def request(kind: str, number: int) -> Request:
    seed = seeding.sampling_seed(number, step=1, agent=0, kind=kind)
    return Request((), seed, kind, OBSERVATION, 1, 0)


@pytest.mark.parametrize("kind", READ)
def test_outcomes_come_in_the_configured_proportions(kind):
    model = load()
    expected = Counter({Outcome.CHOSEN: 1.0})
    for fault in model.faults:
        expected[fault.outcome] += fault.share
        expected[Outcome.CHOSEN] -= fault.share
    replies = [model.reply(request(kind, number)) for number in range(CALLS)]
    counts = Counter(READ[kind](Answer(reply.text, reply.ending)).outcome for reply in replies)
    for outcome, share in expected.items():
        assert abs(counts[outcome] - CALLS * share) < 3 * math.sqrt(CALLS * share * (1 - share)), outcome


@pytest.mark.parametrize("kind", READ)
@pytest.mark.parametrize("fault", load().faults, ids=lambda fault: type(fault).__name__)
def test_each_fault_has_the_outcome_it_names_and_changes_no_decision(fault: Fault, kind):
    policy = Echo("echo")
    for number in range(50):
        text = policy.reply(request(kind, number)).text
        reply = fault.spoil(text)
        reading = READ[kind](Answer(reply.text, reply.ending))
        assert reading.outcome is fault.outcome
        if fault.outcome is Outcome.REPAIRED:
            assert reading.decision == READ[kind](Answer(text)).decision


def test_a_reply_that_is_not_spoiled_is_the_wrapped_policys_own():
    policy = Echo("echo")
    assert Flaky("f", policy, {}).reply(request("action", 5)) == policy.reply(request("action", 5))


def test_shares_beyond_one_are_refused():
    faults = {"a": type(load().faults[0])(0.6), "b": type(load().faults[1])(0.6)}
    with pytest.raises(InputError, match="add up to 1.2"):
        Flaky("f", Echo("echo"), faults)
    with pytest.raises(InputError, match="share of the fault"):
        type(load().faults[0])(1.5)
