"""The naming game: who meets whom and when, what is remembered, what succeeds, who is never asked, how it grows."""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from foundry import seeding
from foundry.conformance.playing import play
from foundry.records import Record
from foundry.worlds.any.any_policies import Random
from foundry.worlds.base import Answer, Question
from foundry.worlds.rounds.naming import Meeting, Naming, NamingGame, waves
from foundry.worlds.rounds.rounds_policies import BestResponse, FocalName
from scripted_rounds import records
from small_worlds import naming as game


def answered(scenario: NamingGame, say: Callable[[Question], str], seed: int = 0) -> Sequence[Record]:
    answers = lambda asked: [Answer(json.dumps({"action": say(one)})) for one in asked]  # noqa: E731
    return play(scenario.start(seed), answers, most=scenario.count_calls()).records


def meetings(written: Sequence[Record]) -> list[Meeting]:
    return sorted((meeting for meeting in written if isinstance(meeting, Meeting)), key=lambda meeting: meeting.number)


def own_name(question: Question) -> str:
    return ("ama", "bodo", "ceri")[question.agent % 3]


PAIRS = st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)).filter(lambda pair: pair[0] != pair[1]), max_size=20)


@given(PAIRS)
def test_every_pair_meets_as_soon_as_those_before_it_with_its_agents_have_met(pairs: list[tuple[int, int]]):
    found = waves(pairs)
    assert sorted(place for wave in found for place in wave) == list(range(len(pairs)))
    at = {place: number for number, wave in enumerate(found) for place in wave}
    for place, pair in enumerate(pairs):
        shared = [at[other] for other in range(place) if set(pairs[other]) & set(pair)]
        assert at[place] == max(shared, default=-1) + 1


def test_two_that_say_the_same_name_succeed_and_others_fail():
    written = answered(game(steps=9), own_name)
    met = meetings(written)
    assert [(meeting.number, meeting.step) for meeting in met] == [(place + 1, place // 3 + 1) for place in range(27)]
    assert (
        all(meeting.equal == (meeting.first % 3 == meeting.second % 3) for meeting in met)
        and len({meeting.equal for meeting in met}) == 2
    )
    said = [naming for naming in written if isinstance(naming, Naming)]
    pairs = Counter((meeting.number, agent) for meeting in met for agent in (meeting.first, meeting.second))
    assert Counter((naming.number, naming.agent) for naming in said) == pairs
    equal = {meeting.number: meeting.equal for meeting in met}
    assert all(naming.utility == (100 if equal[naming.number] else -50) for naming in said)


def test_each_remembers_its_latest_meetings_in_their_order_before_the_next():
    past: dict[int, list[dict[str, Any]]] = {agent: [] for agent in range(6)}
    seen: list[Question] = []
    world = game(steps=20).start(1)
    while not world.finished:
        questions = world.pending()
        for question in questions:
            assert question.observation["memory"] == past[question.agent][-2:]
            assert question.observation["points"] == sum(met["points"] for met in past[question.agent])
            assert sorted(question.observation["names"]) == ["ama", "bodo", "ceri"]
        written = world.advance([Answer(json.dumps({"action": own_name(question)})) for question in questions])
        for met in (meeting for meeting in written if isinstance(meeting, Meeting)):
            names = (met.first_name, met.second_name)
            for agent, (own, other) in ((met.first, names), (met.second, names[::-1])):
                past[agent].append({"own": own, "other": other, "points": 100 if met.equal else -50})
        seen += questions
    again = Counter((question.step, question.agent) for question in seen if question.again)
    assert again, "some are asked twice in a round, each time with another seed"
    assert len({question.sampling_seed(0) for question in seen}) == len(seen)


def test_all_pairs_are_equally_likely_and_a_speaker_draws_evenly_among_the_names_that_it_knows():
    episodes = [answered(game(steps=50), own_name, seed) for seed in range(4)]
    met = Counter(frozenset((meeting.first, meeting.second)) for episode in episodes for meeting in meetings(episode))
    assert len(met) == 15 and all(abs(count - 40) < 5 * 6.2 for count in met.values())
    pair = game(protocol="speaker", agents=2, steps=1)
    first = Counter(meeting.first_name for seed in range(90) for meeting in meetings(records(pair, Random("r"), seed)))
    assert set(first) == {"ama", "bodo", "ceri"} and all(abs(count - 30) < 5 * 4.5 for count in first.values())


def test_what_cannot_be_read_names_nothing_and_fails():
    met = meetings(answered(game(steps=1), lambda _: "dada"))
    assert {(meeting.first_name, meeting.second_name, meeting.equal) for meeting in met} == {(None, None, False)}


def test_who_is_committed_says_one_name_and_is_asked_nothing():
    scenario = game(agents=9, committed=1 / 3, committed_name="bodo", steps=40)
    written = answered(scenario, lambda _: "ama", 5)
    asked = {naming.agent for naming in written if isinstance(naming, Naming)}
    assert len(asked) == 6
    for meeting in meetings(written):
        for agent, name in ((meeting.first, meeting.first_name), (meeting.second, meeting.second_name)):
            assert name == ("ama" if agent in asked else "bodo")
    other = {naming.agent for naming in answered(scenario, lambda _: "ama", 6) if isinstance(naming, Naming)}
    assert other != asked, "the seed draws who is committed"


def test_an_established_name_is_what_all_remember():
    first = game(established="ceri").start(0).pending()[0]
    assert first.observation["memory"] == [{"own": "ceri", "other": "ceri", "points": 100}] * 2
    assert (first.observation["met"], first.observation["points"]) == (2, 200)
    written = records(game(established="ceri"), BestResponse("best"), 0)
    assert all(meeting.first_name == meeting.second_name == "ceri" for meeting in meetings(written))


def by_the_classic_rules(met: Sequence[Meeting], agents: int) -> list[bool]:
    """Return which meetings succeed in the minimal naming game, whose speakers say what they said here."""
    known: list[set[str]] = [set() for _ in range(agents)]
    found = []
    for meeting in met:
        name = meeting.first_name
        assert name is not None
        speaker, hearer = known[meeting.first], known[meeting.second]
        assert name in (speaker or {f"n{meeting.first}"}), "a speaker says a name it knows, or else invents one"
        speaker.add(name)
        found.append(name in hearer)
        if found[-1]:
            known[meeting.first], known[meeting.second] = {name}, {name}
        else:
            hearer.add(name)
    return found


@given(st.integers(0, 50), st.integers(2, 12))
@settings(max_examples=15)
def test_with_a_speaker_it_is_the_minimal_naming_game(seed: int, agents: int):
    scenario = game(protocol="speaker", names=None, agents=agents, steps=30)
    met = meetings(records(scenario, Random("random"), seed))
    assert [meeting.equal for meeting in met] == by_the_classic_rules(met, agents)
    assert all(meeting.second_name is None for meeting in met)


def test_a_committed_hearer_learns_nothing():
    scenario = game(protocol="speaker", agents=2, committed=0.5, committed_name="ceri", steps=60)
    met = meetings(answered(scenario, lambda question: min(question.observation["names"])))
    assert {meeting.equal for meeting in met if meeting.first_name == "ama"} == {False}
    assert {meeting.first_name for meeting in met} == {"ama", "ceri"}


def test_it_ends_with_a_consensus_where_that_is_set_in_the_first_round_in_which_its_share_succeeds():
    assert len(meetings(records(game(until="consensus", steps=9), FocalName("focal"), 0))) == 3
    assert len(meetings(records(game(steps=9), FocalName("focal"), 0))) == 27
    assert len(meetings(answered(game(until="consensus", steps=9), own_name))) == 27
    ends = set()
    for seed in range(4):
        scenario = game(agents=40, steps=30, until="consensus")
        met = meetings(answered(scenario, lambda question: "ama" if question.agent else "bodo", seed))
        successes = [
            sum(meeting.equal for meeting in met if meeting.step == step) for step in range(1, met[-1].step + 1)
        ]
        assert [count >= 19 for count in successes].index(True) == len(successes) - 1, "19 of 20 are 95 %"
        ends.add(successes[-1])
    assert ends == {19, 20}


def test_the_best_response_is_what_others_said_most_and_is_drawn_where_several_would_do():
    def said(*others: str | None) -> set[str]:
        memory = [{"own": "ama", "other": other, "points": 0} for other in others]
        observation = {"names": ["ceri", "bodo", "ama"], "memory": memory}
        rng = seeding.stream(0, "test")
        return {json.loads(BestResponse("best").say(observation, rng))["action"] for _ in range(40)}

    assert said("bodo", None, "ceri", "bodo") == {"bodo"}
    assert said("bodo", "ceri") == {"bodo", "ceri"}
    assert said() == said(None) == {"ama", "bodo", "ceri"}


@given(st.integers(0, 30), st.lists(st.sampled_from(["", "ama", '{"say": "ceri"}', "{", "no name"]), min_size=1))
def test_whatever_is_answered_every_meeting_is_written_once(seed: int, said: list[str]):
    world = game(agents=5, committed=0.2, committed_name="ama").start(seed)
    written: list[Record] = list(world.opening())
    while not world.finished:
        written += world.advance([Answer(said[place % len(said)]) for place, _ in enumerate(world.pending())])
    assert [meeting.number for meeting in meetings(written)] == list(range(1, 7))
