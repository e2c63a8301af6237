"""What every scripted policy must do, over the YAML files of its group; and what each is for."""

import asyncio
import json
import math
from collections import Counter
from typing import Any, cast

import msgspec
import pytest
import yaml

from foundry import seeding
from foundry.errors import InputError
from foundry.models.base import Request, ScriptedModel
from foundry.models.scripted.flaky import Flaky
from foundry.paths import conf_dir
from foundry.records import GridStep, Message, Outcome, Record
from foundry.running.build import build
from foundry.worlds.any.any_policies import Random
from foundry.worlds.base import Answer, Question
from foundry.worlds.grid.grid_policies import Echo, Fighter, FollowLeader, Forager, Sharer, ShortestPath
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Explicit, Uniform
from foundry.worlds.grid.parsing import read_action, read_message

SCRIPTED = conf_dir() / "model" / "scripted"
NAMES = sorted(path.stem for path in SCRIPTED.glob("*.yaml"))
PLACE = {"name": "hall", "type": "hall", "center": [5, 5], "extent": [1, 1], "capacity": 3}
FIRE = {"name": "blaze", "start": 1, "position": [-4, -4], "intensity": 0.5, "radius": 4}


def load(name: str) -> ScriptedModel:
    return cast(ScriptedModel, build(yaml.safe_load((SCRIPTED / f"{name}.yaml").read_text("utf-8"))))


GRID = [name for name in NAMES if (kinds := load(name).kinds) is None or {"message", "action"} <= set(kinds)]


def world(cells: list[list[int]] | None = None, **changes: Any) -> GridScenario:
    settings = {
        "name": "small",
        "half_size": 8,
        "agents": len(cells) if cells else 6,
        "steps": 6,
        "places": [PLACE],
        "fires": [FIRE],
        "personas": {"gender": {"female": 1.0, "male": 1.0}},
        "layout": Explicit(positions=cells) if cells else Uniform(),
        "communication_distance": 5,
        "history": {"memory": 5, "messages": 10},
    }
    return GridScenario(**(settings | changes))


def request(question: Question, seed: int = 0) -> Request:
    sampling = question.sampling_seed(seed)
    return Request(
        (), sampling, question.kind, question.observation, question.step, question.agent,
        options=question.options, idle=question.idle,
    )  # fmt: skip


def play(scenario: GridScenario, model: ScriptedModel, seed: int = 0) -> list[Record]:
    episode, records = scenario.start(seed), []
    while not episode.finished:
        requests = [request(question, seed) for question in episode.pending()]
        replies = asyncio.run(model.ask_all(requests))
        records += episode.advance([Answer(reply.text, reply.ending) for reply in replies])
    return records


def steps(records: list[Record]) -> list[GridStep]:
    return [record for record in records if isinstance(record, GridStep)]


@pytest.mark.parametrize("name", NAMES)
def test_a_policy_is_named_after_its_file_and_refuses_an_unknown_kind_of_question(name):
    model = load(name)
    assert model.name == f"scripted/{name}"
    assert not model.costs
    msgspec.json.encode(model.parameters())
    question = Question(1, 0, "parameters", {})
    with pytest.raises(InputError, match="'parameters'"):
        asyncio.run(model.ask(request(question)))


@pytest.mark.parametrize("name", [name for name in GRID if name != "flaky"])
def test_a_policy_is_always_read_as_chosen(name):
    rows = steps(play(world(), load(name)))
    assert {row.outcome for row in rows} == {row.message_outcome for row in rows} == {Outcome.CHOSEN}


def test_random_draws_uniformly_among_the_legal_actions():
    corner = world([[8, 8]]).start(0)
    corner.advance([Answer('{"message": null}')])
    (question,) = corner.pending()
    replies = [Random("r").reply(request(question, seed)) for seed in range(450)]
    counts = Counter(json.loads(reply.text).get("direction", "stay") for reply in replies)
    assert counts.keys() == {"stay", "down", "left"}
    assert all(abs(count - 150) < 3 * math.sqrt(450 * 2 / 9) for count in counts.values())


def test_a_probability_beyond_one_is_refused():
    with pytest.raises(InputError, match="stay_probability.*1.5"):
        Random("r", stay_probability=1.5)


def test_stay_neither_moves_nor_speaks():
    records = play(world(), load("stay"))
    assert not any(row.moved or row.message for row in steps(records))


def test_seek_takes_a_shortest_path_and_stays_inside():
    rows = steps(play(world([[1, 2]], steps=9), load("seek")))
    assert [row.moved for row in rows] == [True] * 5 + [False] * 4
    assert rows[-1].place == "hall"


def test_avoid_leaves_the_fire_and_does_not_return():
    rows = steps(play(world([[-4, -3]], steps=20), load("avoid")))
    gaps = [math.dist((row.x_next, row.y_next), FIRE["position"]) for row in rows]
    assert gaps[:4] == sorted(gaps[:4])
    assert all(gap > FIRE["radius"] for gap in gaps[4:])


def test_avoid_relays_warnings_to_those_who_perceive_nothing():
    records = play(world([[-4, -1], [-1, 1], [2, 4]], steps=3), load("avoid"))
    heard = {(record.step, record.recipient) for record in records if isinstance(record, Message)}
    assert (1, 1) in heard and (2, 2) in heard
    perceived = [row.fires for row in steps(records) if row.agent == 2]
    assert not any(perceived)
    last = [row for row in steps(records) if row.agent == 2][-1]
    assert last.memory == 'Fire "blaze" at (-4, -4), radius 4.'


def test_herd_gathers():
    rows = steps(play(world([[0, 0], [0, 4], [3, 2]], steps=6, fires=[]), load("herd")))
    last = [(row.x_next, row.y_next) for row in rows if row.step == 6]
    assert max(math.dist(a, b) for a in last for b in last) <= 2


def test_echo_repeats_the_last_message():
    rows = steps(play(world([[0, 0], [0, 1]], steps=2), load("echo")))
    assert [row.message for row in rows[:2]] == ["I am Agent 0.", "I am Agent 1."]
    assert [row.message for row in rows[2:]] == ["I am Agent 1.", "I am Agent 0."]


CALLS = 1000
FLAKY: Any = load("flaky")
READ = {"message": read_message, "action": read_action}
OBSERVATION = {"x": 0, "y": 0, "half_size": 3, "received": [{"sender": 1, "text": 'Where\'s "it"?'}], "agent": 0}


def spoilable(kind: str, number: int) -> Request:
    seed = seeding.sampling_seed(number, step=1, agent=0, kind=kind)
    return Request((), seed, kind, OBSERVATION, 1, 0)


@pytest.mark.parametrize("kind", READ)
def test_outcomes_come_in_the_configured_proportions(kind):
    expected = Counter({Outcome.CHOSEN: 1.0})
    for fault in FLAKY.faults:
        expected[fault.outcome] += fault.share
        expected[Outcome.CHOSEN] -= fault.share
    replies = [FLAKY.reply(spoilable(kind, number)) for number in range(CALLS)]
    counts = Counter(READ[kind](Answer(reply.text, reply.ending)).outcome for reply in replies)
    for outcome, share in expected.items():
        assert abs(counts[outcome] - CALLS * share) < 3 * math.sqrt(CALLS * share * (1 - share)), outcome


def test_a_reply_that_is_not_spoiled_is_the_wrapped_policys_own():
    policy = Echo("echo")
    assert Flaky("f", policy, {}).reply(spoilable("action", 5)) == policy.reply(spoilable("action", 5))


def test_shares_beyond_one_are_refused():
    faults = {"a": type(FLAKY.faults[0])(0.6), "b": type(FLAKY.faults[1])(0.6)}
    with pytest.raises(InputError, match="add up to 1.2"):
        Flaky("f", Echo("echo"), faults)
    with pytest.raises(InputError, match="share of the fault"):
        type(FLAKY.faults[0])(1.5)


HERE = {"agent": 3, "x": 0, "y": 0, "half_size": 9, "persona": {}, "fires": [], "memory": [], "received": []}
HERE |= {"open": ["up", "down", "left", "right"], "neighbours": [], "exits": [], "seen": [], "energy": 20, "food": []}
LEADER = {"id": 0, "x": 3, "y": 0, "persona": {"role": "leader"}}


def decided(policy: Any, **observed: Any) -> dict[str, Any]:
    content = json.loads(policy.action({**HERE, **observed}, seeding.stream(0, "test")))
    return {name: value for name, value in content.items() if name not in ("memory", "reasoning")}


def go(way: str) -> dict[str, str]:
    return {"action": "move", "direction": way}


def test_the_oracle_takes_its_way_out_and_stays_where_there_is_none():
    assert decided(ShortestPath("oracle"), ways_out=["down"]) == go("down")
    assert decided(ShortestPath("oracle"), ways_out=[]) == {"action": "stay"}
    assert decided(ShortestPath("oracle")) == {"action": "stay"}


@pytest.mark.parametrize(
    ("observed", "way"),
    [
        ({"seen": [LEADER], "ways_known": ["up"]}, "right"),
        ({"seen": [LEADER], "ways_known": ["up"], "persona": {"role": "leader"}}, "up"),
        ({"seen": [LEADER], "ways_known": ["up"], "exits": [{"seen": True}]}, "up"),
        ({"ways_known": ["down"], "exits": [{"seen": False}]}, "down"),
        ({"open": ["left"]}, "left"),
        ({"seen": [LEADER], "open": ["left"]}, "left"),
    ],
)
def test_a_follower_goes_to_a_leader_it_sees_and_to_an_exit_it_sees_or_knows(observed: dict[str, Any], way: str):
    assert decided(FollowLeader("follower"), **observed) == go(way)


def test_a_follower_warns_of_fires_and_says_nothing_without_any():
    fire = {"name": "fire", "x": 1, "y": 1, "radius": 3}
    near = {**HERE, "neighbours": [LEADER]}
    quiet, warning = (
        json.loads(FollowLeader("f").message({**near, "fires": fires}, seeding.stream(0, "test")))["message"]
        for fires in ([], [fire])
    )
    assert quiet is None and "fire" in warning


@pytest.mark.parametrize(
    ("food", "decision"),
    [
        ([{"x": 0, "y": 0, "amount": 1}, {"x": 1, "y": 0, "amount": 9}], {"action": "gather"}),
        ([{"x": 0, "y": 2, "amount": 9}, {"x": -1, "y": 0, "amount": 1}], go("left")),
        ([{"x": 0, "y": 1, "amount": 2}, {"x": -1, "y": 0, "amount": 3}], go("left")),
        ([{"x": -1, "y": 0, "amount": 3}, {"x": 0, "y": 1, "amount": 3}], go("up")),
    ],
)
def test_a_forager_gathers_the_nearest_and_of_that_the_most(food: list[dict[str, int]], decision: dict[str, str]):
    for policy in (Forager("forager"), Sharer("sharer"), Fighter("fighter")):
        assert decided(policy, food=food) == decision


def test_a_forager_reproduces_and_a_sharer_gives_when_they_have_enough_and_a_fighter_attacks():
    birth = {"needs": 20, "gives": 5}
    assert decided(Forager("forager"), reproduction=birth) == {"action": "reproduce"}
    assert decided(Forager("forager"), reproduction=birth, energy=19)["action"] == "move"
    give = {"action": "share", "target": 7, "amount": 5}
    assert decided(Sharer("sharer"), touchable=[7], energy=26) == give
    assert decided(Sharer("sharer"), touchable=[7], energy=25)["action"] == "move"
    assert decided(Fighter("fighter"), touchable=[7], energy=1) == {"action": "attack", "target": 7}


def test_all_of_them_can_stand_in_a_world_that_has_none_of_this():
    plain = {name: HERE[name] for name in ("agent", "x", "y", "half_size", "persona", "fires", "memory", "received")}
    for policy in (FollowLeader("f"), Forager("g"), Sharer("s"), Fighter("a")):
        content = json.loads(policy.action({**plain, "neighbours": []}, seeding.stream(0, "test")))
        assert content["action"] in ("stay", "move")
