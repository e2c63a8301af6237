"""The longest prompt that a configuration can produce."""

from __future__ import annotations

from dataclasses import dataclass

from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Answer, Question, Scenario

CHARACTERS_PER_TOKEN = 3.73
"""Of the filler text in the tokenizers of Qwen 3 and Llama 3: no reply holds more characters of it."""


@dataclass(frozen=True)
class LongestPrompt:
    """The question with the longest prompt.

    Attributes:
        question: as it was met in an episode.
        characters: length of its prompt without images.
    """

    question: Question
    characters: int


def longest_prompt(scenario: Scenario, prompt: Prompt, *, seed: int, reply_tokens: int) -> LongestPrompt:
    """Play an episode in which everyone says as much as a reply may hold, and return where its prompt is longest.

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
            characters = sum(len(message.content) for message in prompt.render(question))
            if longest is None or characters > longest.characters:
                longest = LongestPrompt(question, characters)
        room = int(reply_tokens * CHARACTERS_PER_TOKEN)
        world.advance([Answer(scenario.wordy_answer(question, room)) for question in questions])
    assert longest is not None, "a world asks at least one question"
    return longest
