"""Hand-worked examples of the signatures of every form."""

import math
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from analysis import signatures
from analysis.any.any_run import AnyRun
from analysis.any.signatures import action, communication, cost, idle_rate, outcome, stability, utility
from analysis.arrays import OUTCOMES
from blind_any_runs import BID, CHOICE, any_run
from foundry import seeding
from foundry.declared import Actions, Declared
from foundry.records import Counts, Outcome

BOTH = Declared(form="ring", actions={**CHOICE.actions, "bid": Actions(low=0, high=9, idle=0)}, streams=CHOICE.streams)


def with_outcomes(run: AnyRun, *outcomes: Outcome) -> AnyRun:
    return replace(run, outcome=np.array([OUTCOMES.index(outcome) for outcome in outcomes]))


def saying(run: AnyRun, said: list[str | None], heard: list[tuple[int, int, int]]) -> AnyRun:
    return replace(run, said=np.array(said, dtype=np.object_), deliveries=np.array(heard).reshape(-1, 3))


def getting(run: AnyRun, *utilities: float) -> AnyRun:
    return replace(run, utility=np.array(utilities))


def undefined(found: dict[str, float]) -> set[str]:
    return {name for name, value in found.items() if math.isnan(value)}


def test_actions_are_counted_by_declared_label_and_numbers_have_a_mean_and_a_spread():
    measures = action.measure(any_run([(1, 0, "go"), (1, 1, "go"), (2, 0, "stay"), (2, 1, None)]))
    assert measures["share_go"] == 2 / 3 and measures["share_stay"] == 1 / 3 and measures["share_wait"] == 0
    assert measures["variety"] == pytest.approx(2 / 3)  # two of three pairs
    assert measures["bits"] == pytest.approx(math.log2(3) - 2 / 3)
    assert measures["entropy"] == pytest.approx((math.log2(3) - 2 / 3) / math.log2(3))
    assert measures["n_actions"] == 3
    measures = action.measure(any_run([(1, 0, 1), (1, 1, 2.0), (2, 0, 6)], kind="bid", declared=BID))
    assert measures == {"mean": 3.0, "sd": pytest.approx(math.sqrt(7)), "n_actions": 3.0}
    assert undefined(action.measure(any_run([(1, 0, 1)], kind="bid", declared=BID))) == {"sd"}


def test_names_of_actions_are_by_kind_and_do_not_depend_on_what_is_decided():
    measures = action.measure(any_run([(1, 0, "go"), (1, 0, 4)], kind=["choice", "bid"], declared=BOTH))
    assert measures["share_choice_go"] == 1 and measures["mean_bid"] == 4
    assert {"variety_choice", "entropy_choice", "n_actions_choice", "n_actions_bid"} <= set(measures)
    assert list(action.measure(any_run([]))) == list(action.measure(any_run([(1, 0, "go")])))
    assert undefined(action.measure(any_run([]))) == set(action.measure(any_run([]))) - {"n_actions"}
    measures = action.measure(any_run([(1, 0, "up"), (2, 0, "down")], declared=Declared(form="any")))
    assert measures["variety"] == 1 and measures["bits"] == 1 and undefined(measures) == {"entropy"}


def test_idle_is_what_the_world_declares_as_doing_nothing_and_what_was_read():
    kinds = ["choice", "choice", "bid", "bid", "choice", "talk"]
    rows: list[tuple[int, int, Any]] = [(1, 0, "stay"), (1, 1, "go"), (1, 0, 0), (1, 1, 5), (2, 0, None), (2, 1, None)]
    run = any_run(rows, kind=kinds, declared=BOTH)
    run = with_outcomes(run, *[Outcome.CHOSEN] * 4, Outcome.EMPTY, Outcome.CHOSEN)
    assert idle_rate.measure(run) == {"chosen": 2 / 5, "invalid": 1 / 5, "n_decisions": 5.0}
    assert idle_rate.measure(run.only_readable()) == {"chosen": 1 / 2, "invalid": 0.0, "n_decisions": 4.0}
    run = with_outcomes(any_run([(1, 0, "stay"), (1, 1, "stay")]), Outcome.CHOSEN, Outcome.UNREADABLE)
    assert idle_rate.measure(run)["chosen"] == idle_rate.measure(run)["invalid"] == 1 / 2
    assert undefined(idle_rate.measure(any_run([(1, 0, 3)], kind="bid", declared=BID))) == {"chosen", "invalid"}


def test_outcomes_of_actions_and_of_talk_are_told_apart():
    run = any_run([(1, 0, "go"), (1, 0, None), (2, 0, None), (2, 0, None)], kind=["choice", "talk", "choice", "talk"])
    measures = outcome.measure(with_outcomes(run, Outcome.CHOSEN, Outcome.REPAIRED, Outcome.EMPTY, Outcome.FAILED))
    assert (measures["chosen"], measures["empty"], measures["readable"], measures["n_decisions"]) == (0.5, 0.5, 0.5, 2)
    assert (measures["message_repaired"], measures["message_failed"], measures["message_readable"]) == (0.5, 0.5, 0.5)
    silent = replace(run, declared=BID)
    assert not [name for name in outcome.measure(silent) if "message" in name]


def test_cost_is_by_decision():
    run = any_run([(1, 0, "go"), (1, 1, "go")])
    spent = Counts(calls=4, cached=1, prompt_tokens=100, output_tokens=10, cached_tokens=25, model_s=2.0)
    assert cost.measure(replace(run, totals=spent, wall_s=1.0))["prompt_cached_share"] == 0.25
    untold = cost.measure(replace(run, totals=msgspec.structs.replace(spent, cached_tokens=None), wall_s=1.0))
    assert undefined(untold) == {"prompt_cached_share"}
    assert cost.measure(replace(run, totals=spent))["calls_per_decision"] == 2
    assert undefined(cost.measure(run)) == set(cost.MEASURES)


def test_pairs_are_of_one_agent_and_one_kind_whatever_lies_between():
    rows: list[tuple[int, int, Any]] = [
        (1, 0, "go"), (1, 1, "stay"), (1, 0, 2), (3, 0, "go"), (3, 1, "go"), (3, 0, 3), (4, 0, "stay"), (4, 0, 3),
    ]  # fmt: skip
    kinds = ["choice", "choice", "bid", "choice", "choice", "bid", "choice", "bid"]
    measures = stability.measure(any_run(rows, kind=kinds, declared=BOTH))
    # Agent 0: go go stay and 2 3 3; agent 1: stay go.
    assert measures["n_pairs"] == 5 and measures["persistence"] == 2 / 5 and measures["switching"] == 3 / 5
    # By chance one of three pairs of each of the first two, which have two pairs, and none of the last.
    assert measures["repeats_beyond_chance"] == pytest.approx((2 - 2 / 3 - 2 / 3) / 5)
    assert measures["n_runs"] == 6 and measures["run_length"] == 8 / 6


def test_pairs_part_where_a_decision_does_not_count_and_without_any_stability_is_undefined():
    run = any_run([(1, 0, "go"), (2, 0, "go"), (3, 0, None), (4, 0, "go"), (5, 0, "go")])
    run = with_outcomes(run, Outcome.CHOSEN, Outcome.EMPTY, Outcome.EMPTY, Outcome.CHOSEN, Outcome.CHOSEN)
    assert stability.measure(run)["n_pairs"] == 2 and stability.measure(run.only_readable())["n_pairs"] == 1
    assert stability.measure(run)["repeats_beyond_chance"] == 0
    measures = stability.measure(any_run([(1, 0, "go"), (1, 1, "go")]))
    assert undefined(measures) == {"persistence", "switching", "repeats_beyond_chance"} and measures["run_length"] == 1
    assert undefined(stability.measure(any_run([]))) == {*stability.MEASURES}


def test_messages_are_counted_by_agent_and_step():
    run = any_run([(1, 0, "go"), (1, 1, "go"), (1, 1, None), (2, 0, "go"), (2, 1, "go"), (3, 0, "go"), (3, 2, "go")])
    run = saying(run, ["hi", None, "oh", "hi", "no", None, None], [(1, 0, 1), (1, 1, 0), (2, 0, 2), (2, 0, 1)])
    measures = communication.measure(run)
    assert measures["rate"] == 4 / 6 and measures["n_decisions"] == 6 and measures["n_messages"] == 4
    # Agents 0 and 1 at step 2, agent 2 at step 3; agent 1 has no step 3.
    assert measures["reply_rate"] == pytest.approx(2 / 3) and measures["n_after_one"] == 3
    assert measures["silent_share"] == pytest.approx(1 / 3) and measures["gini"] == pytest.approx(1 / 3)
    assert measures["audience"] == 1 and measures["length"] == 2
    assert measures["variety"] == 5 / 6 and measures["distinct_share"] == 3 / 4 and measures["n_agents"] == 3


def test_what_could_not_be_read_says_nothing_and_silence_is_a_rate_of_nothing():
    run = saying(any_run([(1, 0, "go"), (1, 1, "go")]), ["hi", "ho"], [(1, 0, 1), (1, 1, 0)])
    measures = communication.measure(with_outcomes(run, Outcome.CHOSEN, Outcome.FAILED).only_readable())
    assert (measures["n_messages"], measures["n_deliveries"], measures["n_decisions"], measures["n_agents"]) == (
        1,
        1,
        1,
        1,
    )
    measures = communication.measure(any_run([(1, 0, "go")]))
    assert measures["rate"] == 0 and measures["silent_share"] == 1
    assert undefined(measures) == {"reply_rate", "gini", "audience", "length", "variety", "distinct_share"}
    assert communication.measure(any_run([(1, 0, 1)], kind="bid", declared=BID)) == {}


def test_utility_is_by_agent_and_decision_and_undefined_without_any():
    run = any_run([(1, 0, "go"), (1, 1, "go"), (2, 0, "go"), (2, 1, "go"), (2, 2, "go")])
    measures = utility.measure(getting(run, 1, 4, 3, math.nan, 0))
    assert (
        measures["mean"] == 2 and measures["spread"] == 2 and measures["n_agents"] == 3 and measures["n_decisions"] == 4
    )
    assert measures["gini"] == pytest.approx(16 / (2 * 9 * 2))  # of 2, 4 and 0
    measures = utility.measure(any_run([(1, 0, "go")]))
    assert undefined(measures) == {*utility.MEASURES} and measures["n_agents"] == 0
    assert utility.measure(any_run([(1, 0, 1)], kind="bid", declared=BID)) == {}
    assert undefined(utility.measure(getting(any_run([(1, 0, "go"), (1, 1, "go")]), 0, 0))) == {
        "gini",
        "beyond_shuffled",
    }


@pytest.mark.parametrize(
    ("utilities", "gini"),
    [
        ((1, 1, 1, 1), 0),
        ((0, 0, 0, 8), 3 / 4),
        ((-2, -2, -2, -2), 0),
        ((0, 0, 0, -8), 3 / 4),
        ((-4, 0, 0, 4), 3 / 4),  # as unequal as it can be: all losses with one, all gains with another
        ((-1, 1, -1, 1), 1 / 2),
    ],
)
def test_the_gini_of_gains_and_losses_stays_within_its_bounds(utilities: tuple[float, ...], gini: float):
    run = any_run([(1, agent, "go") for agent in range(4)])
    assert utility.measure(getting(run, *utilities))["gini"] == pytest.approx(gini)


def odd_run(seed: int) -> AnyRun:
    """Return a small run of anything that a world may record: huge and tiny numbers, silence, gaps, lost replies."""
    stream = seeding.stream(seed, "odd runs")
    size, agents = int(stream.integers(14)), int(stream.integers(1, 5))
    kinds = stream.choice(["choice", "bid", "talk"], size).tolist()
    choices: dict[str, list[Any]] = {
        "choice": [None, "go", "stay"],
        "bid": [None, 0, 1e308, -1e308, 5e-324],
        "talk": [None],
    }
    rows = [
        (step, int(stream.integers(agents)), choices[kind][int(stream.integers(len(choices[kind])))])
        for step, kind in zip(np.sort(stream.integers(1, 6, size)).tolist(), kinds, strict=True)
    ]
    personas = [{"role": str(stream.integers(2))} for _ in range(agents)]
    return any_run(
        rows, kind=kinds, declared=BOTH, personas=personas,
        outcome=stream.integers(len(OUTCOMES), size=size),
        utility=stream.choice([math.nan, 0, -3, 1e308, 1e-9], size),
        said=np.array([None, "hi"], dtype=np.object_)[stream.integers(2, size=size)],
        deliveries=np.column_stack([stream.integers(1, 6, 3), stream.integers(agents, size=(3, 2))]),
    )  # fmt: skip


def test_whatever_a_run_holds_its_measures_are_the_same_ones_and_within_their_bounds():
    measured = [signatures.measure(odd_run(seed)) for seed in range(30)]
    assert {tuple(one) for one in measured} == {tuple(measured[0])}
    bounds = {name: signatures.describe(name) for name in measured[0]}
    outside = {
        name
        for one in measured
        for name, value in one.items()
        if not math.isnan(value) and not bounds[name].low - 1e-9 <= value <= bounds[name].high + 1e-9
    }
    assert outside == set()
