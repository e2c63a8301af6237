"""A prompt that holds all that a prompt must hold, and prompts that break one rule each."""

from __future__ import annotations

import itertools
from typing import Any

from conformance.coins import Coins, question_with, with_world
from foundry.conformance.playing import WorldCase
from foundry.models.base import ChatMessage
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question

SOUND_TEMPLATES = {"call": "Agent {{ agent }}, it showed {{ shown }}.{% if mood is defined %} {{ mood }}{% endif %}"}
NUMBERS = itertools.count()
SHOWING = with_world("Showing", question=question_with(images=(b"\x89PNG",)))


class Numbered(Prompt):
    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        (message,) = super().render(question)
        return (ChatMessage("user", f"{message.content} {next(NUMBERS)}", message.images),)


class Blind(Prompt):
    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        return (ChatMessage("user", "Call."),)


def case(templates: dict[str, Any], kind: type[Prompt] = Prompt, world: type[Coins] = Coins) -> WorldCase:
    return WorldCase(world, lambda: kind("own", templates), templates)


SOUND = case(SOUND_TEMPLATES)
BROKEN = [
    (case({"shout": "?"}), "has every kind", "no template for call"),
    (case({"call": "{{ agnet }}"}), "fills every question", "Did you mean 'agent'?"),
    (case({"call": " "}), "fills every question", "without any text"),
    (case({"call": "{% if agent > 99 %}{{ coin }}{% endif %}"}), "names what is observed", "names coin"),
    (case(SOUND_TEMPLATES, Numbered), "is the same every time", "another way"),
    (case(SOUND_TEMPLATES, Blind, SHOWING), "shows the images", "0 are sent"),
]
