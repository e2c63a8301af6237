"""Who is asked ahead of the others is asked the same, and nobody waits for whoever is out of reach."""

import json
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from foundry import seeding
from foundry.conformance.playing import play, play_ahead
from foundry.errors import InputError
from foundry.worlds.base import Ahead, Answer, Question
from foundry.worlds.grid import dependence
from foundry.worlds.grid.dependence import GridAhead
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.grid_world import GridScenario, GridWorld
from foundry.worlds.grid.layouts import Uniform
from worlds.grid.shipped import load_world, make, make_at

STAY, SILENCE = Answer('{"action": "stay"}'), Answer('{"message": null}')


def answering(questions: Iterable[Question]) -> list[Answer]:
    """Return what agents say and do, drawn from the place of each question alone."""
    return [answer(*question.asked) for question in questions]


def answer(step: int, agent: int, kind: str) -> Answer:
    rng = seeding.stream(0, f"{step} {agent} {kind}")
    if rng.random() < 0.05:
        return Answer("I cannot say.")
    if kind == "message":
        return Answer(json.dumps({"message": None if rng.random() < 0.5 else f"{agent} at {step}"}))
    way = ("up", "down", "left", "right")[rng.integers(4)]
    action = {"action": "stay"} if rng.random() < 0.1 else {"action": "move", "direction": way}
    return Answer(json.dumps({**action, "memory": "" if rng.random() < 0.5 else f"step {step}"}))


@st.composite
def worlds(draw: Callable[..., Any]) -> GridScenario:
    half = draw(st.integers(3, 9))
    inside, drawn = st.integers(1 - half, half - 1), draw(st.booleans())
    places = [
        {"name": f"p{n}", "type": "cafe", "extent": [1, n % 2], "capacity": 2}
        | ({} if drawn else {"center": [draw(inside), draw(inside)]})
        for n in range(draw(st.integers(0, 2)))
    ]
    fires = [{"name": "f", "start": 2, "intensity": 0.5, "radius": 3} | ({} if drawn else {"position": [0, 0]})]
    changed: dict[str, Any] = load_world("cafe_library") | {
        "layout": Uniform(),
        "half_size": half,
        "agents": draw(st.integers(1, 6)),
        "steps": draw(st.integers(4, 12)),
        "places": places,
        "fires": fires[: draw(st.integers(0, 1))],
        "draw_positions": drawn,
        "tell_fires": draw(st.booleans()),
        "communication_distance": draw(st.sampled_from([0, 1, 1.5, 2, 2.9, 5])),
        "history": {"memory": draw(st.integers(0, 2)), "messages": draw(st.integers(0, 3))},
    }
    try:
        return GridScenario(**{key: value for key, value in changed.items() if key != "_target_"})
    except InputError:
        reject()


@settings(max_examples=20)
@given(worlds(), st.integers(0, 5), st.sampled_from(["first", "last", "random"]))
def test_questions_and_records_are_those_of_lock_step_whatever_the_order_of_the_answers(
    scenario: GridScenario, seed: int, order: str
):
    rng = seeding.stream(seed, "order")
    pick = {"first": lambda n: 0, "last": lambda n: n - 1, "random": lambda n: int(rng.integers(n))}[order]
    expected = play(scenario.start(seed), answering, most=1000)
    ahead = play_ahead(scenario.start(seed), answering, most=1000, pick=pick)
    assert ahead.content() == expected.content()


def test_an_episode_can_go_ahead_from_any_step():
    worlds = [make(agents=6, half_size=8, places=[], fires=[], steps=8).start(1) for _ in range(2)]
    for world in worlds:
        for _ in range(6):
            assert (world.ahead() is None) == (world.pending()[0].kind == "action")
            world.advance(answering(world.pending()))
    ahead = play_ahead(worlds[0], answering, most=1000, pick=lambda n: n - 1)
    assert ahead.content() == play(worlds[1], answering, most=1000).content()


def asked_without(ahead: Ahead, silent: int) -> Iterator[Question]:
    """Yield all that is asked while one agent never answers and the others stay where they are."""
    while opened := ahead.ready():
        for question in opened:
            yield question
            if question.agent != silent:
                ahead.take(question.asked, SILENCE if question.kind == "message" else STAY)


@pytest.mark.parametrize(
    ("apart", "reach", "last"), [((20, 0), 5, 15), ((12, 12), 5, 17), ((3, 0), 5, 1), ((0, 6), 0.5, 6)]
)
def test_an_agent_is_asked_until_the_one_behind_could_be_within_reach(apart: tuple[int, int], reach: float, last: int):
    ahead = make_at((0, 0), apart, places=[], communication_distance=reach).start(0).ahead()
    assert ahead is not None
    steps = [question.step for question in asked_without(ahead, silent=1) if question.agent == 0]
    assert max(steps) == last


@pytest.mark.parametrize("far", [(13, 0), (-13, 0), (0, 13), (0, -13)])
def test_who_is_inside_a_place_waits_for_whoever_could_enter_it(far: tuple[int, int]):
    cafe = [{"name": "cafe", "type": "cafe", "center": [0, 0], "extent": [3, 3], "capacity": 5}]
    ahead = make_at((0, 0), far, places=cafe, communication_distance=1, steps=50).start(0).ahead()
    assert ahead is not None
    steps = [question.step for question in asked_without(ahead, silent=1) if question.agent == 0]
    assert max(steps) == 10, "nine steps lead to the cell before the place, the tenth into it"


@pytest.mark.parametrize(("waiting", "steps"), [(dependence.MOST_WAITING, dependence.MOST_STEPS), (40, 10), (1, 1)])
def test_nobody_is_further_ahead_than_the_answers_may_wait_in_memory(
    waiting: int, steps: int, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(dependence, "MOST_WAITING", waiting)
    ahead = make_at((-90, 0), (90, 0), half_size=100, places=[], steps=200).start(0).ahead()
    assert ahead is not None
    assert max(question.step for question in asked_without(ahead, silent=1)) == 1 + steps


def test_a_world_with_more_to_it_than_the_rule_was_made_for_stays_in_lock_step(monkeypatch: pytest.MonkeyPatch):
    class Other(GridWorld):
        """May do anything."""

    monkeypatch.setitem(dependence._KNOWN, GridSettings, dependence._KNOWN[GridSettings].replace(" fires", ""))
    known, personas = make(fires=[]).settings, make().personas(0)
    cells = [(0, 0)] * len(personas)
    assert isinstance(GridWorld(known, cells, personas).ahead(), GridAhead)
    assert GridWorld(make().settings, cells, personas).ahead() is None
    assert Other(known, cells, personas).ahead() is None
