"""The 2D world: who is asked what, hears whom and moves where, how it is drawn, and which settings it refuses."""

import itertools
import json
import math
import struct
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from foundry.errors import InputError
from foundry.paths import conf_dir
from foundry.records import GridStep, Message, Outcome, Record
from foundry.worlds.base import Answer, World
from foundry.worlds.grid.grid_drawing import draw, make_frame
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Clustered, Explicit, Uniform
from foundry.worlds.grid.space import FEW, distances, neighbours
from worlds.grid.shipped import make, make_at

SILENT = Answer('{"message": null, "reasoning": "r"}')
STAY = Answer('{"action": "stay", "memory": "", "reasoning": ""}')

WORLDS = sorted(
    path.stem
    for path in (conf_dir() / "world").glob("*.yaml")
    if "\n_target_: foundry.worlds.grid." in f"\n{path.read_text('utf-8')}"
)


def say(text: str) -> Answer:
    return Answer(json.dumps({"message": text, "reasoning": "r"}))


def go(direction: str, memory: str = "") -> Answer:
    return Answer(json.dumps({"action": "move", "direction": direction, "memory": memory, "reasoning": "r"}))


def play(world: World, steps: int, seed: int = 0) -> list[Record]:
    rng = np.random.default_rng(seed)
    records: list[Record] = []
    while not world.finished and world.step < steps:
        answers = []
        for question in world.pending():
            words = ["up", "down", "left", "right", "nowhere"]
            word = words[int(rng.integers(len(words)))]
            answers.append(say(word) if question.kind == "message" else go(word, memory=f"went {word}"))
        records += world.advance(answers)
    return records


def lines(records: list[Record]) -> bytes:
    return b"\n".join(map(msgspec.json.encode, records))


@pytest.mark.parametrize("name", WORLDS)
def test_agents_start_outside_all_places_and_are_asked_as_many_questions_as_their_world_says(name):
    scenario = make(name)
    for seed in range(5):
        assert all(question.observation["place"] is None for question in scenario.start(seed).pending())
    scenario = make(name, steps=3)
    world, asked = scenario.start(0), 0
    while not world.finished:
        questions = world.pending()
        assert {question.kind for question in questions} < set(scenario.kinds)
        asked += len(questions)
        world.advance([SILENT if question.kind == "message" else STAY for question in questions])
    assert asked == scenario.count_calls()
    assert world.pending() == ()
    with pytest.raises(ValueError, match="over"):
        world.advance([])


def brute_force(cells: list[tuple[int, int]], scenario: GridScenario, agent: int) -> tuple[int, ...]:
    def area(cell: tuple[int, int]) -> str | None:
        inside = [
            place.name
            for place in scenario.settings.places
            if place.x_min <= cell[0] <= place.x_max and place.y_min <= cell[1] <= place.y_max
        ]
        return inside[0] if inside else None

    return tuple(
        other
        for other, cell in enumerate(cells)
        if other != agent
        and area(cell) == area(cells[agent])
        and math.dist(cell, cells[agent]) <= scenario.settings.communication_distance
    )


@given(
    cells=st.lists(st.tuples(st.integers(-25, 25), st.integers(-25, 25)), min_size=1, max_size=30),
    reach=st.sampled_from([0, 1, 2**0.5, 5, 7.5, 100]),
    seed=st.integers(0, 2**32),
)
@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_rules_hold_wherever_agents_stand(cells, reach, seed):
    scenario = make_at(*cells, communication_distance=reach)
    records = play(scenario.start(0), 2, seed)
    half_size = scenario.settings.half_size
    for step in (1, 2):
        rows = [row for row in records if isinstance(row, GridStep) and row.step == step]
        messages = [row for row in records if isinstance(row, Message) and row.step == step]
        assert [row.agent for row in rows] == list(range(len(cells)))
        before = [(row.x, row.y) for row in rows]
        for row in rows:
            assert max(abs(row.x_next), abs(row.y_next)) <= half_size
            assert abs(row.x_next - row.x) + abs(row.y_next - row.y) == row.moved
            assert row.neighbours == brute_force(before, scenario, row.agent)
            assert row.moved <= (row.outcome in (Outcome.CHOSEN, Outcome.REPAIRED))
        sent = [(message.sender, message.recipient) for message in messages]
        assert sent == [(row.agent, other) for row in rows for other in row.neighbours]
    assert {(row.x_next, row.y_next) for row in rows} >= {(row.x, row.y) for row in rows if not row.moved}


def test_a_move_over_the_edge_is_blocked_and_one_to_another_agent_is_not():
    world = make_at((25, 0), (0, -25)).start(0)
    world.advance([SILENT] * 2)
    right, down = world.advance([go("right"), go("down")])
    assert (right.action, right.direction, right.moved, right.x_next) == ("move", "right", False, 25)
    assert (down.action, down.direction, down.moved, down.y_next) == ("move", "down", False, -25)
    world = make_at((0, 0), (1, 0), (3, 0)).start(0)
    world.advance([SILENT] * 3)
    records = world.advance([go("right"), go("left"), go("left")])
    assert [(record.x_next, record.moved) for record in records] == [(1, True), (0, True), (2, True)]


def test_a_message_is_heard_in_the_action_of_its_step_and_the_message_of_the_next():
    world = make_at((0, 0), (1, 0)).start(0)
    assert all(question.observation["received"] == [] for question in world.pending())
    world.advance([say("hello"), SILENT])
    first, second = (question.observation for question in world.pending())
    assert (first["received"], first["message"]) == ([], "hello")
    assert (second["received"], second["message"]) == ([{"sender": 0, "text": "hello"}], None)
    world.advance([STAY, STAY])
    later = world.pending()[1]
    assert (later.kind, later.observation["received"]) == ("message", [{"sender": 0, "text": "hello"}])
    assert "message" not in later.observation


def test_histories_are_bounded_and_keep_the_newest_last():
    world = make_at((0, 0), (1, 0), history={"memory": 2, "messages": 3}).start(0)
    for step in range(5):
        world.advance([say(f"m{step}")] * 2)
        world.advance([go("up", memory=f"t{step}")] * 2)
    observation = world.pending()[0].observation
    assert observation["memory"] == ["t3", "t4"]
    assert [heard["text"] for heard in observation["received"]] == ["m2", "m3", "m4"]


def test_only_a_read_decision_is_remembered():
    world = make_at((0, 0), (0, 2), (0, 4), (0, 6)).start(0)
    world.advance([SILENT] * 4)
    broken = Answer('{"action": "fly", "memory": "no"}')
    fenced = Answer('```{"action": "stay", "memory": "yes"}```')
    gone = Answer('{"action": "stay", "memory": "no"}', ending="aborted")
    world.advance([broken, fenced, gone, STAY])
    assert [question.observation["memory"] for question in world.pending()] == [[], ["yes"], [], []]


def test_a_model_failure_leaves_the_agent_in_place_and_says_so():
    outcomes = {Answer(""): Outcome.EMPTY, Answer("I would rather not"): Outcome.UNREADABLE}
    outcomes |= {Answer('{"action": "mo', "length"): Outcome.TRUNCATED, Answer("", "aborted"): Outcome.FAILED}
    for answer, outcome in outcomes.items():
        world = make_at((0, 0), (1, 0)).start(0)
        assert world.advance([answer, SILENT]) == []
        record = world.advance([answer, go("up")])[0]
        assert (record.action, record.direction, record.moved) == ("stay", None, False)
        assert (record.outcome, record.message_outcome) == (outcome, outcome)
        assert (record.message, record.memory) == (None, "")


def test_a_fire_is_perceived_from_its_start_within_its_radius():
    fire = {"name": "f", "start": 2, "position": [0, 0], "intensity": 1, "radius": 5}
    world = make_at((3, 4), (4, 4), fires=[fire]).start(0)
    assert all(question.observation["fires"] == [] for question in world.pending())
    world.advance([SILENT] * 2)
    world.advance([STAY] * 2)
    near, far = (question.observation["fires"] for question in world.pending())
    assert near == [{"name": "f", "x": 0, "y": 0, "intensity": 1, "radius": 5, "distance": 5.0}]
    assert far == []


def test_an_agent_inside_a_place_is_told_its_numbers():
    observation = make_at((15, 0), (20, 5), (0, 0)).start(0).pending()[0].observation
    numbers = {"agents": 2, "capacity": 10, "occupancy_rate": 0.2}
    assert observation["place"] == {"name": "library", "type": "library", **numbers}


def test_asking_again_changes_nothing_and_a_wrong_number_of_answers_is_refused():
    world = make_at((0, 0), (1, 0)).start(0)
    before = world.pending()
    kept = msgspec.json.encode([question.observation for question in before])
    assert world.pending() == before
    world.advance([say("hello")] * 2)
    world.advance([go("up", memory="m")] * 2)
    assert msgspec.json.encode([question.observation for question in before]) == kept
    with pytest.raises(ValueError, match="1 answers for 2"):
        make_at((0, 0), (1, 0)).start(0).advance([SILENT])


def test_personas_follow_their_weights_and_do_not_depend_on_the_layout():
    scenario = make(agents=2000, half_size=100, personas={"age": {20: 3, 60: 1}, "gender": {"x": 1, "y": 0}})
    personas = scenario.personas(1)
    assert {persona["gender"] for persona in personas} == {"x"}
    assert abs(sum(persona["age"] == "20" for persona in personas) - 1500) < 3 * math.sqrt(2000 * 3 / 16)
    clustered = {"_target_": "foundry.worlds.grid.layouts.Clustered", "clusters": 2, "radius": 3}
    assert make().personas(7) == make(layout=clustered).personas(7)


def test_a_clustered_layout_stays_outside_and_near_its_centres():
    clustered = {"_target_": "foundry.worlds.grid.layouts.Clustered", "clusters": 2, "radius": 3}
    observed = [question.observation for question in make(layout=clustered).start(2).pending()]
    assert all(observation["place"] is None for observation in observed)
    groups = ([(seen["x"], seen["y"]) for seen in observed[start::2]] for start in (0, 1))
    first, second = map(list, groups)
    for group in (first, second):
        assert max(math.dist(*pair) for pair in itertools.combinations(group, 2)) <= 6
    assert max(math.dist(*pair) for pair in itertools.product(first, second)) > 6, "one cluster is not the other"


@pytest.mark.parametrize("agents", [FEW, FEW + 1])
def test_few_and_many_agents_have_the_neighbours_that_distances_give(agents: int):
    rng = np.random.default_rng(0)
    cells, areas = rng.integers(-15, 16, size=(agents, 2)), rng.integers(-1, 2, size=agents)
    near = distances(cells[:, None], cells) <= 5
    expected = [
        tuple(other for other in range(agents) if other != one and near[one, other] and areas[one] == areas[other])
        for one in range(agents)
    ]
    assert list(neighbours(cells, areas, 5)) == expected


def frame_of(scenario, step, cells):
    return make_frame(scenario.settings, scenario.personas(0), step, cells)


def test_a_frame_is_a_png_of_800_pixels_with_the_same_bytes_each_time_also_of_an_empty_world():
    frame = frame_of(make_at((0, 0), (0, 0), (3, 3)), 7, [(0, 0), (0, 0), (3, 3)])
    png = draw(frame)
    assert png.startswith(b"\x89PNG") and struct.unpack(">II", png[16:24]) == (800, 800)
    assert b"Software" not in png
    assert draw(replace(frame)) == png
    assert make_at((0, 0), places=[], fires=[], personas={}).start(0).draw() != png


PLACE = {"name": "a", "type": "t", "center": [0, 0], "extent": [1, 1], "capacity": 1}
UNPLACED = {"name": "a", "type": "t", "extent": [1, 1], "capacity": 1}
WIDE, DRAWN = UNPLACED | {"extent": [5, 5]}, {"draw_positions": True, "places": [UNPLACED], "fires": []}
FIRE = {"name": "f", "start": 1, "position": [0, 0], "intensity": 0.5, "radius": 3}
GOOD: dict[str, Any] = {
    "name": "w", "half_size": 5, "agents": 2, "steps": 1, "places": [PLACE], "fires": [FIRE], "layout": Uniform(),
    "personas": {"gender": {"f": 1.0}}, "communication_distance": 2, "history": {"memory": 1, "messages": 1},
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"agnets": 3}, "'agnets' not found. Did you mean 'agents'?"),
        ({"agents": 0}, "world.agents: expected `int` >= 1"),
        ({"history": {"memory": 1, "mesages": 2}}, "Setting of world.history 'mesages' not found. Did you mean 'm"),
        ({"history": {"memory": 1}}, "world.history lacks the setting 'messages'"),
        ({"places": 3}, "world.places: expected a list"),
        ({"places": [PLACE | {"capcity": 3}]}, "world.places[0] 'capcity' not found. Did you mean 'capacity'?"),
        ({"places": [PLACE | {"center": [5, 0]}]}, "Place 'a' covers X from 4 to 6"),
        ({"places": [PLACE, PLACE | {"name": "b", "center": [2, 2]}]}, "Places 'a' and 'b' overlap"),
        ({"places": [PLACE | {"extent": [5, 5]}]}, "no cell outside"),
        ({"fires": [FIRE | {"position": [9, 0]}]}, "Fire 'f' is at [9, 0]"),
        ({"fires": [FIRE | {"start": 0}]}, "world.fires[0].start"),
        ({"fires": [FIRE | {"radius": float("inf")}]}, "finite radius"),
        ({"fires": [FIRE, FIRE]}, "world.fires contains the name 'f' twice"),
        ({"personas": {"gender": {"f": -1.0}}}, "world.personas.gender"),
        ({"communication_distance": -1}, "world.communication_distance is -1"),
        ({"layout": Explicit(positions=[[0, 0]])}, "world.layout.positions lists 1 cells, but there are 2 agents"),
        ({"layout": Explicit(positions=[[0, 0], [6, 0]])}, "world.layout.positions[1] is [6, 0]"),
        ({"draw_positions": True}, "world.places[0].center is [0, 0], but with world.draw_positions=true the seed"),
        (DRAWN | {"view": 3}, "world.draw_positions=true works only without further parts"),
        (DRAWN | {"layout": Clustered(clusters=1, radius=2)}, "needs the layout 'uniform', but world.layout is 'clus"),
        (DRAWN | {"places": [UNPLACED | {"extent": [6, 1]}]}, "A place of extent [6, 1] is larger than the grid of"),
        (DRAWN | {"places": [WIDE, UNPLACED | {"name": "b"}]}, "world.draw_positions found no room for 2 places"),
    ],
)
def test_a_bad_setting_is_named_in_one_line(changes, says):
    with pytest.raises(InputError) as caught:
        GridScenario(**(GOOD | changes))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_good_settings_are_taken_and_a_missing_one_and_a_wrong_one_of_a_layout_are_named():
    assert GridScenario(**GOOD).count_calls() == 4
    with pytest.raises(InputError, match="world lacks the setting 'steps'"):
        GridScenario(**{key: value for key, value in GOOD.items() if key != "steps"})
    with pytest.raises(InputError, match="'radus' not found. Did you mean 'radius'"):
        Clustered(clusters=1, radus=2)
    with pytest.raises(InputError, match="'radius' not found"):
        Uniform(radius=3)
