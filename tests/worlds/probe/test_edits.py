"""Edits change what they say they change in what an agent perceives, and nothing else."""

import copy
import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image

from foundry.errors import InputError
from foundry.worlds.base import Answer, Question
from foundry.worlds.grid.grid_edits import HIGHER
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Explicit
from foundry.worlds.grid.space import OFFSETS
from foundry.worlds.probe.editing import LEAVES, NONE, UNEDITED, edits_of, find_edit, find_edits, observing

GRID = {edit.name: edit for edit in edits_of("grid")}
PLACED = {"fires", "places", "neighbours", "seen", "exits", "zones", "food", "burning", "window", "open"}
CHANGES = {
    "no_fire": {"fires", "burning", "window"},
    "no_messages": {"received"},
    "no_history": {"memory", "received"},
    "no_persona": {"persona", "neighbours", "seen"},
    "swap_persona": {"persona", "neighbours", "seen"},
    "shuffle_neighbours": {"neighbours"},
    "rename_places": {"places", "place", "neighbours"},
    "mirror": {"x", *PLACED},
    "rotate": {"x", "y", *PLACED},
    "rename_agents": {"agent", "neighbours", "received", "seen", "touchable"},
}
TAKING = {"no_fire", "no_messages", "no_history", "no_persona", "rename_places"}
EVERYWHERE = {"blank_image", "other_image", "permute_options", "no_messages", "no_persona", "swap_persona"}


FURNITURE: dict[str, Any] = {
    "view": 5, "exits": [{"name": "door", "cells": [[-9, 0], [-9, 1]]}], "energy": {"start": 9}, "sharing": True,
    "zones": [{"name": "pit", "corners": [[-9, 5], [-9, 9]], "risk": 0}], "food": {"share": 0.1, "amount": 2},
}  # fmt: skip


def world(cells: list[list[int]], **parts: Any) -> GridScenario:
    return GridScenario(
        name="small", half_size=9, agents=len(cells), steps=3, layout=Explicit(positions=cells),
        places=[{"name": "hall", "type": "hall", "center": [-5, 0], "extent": [2, 2], "capacity": 3}],
        fires=[{"name": "great", "start": 1, "position": [3, 2], "intensity": 0.5, "radius": 9}],
        personas={"age": {"young": 1, "old": 1}, "trade": {"baker": 1, "smith": 1}}, communication_distance=9,
        history={"memory": 3, "messages": 3}, **parts,
    )  # fmt: skip


def questions(cells: list[list[int]], seed: int, parts: dict[str, Any]) -> Iterator[Question]:
    played = world(cells, **parts).start(seed)
    while not played.finished:
        asked = played.pending()
        yield from asked
        said = '{"message": "at (1, 2)"}', '{"action": "move", "direction": "up", "memory": "left of it"}'
        played.advance([Answer(said[question.kind == "action"]) for question in asked])


cells = st.lists(st.tuples(st.integers(-8, 9), st.integers(-9, 9)).map(list), min_size=1, max_size=4)
episodes = st.tuples(cells, st.integers(0, 99), st.sampled_from([{}, FURNITURE]))
CROWD = [[3, 2], [4, 2], [4, 3], [2, 1], [3, 2]], 7, FURNITURE
"""Five who see each other, a fire, food; some have a neighbour of their age before one of another."""


def test_all_that_are_shipped_for_the_grid_are_known_and_say_what_they_leave():
    assert set(GRID) == set(CHANGES) | EVERYWHERE and {edit.leaves for edit in GRID.values()} <= set(LEAVES)
    assert find_edit(NONE, world([[0, 0]])) is UNEDITED
    assert {edit.name for edit in edits_of("mine")} == EVERYWHERE


@example(CROWD)
@given(episodes)
def test_an_edit_changes_its_own_keys_alone_and_what_it_takes_away_cannot_be_taken_again(episode: tuple[Any, ...]):
    for question in questions(*episode):
        before = copy.deepcopy(question)
        for name, edit in GRID.items():
            changed = edit.applied(question)
            assert question == before
            if changed is not None:
                assert changed.observation.keys() == question.observation.keys()
                other = {key for key, value in question.observation.items() if changed.observation[key] != value}
                assert other and other <= CHANGES[name], name
                assert observing(changed, **{key: question.observation[key] for key in other}) == question
                assert name not in TAKING or edit.applied(changed) is None


seeing = st.builds(
    lambda kind, images: Question(1, 0, kind, {}, tuple(images)),
    st.sampled_from(["move", "look"]),
    st.lists(st.sampled_from([b"1", b"2"]), max_size=2),
)


@example(
    Question(1, 0, "move", {}, (b"1",)), [Question(1, 1, "look", {}, (b"2",)), Question(1, 2, "move", {}, (b"1",))]
)
@given(seeing, st.lists(seeing, max_size=5))
def test_images_are_exchanged_for_as_many_others_that_were_seen_in_a_moment_of_the_kind(
    question: Question, others: list[Question]
):
    seen = {
        other.images for other in others if other.kind == question.kind and len(other.images) == len(question.images)
    }
    changed = GRID["other_image"].applied(question, others)
    assert (question if changed is None else changed).images in (seen - {question.images} or {question.images})


def gaps(question: Question) -> list[float]:
    """Return how far everything is that is told, squared; corners of rectangles, too."""
    seen = question.observation
    boxes = [*seen["places"], *seen.get("zones", ())]
    assert all(box["x_min"] <= box["x_max"] and box["y_min"] <= box["y_max"] for box in boxes)
    things = [one for key in ("fires", "places", "neighbours", "seen", "exits", "food") for one in seen.get(key, ())]
    points = [(thing["x"], thing["y"]) for thing in things] + [tuple(cell) for cell in seen.get("burning", ())]
    points += [(box[x], box[y]) for box in boxes for x in ("x_min", "x_max") for y in ("y_min", "y_max")]
    return sorted((x - seen["x"]) ** 2 + (y - seen["y"]) ** 2 for x, y in points)


def is_drawn_as_told(question: Question) -> bool:
    """Tell whether the window shows agents and food where they are said to be, and walls where no way is open."""
    seen = question.observation
    if "window" not in seen:
        return True

    def mark(dx: int, dy: int) -> str:
        return str(seen["window"][seen["view"] - dy][seen["view"] + dx])

    marks = [(mark(one["x"] - seen["x"], one["y"] - seen["y"]), "A@") for one in seen["seen"]]
    marks += [(mark(one["x"] - seen["x"], one["y"] - seen["y"]), "fA@*") for one in seen["food"]]
    ways = {way for way, cell in OFFSETS.items() if mark(*cell) != "#"}
    return ways == {*seen["open"]} and all(found in known for found, known in marks)


@pytest.mark.parametrize(("name", "times"), [("mirror", 2), ("rotate", 4)])
@example(episode=CROWD)
@given(episode=episodes)
def test_what_is_turned_is_as_far_as_it_was_and_drawn_where_it_is_told_and_comes_back(
    name: str, times: int, episode: tuple[Any, ...]
):
    edit = GRID[name]
    for question in questions(*episode):
        now = question
        for _ in range(times):
            changed = edit.applied(now)
            assert changed is not None and gaps(changed) == gaps(now) and is_drawn_as_told(changed)
            opened = [edit.expected(way) for way in now.observation.get("open", ())]
            assert changed.observation.get("open", []) == sorted(opened, key=[*OFFSETS].index)
            now = changed
        assert now == question
    assert edit.expected("stay") == "stay"


def people(question: Question) -> dict[int, dict[str, str]]:
    """Return the persona of each agent that is told of, which is the same wherever it is told."""
    seen = question.observation
    found = {seen["agent"]: seen["persona"]}
    for one in (*seen["neighbours"], *seen.get("seen", ())):
        assert found.setdefault(one["id"], one["persona"]) == one["persona"]
    return found


@example(CROWD)
@given(episodes)
def test_agents_are_the_same_persons_wherever_they_are_told_of(episode: tuple[Any, ...]):
    swap_age = find_edit("swap_persona.age", world([[0, 0]]))
    for question in questions(*episode):
        own, before = question.observation["agent"], people(question)
        names = ("swap_persona", "rename_agents", "shuffle_neighbours", "no_persona")
        whole, renamed, shuffled, nobody, age = (
            edit.applied(question) or question for edit in (*(GRID[name] for name in names), swap_age)
        )
        assert people(renamed) == {agent + HIGHER: persona for agent, persona in before.items()}
        touchable = question.observation.get("touchable", [])
        assert renamed.observation.get("touchable", []) == [agent + HIGHER for agent in touchable]
        assert people(shuffled) == before and not any(people(nobody).values())
        near = [one["id"] for one in question.observation["neighbours"]]
        for swapped, names in ((whole, ("age", "trade")), (age, ("age",))):
            other = next((one for one in near if any(before[one][name] != before[own][name] for name in names)), own)
            gained, lost = ({name: before[one][name] for name in names} for one in (other, own))
            assert people(swapped) == before | {own: before[own] | gained} | {other: before[other] | lost}


def test_an_edit_that_is_not_there_is_named_with_the_closest():
    with pytest.raises(InputError, match="Did you mean 'mirror'"):
        find_edit("miror", world([[0, 0]]))
    with pytest.raises(InputError, match="Part of edit 'swap_persona' 'ages'.* Did you mean 'age'"):
        find_edit("swap_persona.ages", world([[0, 0]]))
    with pytest.raises(InputError, match="'mirror' has no parts"):
        find_edits("mirror.each", world([[0, 0]]))
    texts = [edit.name for edit in find_edits("swap_persona.each", world([[0, 0]]))]
    assert texts == ["swap_persona.age", "swap_persona.trade"]


CAMERA = {edit.name: edit for edit in edits_of("camera")}
POSE = {"x": 1.0, "y": 2.0, "z": 0.5, "yaw": 90.0, "pitch": -10.0}
SEEN: dict[str, Any] = {
    **POSE, "step": 1, "task": "Find the lamp.", "target": "lamp", "idle_streak": 2,
    "instruction": {"en": "Pass the door to the lamp.", "ja": "lampへ"},
    "history": ({"step": 0, "reply": "I go to the lamp.", "outcome": "moved", "pose": POSE},),
    "choices": [{"letter": "A", "text": "sofa → lamp"}, {"letter": "B", "text": "lamp → sofa"}],
}  # fmt: skip
UNLABELLED: dict[str, Any] = {
    "target": "thing 1", "task": "Find the thing 1.",
    "instruction": {"en": "Pass the door to the thing 1.", "ja": "thing 1へ"},
    "choices": [{"letter": "A", "text": "thing 2 → thing 1"}, {"letter": "B", "text": "thing 1 → thing 2"}],
}  # fmt: skip
PIXELS = np.stack(np.broadcast_arrays(np.arange(72) * 3, np.arange(48)[:, None] * 5, 99), axis=-1).astype(np.uint8)


def encoded(image_format: str) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(PIXELS).save(buffer, image_format)
    return buffer.getvalue()


def decoded(image: bytes, image_format: str) -> Any:
    with Image.open(io.BytesIO(image), formats=[image_format]) as found:
        return np.asarray(found, dtype=float)


def edited_in_3d(name: str, *images: bytes) -> Question:
    changed = CAMERA[name].applied(Question(2, 0, "move", SEEN, images))
    assert changed is not None
    return changed


@pytest.mark.parametrize(
    ("edit", "changes"),
    [
        ("no_history", {"history": (), "idle_streak": 0}),
        ("no_pose", {**dict.fromkeys(POSE), "history": ({**SEEN["history"][0], "pose": None},)}),
        ("no_labels", UNLABELLED),
    ],
)
def test_what_is_taken_away_is_gone_wherever_it_was_told_and_nothing_else_is(edit: str, changes: dict[str, Any]):
    assert edited_in_3d(edit).observation == {**SEEN, **changes}


@pytest.mark.parametrize(("image_format", "off"), [("PNG", 0), ("JPEG", 1)])
@pytest.mark.parametrize(
    ("edit", "change"), [("mirror_image", lambda seen: seen[:, ::-1]), ("blank_image", lambda seen: 0 * seen + 128)]
)
def test_every_image_is_changed_and_stays_as_large_and_of_its_format(
    edit: str, change: Callable[[Any], Any], image_format: str, off: float
):
    """A JPEG that is encoded again is nearly what it was."""
    seen = encoded(image_format), encoded("PNG")
    changed = edited_in_3d(edit, *seen)
    for before, after, known, most in zip(seen, changed.images, (image_format, "PNG"), (off, 0), strict=True):
        assert np.abs(decoded(after, known) - change(decoded(before, known))).mean() <= most
    assert CAMERA[edit].applied(replace(changed, images=())) is None


def test_left_and_right_are_exchanged_in_every_action_that_names_a_side():
    sides = {"left": "right", "turn left": "turn right"}
    both = sides | {other: side for side, other in sides.items()} | {"forward": "forward", "stay": "stay"}
    assert {action: CAMERA["mirror_image"].expected(action) for action in both} == both
