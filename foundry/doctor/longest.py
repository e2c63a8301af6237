"""The longest prompt that a configuration can produce."""

from __future__ import annotations

from dataclasses import dataclass

from foundry.models.base import ChatMessage
from foundry.prompts import Prompt
from foundry.worlds.base import Answer, Question, Scenario

CHARACTERS_PER_TOKEN = 5
"""Of the filler below in common tokenizers; its count in the model's own is measured by asking the server."""


@dataclass(frozen=True)
class LongestPrompt:
    """A prompt, and where in an episode it was met.

    Attributes:
        messages: the prompt.
        question: what it puts.
    """

    messages: tuple[ChatMessage, ...]
    question: Question

    @property
    def characters(self) -> int:
        """Its length without images."""
        return _length(self.messages)


def longest_prompt(scenario: Scenario, prompt: Prompt, *, seed: int, reply_tokens: int) -> LongestPrompt:
    """Play an episode in which everyone says as much as a reply may hold, and return its longest prompt.

    Args:
        scenario: the world.
        prompt: the prompt variant.
        seed: the run's seed.
        reply_tokens: tokens of the longest reply.
    """
    world = scenario.start(seed)
    longest: LongestPrompt | None = None
    while not world.finished:
        questions = world.pending()
        for question in questions:
            found = LongestPrompt(prompt.render(question), question)
            if longest is None or found.characters > longest.characters:
                longest = found
        room = reply_tokens * CHARACTERS_PER_TOKEN
        world.advance([Answer(scenario.wordy_answer(question, room)) for question in questions])
    assert longest is not None, "a world asks at least one question"
    return longest


def _length(messages: tuple[ChatMessage, ...]) -> int:
    return sum(len(message.content) for message in messages)
