"""Edits change what they say they change in what an agent perceives, and nothing else."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.errors import InputError
from foundry.worlds.base import Answer, Question
from foundry.worlds.grid.layouts import Explicit
from foundry.worlds.grid.world import GridScenario
from foundry.worlds.probe.editing import LEAVES, NONE, UNEDITED, edits_for, find_edit, find_edits, observing

GRID = {edit.name: edit for edit in edits_for("grid")}
CHANGES = {
    "no_fire": {"fires"},
    "no_messages": {"received"},
    "no_history": {"memory", "received"},
    "no_persona": {"persona", "neighbours"},
    "swap_persona": {"persona", "neighbours"},
    "shuffle_neighbours": {"neighbours"},
    "rename_places": {"places", "place", "neighbours"},
    "mirror": {"x", "fires", "places", "neighbours"},
    "rotate": {"x", "y", "fires", "places", "neighbours"},
    "rename_agents": {"agent", "neighbours", "received"},
}
EVERYWHERE = {"blank_image", "other_image", "permute_options", "no_messages", "no_persona", "swap_persona"}


def world(cells: list[list[int]]) -> GridScenario:
    return GridScenario(
        name="small", half_size=9, agents=len(cells), steps=3, layout=Explicit(positions=cells),
        places=[{"name": "hall", "type": "hall", "center": [-5, 0], "extent": [2, 2], "capacity": 3}],
        fires=[{"name": "great", "start": 1, "position": [3, 2], "intensity": 0.5, "radius": 9}],
        personas={"age": {"young": 1, "old": 1}}, communication_distance=9,
        history={"memory": 3, "messages": 3},
    )  # fmt: skip


def questions(cells: list[list[int]], seed: int) -> Iterator[Question]:
    played = world(cells).start(seed)
    while not played.finished:
        asked = played.pending()
        yield from asked
        said = '{"message": "at (1, 2)"}', '{"action": "move", "direction": "up", "memory": "left of it"}'
        played.advance([Answer(said[one.kind == "action"]) for one in asked])


cells = st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)).map(list), min_size=1, max_size=4)
drawn = st.builds(lambda where, seed: list(questions(where, seed)), cells, st.integers(0, 99))


def test_all_that_are_shipped_for_the_grid_are_known_and_say_what_they_leave():
    assert set(GRID) == set(CHANGES) | EVERYWHERE and {edit.leaves for edit in GRID.values()} <= set(LEAVES)
    assert find_edit(NONE, world([[0, 0]])) is UNEDITED
    assert {edit.name for edit in edits_for("mine")} == EVERYWHERE


@given(drawn)
def test_an_edit_changes_its_own_keys_alone_and_leaves_the_question_it_was_given(asked: list[Question]):
    for question in asked:
        before = copy.deepcopy(question)
        for name, edit in GRID.items():
            changed = edit.applied(question)
            assert question == before
            if changed is not None:
                assert changed.observation.keys() == question.observation.keys()
                other = {key for key, value in question.observation.items() if changed.observation[key] != value}
                assert other and other <= CHANGES[name], name
                assert observing(changed, **{key: question.observation[key] for key in other}) == question


@given(drawn)
def test_what_is_taken_away_is_gone_and_cannot_be_taken_again(asked: list[Question]):
    for question in asked:
        for name in ("no_fire", "no_messages", "no_history", "no_persona", "rename_places"):
            changed = GRID[name].applied(question)
            assert changed is None or GRID[name].applied(changed) is None


def test_what_was_heard_is_taken_away():
    heard = next(one for one in questions([[0, 0], [1, 0]], 0) if one.observation["received"])
    changed = GRID["no_messages"].applied(heard)
    assert changed is not None and changed.observation["received"] == []


@given(drawn)
def test_a_mirror_keeps_distances_and_its_mirror_is_what_was(asked: list[Question]):
    def gaps(question: Question) -> list[float]:
        seen = question.observation
        things: list[dict[str, Any]] = [*seen["fires"], *seen["neighbours"], *seen["places"]]
        return [abs(seen["x"] - one["x"]) for one in things]

    mirror = GRID["mirror"]
    for question in asked:
        changed = mirror.applied(question)
        assert changed is not None and gaps(changed) == gaps(question)
        assert all(place["x_min"] <= place["x"] <= place["x_max"] for place in changed.observation["places"])
        assert mirror.applied(changed) == question
    assert [mirror.expected(one) for one in ("left", "right", "up", "stay")] == ["right", "left", "up", "stay"]


@pytest.mark.parametrize(
    ("name", "window", "open_ways", "other", "zone"),
    [
        ("mirror", ["A..", ".@.", "#.f"], ["up", "right"], (1, 5), (-5, -3, 2, 6)),
        ("rotate", ["A.#", ".@.", "..f"], ["down", "left"], (-5, 3), (-6, -2, 3, 5)),
    ],
)
def test_what_is_seen_moves_with_where_it_is(
    name: str, window: list[str], open_ways: list[str], other: tuple[int, int], zone: tuple[int, int, int, int]
):
    seen = {
        "x": -2 if name == "mirror" else 2, "y": 4, "window": ["..A", ".@.", "f.#"], "open": ["up", "left"],
        "seen": [{"id": 1, "x": -1 if name == "mirror" else 3, "y": 5, "persona": {}}],
        "zones": [{"name": "pit", "x_min": 3, "x_max": 5, "y_min": 2, "y_max": 6, "risk": 1.0}],
    }  # fmt: skip
    changed = GRID[name].applied(Question(1, 0, "action", seen))
    assert changed is not None
    found = changed.observation
    assert (found["window"], found["open"]) == (window, open_ways)
    (agent,), (pit,) = found["seen"], found["zones"]
    assert (agent["x"], agent["y"]) == other
    assert (agent["x"] - found["x"], agent["y"] - found["y"]) == (-1, 1), "as the window shows it"
    assert (pit["x_min"], pit["x_max"], pit["y_min"], pit["y_max"]) == zone


@given(drawn)
def test_what_is_exchanged_or_shuffled_is_the_same_together(asked: list[Question]):
    for question in asked:
        swapped, shuffled = GRID["swap_persona"].applied(question), GRID["shuffle_neighbours"].applied(question)
        if swapped is not None:
            assert sorted(map(str, personas(swapped))) == sorted(map(str, personas(question)))
            assert swapped.observation["persona"] != question.observation["persona"]
        if shuffled is not None:
            near = shuffled.observation["neighbours"]
            assert sorted(near, key=lambda one: one["id"]) == question.observation["neighbours"]


def personas(question: Question) -> list[Any]:
    return [question.observation["persona"], *(one["persona"] for one in question.observation["neighbours"])]


def test_an_edit_that_is_not_there_is_named_with_the_closest():
    with pytest.raises(InputError, match="Did you mean 'mirror'"):
        find_edit("miror", world([[0, 0]]))
    with pytest.raises(InputError, match="Part of edit 'swap_persona' 'ages'.* Did you mean 'age'"):
        find_edit("swap_persona.ages", world([[0, 0]]))
    with pytest.raises(InputError, match="'mirror' has no parts"):
        find_edits("mirror.each", world([[0, 0]]))
    assert [edit.name for edit in find_edits("swap_persona.each", world([[0, 0]]))] == ["swap_persona.age"]
