"""Scripted policies of the 2D world follow edits as they should: what they may do moves with what they perceive."""

from collections.abc import Iterator
from functools import cache

import pytest

from foundry.models.base import Request, ScriptedModel
from foundry.worlds.base import Answer, Question
from foundry.worlds.grid.grid_policies import Avoid, Herd, Seek
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Explicit
from foundry.worlds.probe.editing import find_edit
from policies import Left

DRAWS = 30
CELLS = [[0, 0], [2, 1], [-3, 2], [1, -4], [5, 5], [-6, -2]]
POLICIES = {"avoid": Avoid("avoid"), "herd": Herd("herd"), "seek": Seek("seek"), "left": Left("left")}


@cache
def world() -> GridScenario:
    return GridScenario(
        name="small", half_size=9, agents=len(CELLS), steps=4, layout=Explicit(positions=CELLS),
        places=[{"name": "hall", "type": "hall", "center": [-5, 1], "extent": [2, 1], "capacity": 3}],
        fires=[{"name": "great", "start": 3, "position": [3, 2], "intensity": 0.5, "radius": 9}],
        personas={"age": {"young": 1, "old": 1}}, communication_distance=9, history={"memory": 0, "messages": 0},
    )  # fmt: skip


@cache
def asked() -> list[Question]:
    """Return a third of what is asked for actions in an episode in which some step to the right."""
    running, questions = world().start(1), list[Question]()
    while not running.finished:
        pending = running.pending()
        questions += [question for question in pending if question.kind == "action"]
        step = '{"action": "move", "direction": "right"}'
        running.advance(
            [Answer(step if question.agent % 2 and question.kind == "action" else "") for question in pending]
        )
    return questions[::3]


def may_do(model: ScriptedModel, question: Question) -> set[str | int | float | None]:
    """Return what a policy may decide in a moment."""

    def replies() -> Iterator[str]:
        for seed in range(DRAWS):
            request = Request((), seed, question.kind, question.told, question.step, question.agent)
            yield model.reply(request).text

    return {world().read(question, Answer(text)).action for text in replies()}


@pytest.mark.parametrize("name", ["mirror", "rotate", "rename_agents", "rename_places", "shuffle_neighbours"])
@pytest.mark.parametrize("policy", ["avoid", "herd", "seek"])
def test_who_goes_by_places_alone_moves_with_them(policy: str, name: str):
    edit, changed = find_edit(name, world()), 0
    for question in asked():
        edited = edit.applied(question)
        changed += edited is not None
        if edited is not None:
            moved = {edit.expected(action) for action in may_do(POLICIES[policy], question)}
            assert may_do(POLICIES[policy], edited) == moved, question.observation
    assert changed > 4


@pytest.mark.parametrize("name", ["mirror", "rotate"])
def test_who_always_goes_left_is_never_right(name: str):
    edit = find_edit(name, world())
    for question in asked():
        edited = edit.applied(question)
        assert edited is not None
        assert not may_do(POLICIES["left"], edited) & {edit.expected(one) for one in may_do(POLICIES["left"], question)}


def test_the_fire_moves_who_avoids_it_and_nobody_else():
    edit = find_edit("no_fire", world())
    known = [question for question in asked() if question.observation["fires"]]
    assert [question for question in asked() if edit.applied(question) is not None] == known and known
    for question in known:
        edited = edit.applied(question)
        assert edited is not None
        for policy in ("herd", "seek"):
            assert may_do(POLICIES[policy], edited) == may_do(POLICIES[policy], question)
        assert may_do(POLICIES["avoid"], edited) != may_do(POLICIES["avoid"], question)
