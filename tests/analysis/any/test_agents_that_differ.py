"""Who is alike looks alike, whatever its habits and whatever moves all at once; who differs, by as much as it does."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np
import pytest

from analysis.any.any_run import AnyRun
from analysis.any.shuffles import DRAWS, over_shuffles, p_value
from analysis.any.signatures import heterogeneity, persona_effect, utility
from analysis.stats.intervals import student_quantile
from blind_any_runs import BID, CHOICE, LABELS, Crowd, any_run
from foundry import seeding
from foundry.declared import Actions, Declared

Found = dict[str, np.ndarray]


def found(runs: Iterable[AnyRun], module: object, *names: str) -> Found:
    measured = [module.measure(run) for run in runs]  # type: ignore[attr-defined]
    values = {name: np.array([one[name] for one in measured]) for name in names}
    return {name: own[~np.isnan(own)] for name, own in values.items()}


def half_width(values: np.ndarray, rows: int = 1) -> float:
    """Return half of the interval of the mean, such that all of as many rows cover theirs in 99 % of such studies."""
    return student_quantile(len(values) - 1, 1 - 0.005 / rows) * float(values.std(ddof=1)) / math.sqrt(len(values))


def differing(shares: np.ndarray) -> float:
    """Return how many pairs of agents decide differently at a step, in the mean; chances of labels by agent (N, L)."""
    return float(np.mean([1 - one @ other for one, other in combinations(shares, 2)]))


def between(shares: np.ndarray) -> float:
    """Return the variance of the chances between agents (ddof 1), over all labels."""
    return float(shares.var(axis=0, ddof=1).sum())


TWO_SORTS = np.array([(0.6, 0.2, 0.2), (0.2, 0.6, 0.2)])


@pytest.mark.parametrize(
    "crowd",
    [
        Crowd(shares=TWO_SORTS.tolist(), steps=30, agents=10, present=(0.7,)),
        Crowd(shares=TWO_SORTS.tolist(), steps=30, agents=10, lost=0.3),
        Crowd(shares=TWO_SORTS.tolist(), steps=200, agents=10, turns=True),
    ],
    ids=["who is there", "who is read", "in turns"],
)
def test_agents_of_two_sorts_differ_by_the_variance_of_their_chances(crowd: Crowd):
    every = np.resize(TWO_SORTS, (10, 3))
    values = found(map(crowd.play, range(40)), heterogeneity, "beyond_shuffled")["beyond_shuffled"]
    assert values.mean() == pytest.approx(between(every) / differing(every), abs=half_width(values))
    assert half_width(values) < 0.08


def numbers(rows: Sequence[Sequence[float]]) -> AnyRun:
    decided = [(t + 1, i, one) for t, row in enumerate(rows) for i, one in enumerate(row)]
    return any_run(decided, kind="bid", declared=BID)


def test_numbers_of_two_sorts_differ_by_the_variance_of_their_means_whatever_their_unit():
    stream = np.random.default_rng(5)
    offset = np.tile([0.0, 1.0], 5)
    runs = [numbers(offset + stream.normal(size=(30, 1)) * 9 + stream.normal(size=(30, 10))) for _ in range(60)]
    values = found(runs, heterogeneity, "beyond_shuffled")["beyond_shuffled"]
    variance = offset.var(ddof=1)
    assert values.mean() == pytest.approx(variance / (1 + variance), abs=half_width(values))
    rows = np.random.default_rng(6).normal(size=(12, 5))
    plain, large = heterogeneity.measure(numbers(rows)), heterogeneity.measure(numbers(1e300 * rows + 1e300))
    assert plain == pytest.approx(large)


def acts(*rows: str, **changes: object) -> AnyRun:
    """Return a run: a word a step, a letter an agent (g, s, w; a point for none)."""
    letters = {"g": "go", "s": "stay", "w": "wait"}
    decided = [(t + 1, i, letters[one]) for t, row in enumerate(rows) for i, one in enumerate(row) if one in letters]
    return any_run(decided, **changes)  # type: ignore[arg-type]


def roles(*names: str) -> list[dict[str, str]]:
    return [{"role": name} for name in names]


def test_two_agents_of_their_own_ways_differ_wholly_and_swapped_ones_the_other_way_round():
    assert heterogeneity.measure(acts("gs", "gs")) == pytest.approx({"beyond_shuffled": 1, "p": 0.5, "n_agents": 2})
    assert heterogeneity.measure(acts("gs", "sg")) == pytest.approx({"beyond_shuffled": -1, "p": 1, "n_agents": 2})


UNDEFINED = {
    "no decision": any_run([], personas=roles("a", "b")),
    "one step": acts("gs", personas=roles("a", "b")),
    "one agent": acts("g", "s", "g", personas=roles("a")),
    "all do the same": acts("ggg", "sss", "www", personas=roles("a", "b", "b")),
    "nobody stays": acts("gs..", "..gs", personas=roles("a", "b", "a", "b")),
}


@pytest.mark.parametrize("run", UNDEFINED.values(), ids=UNDEFINED)
def test_without_any_who_could_differ_lastingly_it_is_undefined(run: AnyRun):
    measures = heterogeneity.measure(run)
    assert math.isnan(measures["beyond_shuffled"]) and math.isnan(measures["p"]) and measures["n_agents"] == 0


@pytest.mark.parametrize("names", [("a", "a", "a"), ("a", "b", "c")], ids=["one group", "each its own"])
def test_without_groups_there_is_no_persona_effect(names: tuple[str, ...]):
    measures = persona_effect.measure(acts("gsg", "ggs", personas=roles(*names)))
    assert math.isnan(measures["role"]) and math.isnan(measures["p_role"]) and measures["n_agents"] == 3


def test_agents_without_an_attribute_are_left_out_of_it_and_nobody_with_one_has_none():
    assert persona_effect.measure(acts("gs", "gs")) == {"n_agents": 0}
    some = acts("ggssw", "ggssw", personas=[*roles("a", "a", "b", "b"), {"age": "9"}])
    assert persona_effect.measure(some)["p_role"] == pytest.approx(8 / 24)
    assert math.isnan(persona_effect.measure(some)["age"])


def test_agents_are_held_against_those_alone_who_are_asked_the_same():
    both = Declared(form="ring", actions={**CHOICE.actions, "judge": Actions(labels=LABELS)}, streams=CHOICE.streams)
    rows = [(t, i, LABELS[i % 2]) for t in (1, 2, 3) for i in range(4)]
    kinds = ["choice", "choice", "judge", "judge"] * 3
    run = any_run(rows, kind=kinds, declared=both, personas=roles("a", "a", "b", "b"))
    measures = heterogeneity.measure(run)
    assert measures["beyond_shuffled"] == pytest.approx(1) and measures["p"] == pytest.approx(1 / 4, abs=0.05)
    assert measures["n_agents"] == 4
    assert math.isnan(persona_effect.measure(run)["role"])  # what is asked goes with the role, and is no effect of it
    steps = [("choice", (0, 0, 1, 1)), ("judge", (0, 1))]
    rows = [(t, i, LABELS[one], kind) for t in (1, 2, 3) for kind, did in steps for i, one in enumerate(did)]
    run = any_run([row[:3] for row in rows], kind=[row[3] for row in rows], declared=both)
    # Only the first two judge. They choose alike, and so do the others; in judging they differ wholly, which has two
    # halves of a decision of each third, of a weight of 1/2 among 1/2 (judge), 3/4 and 3/4 (choice).
    assert heterogeneity.measure(run)["beyond_shuffled"] == pytest.approx(0.5 / (0.5 + 0.75 + 0.75))


def test_neither_the_order_of_agents_nor_a_second_look_makes_a_difference():
    crowd = Crowd(shares=TWO_SORTS.tolist(), groups=list("aabbabab"))
    run = crowd.play(3)
    turned = replace(run, agent=7 - run.agent, personas=run.personas[::-1])
    for module in (heterogeneity, persona_effect):
        assert module.measure(turned) == pytest.approx(module.measure(run), abs=0.03)
    play = Crowd(agents=9, groups=3).play
    for module in (heterogeneity, persona_effect):
        assert module.measure(play(1)) == module.measure(play(1))


def test_luck_makes_no_lasting_difference_of_utility_and_skill_does():
    stream = np.random.default_rng(7)
    run = Crowd(agents=10, steps=30).play(0)
    lucky = [replace(run, utility=stream.normal(size=run.decisions)) for _ in range(40)]
    values = found(lucky, utility, "beyond_shuffled", "spread")
    assert abs(values["beyond_shuffled"].mean()) <= half_width(values["beyond_shuffled"]) and values["spread"].min() > 0
    skilled = [replace(run, utility=stream.normal(size=run.decisions) + run.agent % 2) for _ in range(40)]
    values = found(skilled, utility, "beyond_shuffled")
    variance = np.tile([0, 1], 5).var(ddof=1)
    own = values["beyond_shuffled"]
    assert own.mean() == pytest.approx(variance / (1 + variance), abs=half_width(own))


def test_all_orders_of_a_few_agents_are_taken_and_of_many_the_same_random_ones_and_p_counts_the_run_itself():
    few = over_shuffles(lambda rows: rows @ np.array([1, 10, 100]), 1, 0, 3)
    assert sorted(few.tolist()) == [12, 21, 102, 120, 201, 210] and few[0] == 210
    many = over_shuffles(lambda rows: rows[:, 0] * 1.0, 1, 0, 2000)
    assert len(many) == DRAWS + 1 and many[0] == 0 and 900 < many.mean() < 1100
    assert (many == over_shuffles(lambda rows: rows[:, 0] * 1.0, 1, 0, 2000)).all()
    assert not np.array_equal(many, over_shuffles(lambda rows: rows[:, 0] * 1.0, 1, 1, 2000))
    assert p_value(np.array([0.3, 0.1 + 0.2, 0.4, 0.1])) == 0.75


def by_hand(letters: list[str], agent: int) -> np.ndarray:
    """Return the shares of LABELS that an agent has over rows of letters."""
    return np.array([np.mean([row[agent] == one for row in letters]) for one in "gsw"])


def variance_between(shares: list[np.ndarray]) -> float:
    return float(np.var(shares, axis=0, ddof=1).sum())


def pairs_that_differ(letters: list[str]) -> float:
    return float(np.mean([one != other for row in letters for one, other in combinations(row, 2)]))


@pytest.mark.parametrize("seed", range(3))
def test_lasting_differences_are_variance_between_agents_less_that_of_all_shuffled_ones(seed: int):
    stream = seeding.stream(seed, "letters")
    letters = ["".join(stream.choice(list("gsw"), 4)) for _ in range(8)]
    first, last = letters[:2], letters[-2:]
    spreads = [
        variance_between([(by_hand(first, i) + by_hand(last, order[i])) / 2 for i in range(4)])
        for order in permutations(range(4))
    ]
    measures = heterogeneity.measure(acts(*letters))
    expected = 2 * (spreads[0] - np.mean(spreads)) / pairs_that_differ([*first, *last])
    assert measures["beyond_shuffled"] == pytest.approx(expected)
    assert measures["p"] == pytest.approx(np.mean(np.array(spreads) >= spreads[0] - 1e-9))


@pytest.mark.parametrize("seed", range(3))
def test_a_persona_effect_is_the_spread_of_groups_less_that_of_all_shuffled_ones(seed: int):
    stream = seeding.stream(seed, "letters")
    letters = ["".join(stream.choice(list("gsw"), 5)) for _ in range(8)]
    groups = "aabbb"
    shares = np.array([by_hand(letters, i) for i in range(5)])

    def between_groups(order: Sequence[int]) -> float:
        mine = shares[list(order)] - shares.mean(axis=0)
        return float(sum(mine[:2].sum(axis=0) ** 2 / 2 + mine[2:].sum(axis=0) ** 2 / 3))

    spreads = [between_groups(order) for order in permutations(range(5))]
    measures = persona_effect.measure(acts(*letters, personas=roles(*groups)))
    beyond = (spreads[0] - np.mean(spreads)) / (1 - 1 / 4) / 4
    assert measures["role"] == pytest.approx(beyond / pairs_that_differ(letters))
    assert measures["p_role"] == pytest.approx(np.mean(np.array(spreads) >= spreads[0] - 1e-9))
