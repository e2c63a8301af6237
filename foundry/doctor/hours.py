"""Estimates the time, the prompt tokens and the price of a plan, from measured speed and the length of prompts."""

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import msgspec

from foundry.composing.planning import PlannedRun
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.expansion import Sweep, settings_key
from foundry.models.answers.answers import is_database
from foundry.models.base import Model
from foundry.models.serving import HttpServing, Price, serving_of
from foundry.prompts.prompt import Prompt
from foundry.running.build import build
from foundry.storing.run_files import write_atomically
from foundry.texts import in_words
from foundry.worlds.base import Answer, Question, Scenario

CHARACTERS_PER_TOKEN = 3.73
"""Characters per token of the filler text with the tokenizers of Qwen 3 and Llama 3; real replies have no more."""
COMMON_MESSAGE = 160
"""Number of characters that is assumed for each message of an agent."""
PRICED = 1_000_000
"""Prices are given for this number of tokens."""
SLOW, FAST = 1, 20
"""Calls per second that are assumed for a laptop and for a server if no speed was measured."""


def remember_speed(cache: str, model: str, per_call_s: float) -> None:
    """Store the seconds per call of a model beside the cache, unless the cache is a database."""
    if is_database(cache):
        return
    file = _file(cache)
    file.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(file, msgspec.json.encode({**speeds(cache), model: per_call_s}))


def speeds(cache: str) -> dict[str, float]:
    """Return the measured seconds per call, by model; an unreadable file counts as no measurement."""
    if is_database(cache):
        return {}
    try:
        return msgspec.json.decode(_file(cache).read_bytes(), type=dict[str, float])
    except (OSError, msgspec.MsgspecError):
        return {}


def _file(cache: str) -> Path:
    return Path(cache).with_suffix(".speeds.json")


@dataclass(frozen=True)
class SizedPrompt:
    """A question, and the length of its prompt.

    Attributes:
        characters: length of the prompt without images.
    """

    question: Question
    characters: int


def longest_prompt(scenario: Scenario, prompt: Prompt, *, seed: int, reply_tokens: int) -> SizedPrompt:
    """Play an episode with the longest possible replies, and return the longest prompt in it."""
    room = int(reply_tokens * CHARACTERS_PER_TOKEN)
    questions = (question for step in _wordy_steps(scenario, seed, room) for question in step)
    sized = (SizedPrompt(question, _characters(prompt, question)) for question in questions)
    return max(sized, key=lambda prompt: prompt.characters)


def spread_questions(scenario: Scenario, seed: int, count: int) -> list[Question]:
    """Return questions, at most `count`, from all parts of an episode with messages of common length."""
    questions = [question for step in _wordy_steps(scenario, seed, COMMON_MESSAGE) for question in step]
    return questions[:: max(1, len(questions) // count)][:count]


def time_line(planned: Sequence[PlannedRun], per_call_s: Mapping[str, float]) -> str:
    """Return, as text, how long the calls of a plan take if the models run one after another; "" without calls."""
    calls: Counter[str] = Counter()
    for run in planned:
        calls[run.model] += run.to_send
    calls = +calls
    if not calls:
        return ""
    if calls.keys() <= per_call_s.keys():
        seconds = sum(count * per_call_s[model] for model, count in calls.items())
        return f"time: about {in_words(seconds)} at the speed measured before"
    slow, fast = (in_words(calls.total() / speed) for speed in (SLOW, FAST))
    return (
        f"time: {slow} at {SLOW} call a second, {fast} at {FAST}; foundry plan --time measures the speed of your server"
    )


def prompt_tokens(sweep: Sweep, planned: Sequence[PlannedRun]) -> Counter[str] | None:
    """Estimate the prompt tokens of a plan, by model; return None if prompts contain images.

    For each world and prompt, this plays an episode in which every agent sends messages of common length, and measures
    the prompt of the first agent in each step.
    """
    per_call: dict[str, float] = {}
    tokens: dict[str, float] = defaultdict(float)
    for run in planned:
        if not run.to_send:
            continue
        config = sweep.config(run.run)
        key = settings_key({name: config[name] for name in ("world", "prompt")})
        if key not in per_call:
            scenario = scenario_of(config)
            if scenario.shows_images:
                return None
            steps = _wordy_steps(scenario, run.run.seed, COMMON_MESSAGE)
            prompt = prompt_of(config)
            mean = fmean(_characters(prompt, questions[0]) for questions in steps)
            per_call[key] = mean / CHARACTERS_PER_TOKEN
        tokens[run.model] += run.to_send * per_call[key]
    return Counter({model: round(count) for model, count in tokens.items()})


@dataclass(frozen=True)
class Cost:
    """The price of a plan: an estimate for the prompts, and an upper bound for the replies; None if unknown."""

    prompts: float | None
    replies: float | None

    def line(self) -> str:
        """Return the price as text."""
        prompts = (
            "unknown for prompts, since they contain images"
            if self.prompts is None
            else f"about {self.prompts:,.2f} for prompts"
        )
        replies = (
            "unknown for replies, since they have no limit"
            if self.replies is None
            else f"at most {self.replies:,.2f} for replies"
        )
        return f"cost: {prompts}, {replies}"


def cost_of(sweep: Sweep, planned: Sequence[PlannedRun], tokens: Mapping[str, int] | None) -> Cost | None:
    """Return the price of a plan's calls; None if no model has a price."""
    calls: Counter[str] = Counter()
    for run in planned:
        calls[run.model] += run.to_send
    models = {
        str(condition.config["model"]["name"]): build(condition.config["model"]) for condition in sweep.conditions
    }
    priced = {name: (model, price) for name, model in models.items() if (price := price_of(model)) is not None}
    if not priced:
        return None
    prompts = replies = 0.0
    for name, (model, price) in priced.items():
        prompts += price.prompt * (tokens or {}).get(name, 0) / PRICED
        replies += math.inf if model.longest_reply is None else price.reply * calls[name] * model.longest_reply / PRICED
    return Cost(None if tokens is None else prompts, replies if math.isfinite(replies) else None)


def price_of(model: Model) -> Price | None:
    """Return the price of the tokens of a model; None if it has no price."""
    serving = serving_of(model)
    return serving.price if isinstance(serving, HttpServing) else None


def _characters(prompt: Prompt, question: Question) -> int:
    return sum(len(message.content) for message in prompt.render(question))


def _wordy_steps(scenario: Scenario, seed: int, room: int) -> Iterator[Sequence[Question]]:
    """Play an episode in which all texts of agents have `room` characters, and yield the questions of each step."""
    world = scenario.start(seed)
    while not world.finished:
        questions = world.pending()
        yield questions
        world.advance([Answer(scenario.wordy_answer(question, room)) for question in questions])
