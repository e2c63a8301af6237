"""Every check of prompts sees what it is there for."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from conformance.coins import Coins, question_with, with_world
from foundry.conformance.finding import Status, look, name_of
from foundry.conformance.playing import WorldCase
from foundry.conformance.prompts import CHECKS, PromptCase
from foundry.models.base import ChatMessage
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question

BY_NAME = {name_of(check): check for check in CHECKS}
SOUND = {"call": "Agent {{ agent }}, it showed {{ shown }}.{% if mood is defined %} {{ mood }}{% endif %}"}
NUMBERS = itertools.count()
SHOWING = WorldCase(with_world("Showing", question=question_with(images=(b"\x89PNG",))))


class Numbered(Prompt):
    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        (message,) = super().render(question)
        return (ChatMessage("user", f"{message.content} {next(NUMBERS)}", message.images),)


class Blind(Prompt):
    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        return (ChatMessage("user", "Call."),)


def case(templates: dict[str, Any], kind: type[Prompt] = Prompt, world: WorldCase | None = None) -> PromptCase:
    return PromptCase(lambda: kind("own", templates), templates, world or WorldCase(Coins))


BROKEN = [
    (case({"shout": "?"}), "has every kind", "no template for call"),
    (case({"call": "{{ agnet }}"}), "fills every question", "Did you mean 'agent'?"),
    (case({"call": " "}), "fills every question", "without any text"),
    (case({"call": "{% if agent > 99 %}{{ coin }}{% endif %}"}), "names what is observed", "names coin"),
    (case(SOUND, Numbered), "is the same every time", "another way"),
    (case(SOUND, Blind, SHOWING), "shows the images", "0 are sent"),
]


@pytest.mark.parametrize("check", CHECKS, ids=name_of)
def test_a_sound_prompt_passes(check):
    found = look("prompt own", check, case(SOUND))
    assert (found.status, found.note) == (Status.PASSED, "")


@pytest.mark.parametrize(
    ("broken", "name", "words"), BROKEN, ids=[f"{name} {n}" for n, (_, name, _) in enumerate(BROKEN)]
)
def test_a_prompt_that_breaks_a_rule_fails_the_check_of_that_rule(broken: PromptCase, name: str, words: str):
    found = look("prompt own", BY_NAME[name], broken)
    assert found.status is Status.FAILED and words in found.note, found


def test_every_check_is_seen_to_fail():
    assert {name for _, name, _ in BROKEN} == set(BY_NAME)
