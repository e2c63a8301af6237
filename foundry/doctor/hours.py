"""How long a plan takes, and how much it has models read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from foundry.composing.planning import PlannedRun
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.doctor.longest import CHARACTERS_PER_TOKEN
from foundry.expansion import Sweep, settings_key
from foundry.prompts.prompt import Prompt
from foundry.texts import in_words
from foundry.worlds.base import Answer, Scenario

COMMON_MESSAGE = 160
"""Characters of the message that each agent is taken to send."""
SLOW, FAST = 1, 20
"""Calls a second of a laptop and of a server, for which the time is told where nothing was measured."""


def time_line(planned: Sequence[PlannedRun], per_call_s: Mapping[str, float]) -> str:
    """Return how long the calls of a plan take, one model after the other; "" where nothing would be sent.

    Args:
        planned: the runs.
        per_call_s: seconds a call by model, as far as the doctor measured them.
    """
    calls: Counter[str] = Counter()
    for run in planned:
        calls[run.model] += run.to_send
    calls = +calls
    if not calls:
        return ""
    if calls.keys() <= per_call_s.keys():
        seconds = sum(count * per_call_s[model] for model, count in calls.items())
        return f"time: about {in_words(seconds)} at the speed that foundry doctor measured"
    slow, fast = (in_words(calls.total() / speed) for speed in (SLOW, FAST))
    return f"time: {slow} at {SLOW} call a second, {fast} at {FAST}; foundry doctor measures yours"


def prompt_tokens(sweep: Sweep, planned: Sequence[PlannedRun]) -> int | None:
    """Return about how many tokens of prompts a plan would send; None where prompts hold images.

    An episode of each world and prompt is played in which every agent sends a message of a common length.
    """
    per_call: dict[str, float] = {}
    tokens = 0.0
    for run in planned:
        if not run.to_send:
            continue
        config = sweep.config(run.run)
        key = settings_key({name: config[name] for name in ("world", "prompt")})
        if key not in per_call:
            scenario = scenario_of(config)
            if scenario.shows_images:
                return None
            per_call[key] = _characters(scenario, prompt_of(config), run.run.seed) / CHARACTERS_PER_TOKEN
        tokens += run.to_send * per_call[key]
    return round(tokens)


def _characters(scenario: Scenario, prompt: Prompt, seed: int) -> float:
    """Return the mean length of the prompts of each step's first agent in an episode."""
    world, lengths = scenario.start(seed), []
    while not world.finished:
        questions = world.pending()
        lengths.append(sum(len(message.content) for message in prompt.render(questions[0])))
        world.advance([Answer(scenario.wordy_answer(question, COMMON_MESSAGE)) for question in questions])
    return sum(lengths) / len(lengths)
