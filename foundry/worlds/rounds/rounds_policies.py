"""Policies for games: the bar, public goods, the fishery, the naming game, and environments with a table of rules."""

import json
import math
from collections import Counter
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from foundry import seeding
from foundry.errors import InputError
from foundry.models.base import Model, RunContext, ScriptedModel
from foundry.worlds.base import Question
from foundry.worlds.rounds.bar import GO, STAY
from foundry.worlds.rounds.fishery import sustainable
from foundry.worlds.rounds.public_goods import NOBODY
from foundry.worlds.rounds.reading import SILENCE, deciding
from foundry.worlds.validation import check_number

Attendance: TypeAlias = NDArray[np.float64]
"""Numbers of guests: of each evening, oldest first, (evenings,); or in a window before each evening, (evenings,
window).
"""

LONGEST = 8
"""Maximum number of evenings that a predictor uses."""


def _go_if(goes: bool) -> str:
    return deciding(GO if goes else STAY)


class Tossing(ScriptedModel):
    """A policy that goes to the bar with the same probability every evening."""

    def __init__(self, name: str, probability: float) -> None:
        super().__init__(name, probability=probability)
        check_number("model.probability", probability, 0, 1)
        self._probability = probability

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Decide at random whether to go to the bar."""
        return _go_if(rng.random() < self._probability)


class Mixing(ScriptedModel):
    """Goes with the probability of the symmetric equilibrium, where going and staying have equal expected utility."""

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Decide at random whether to go to the bar."""
        bar = (observation[key] for key in ("agents", "places", "fun", "crowded", "home"))
        return _go_if(rng.random() < equilibrium(*bar))


@lru_cache(maxsize=64)
def equilibrium(agents: int, places: int, fun: float, crowded: float, home: float) -> float:
    """Return the probability of going in the symmetric equilibrium.

    For an agent that goes, the bar is fun if at most `places` - 1 of the others go. The number of others that go has a
    binomial distribution. The more likely the others go, the lower is the expected utility of going, so there is only
    one such probability. The probability is 1 if going is always better than staying, and 0 if going is never better.

    Args:
        agents: number of agents.
        places: maximum number of agents that can go without making the bar crowded.
        fun: utility of going to an uncrowded bar.
        crowded: utility of going to a crowded bar.
        home: utility of staying.
    """
    from scipy.optimize import brentq  # takes half of this module's import time
    from scipy.special import bdtr

    def gain(probability: float) -> float:
        is_fun = float(bdtr(places - 1, agents - 1, probability)) if 0 < places < agents else float(places > 0)
        return fun * is_fun + crowded * (1 - is_fun) - home

    if gain(1.0) >= 0:
        return 1.0
    return float(brentq(gain, 0.0, 1.0, xtol=1e-12)) if gain(0.0) > 0 else 0.0


class Inductive(ScriptedModel):
    """Goes if its best predictor forecasts that the bar is not crowded.

    Each agent draws its predictors for the whole run. The best predictor has the smallest past error; the last evenings
    count most. Before the first attendance is known, the agent goes with the capacity as probability.

    Source: Arthur 1994, who gives examples of these kinds of predictors.
    """

    def __init__(self, name: str, predictors: int = 6, forgetting: float = 0.3, seed: int | None = None) -> None:
        super().__init__(name, predictors=predictors, forgetting=forgetting)
        check_number("model.predictors", predictors, 1, len(PREDICTORS), whole=True)
        self._predictors, self._forgetting, self._seed = predictors, forgetting, seed or 0

    def in_run(self, context: RunContext) -> Model:
        """Return the model for a run; the run's seed draws the predictors of each agent."""
        return Inductive(self.name, self._predictors, self._forgetting, context.seed)

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Go if the predictor with the smallest past error forecasts that the bar is not crowded."""
        went = tuple(evening["went"] for evening in observation["evenings"] if evening["went"] is not None)
        agents, places = observation["agents"], observation["places"]
        if not went:
            return _go_if(rng.random() < places / agents)
        forecasts, errors = _judged(went, agents, self._forgetting)
        own = _own(self._seed, observation["agent"], self._predictors)
        best = own[np.argmin(errors[own])]
        return _go_if(bool(forecasts[best] <= places))


def _lagged(back: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: past[:, -back]


def _mirrored(back: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: agents - past[:, -back]


def _averaged(evenings: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: past[:, -evenings:].mean(axis=1)


def _led_on(evenings: int) -> Callable[[Attendance, int], Attendance]:
    """Return a predictor that extends a straight line, fitted to the last evenings, by one evening."""
    times = np.arange(evenings) - (evenings - 1) / 2
    weights = 1 / evenings + times * ((evenings + 1) / 2) / (times**2).sum()
    return lambda past, agents: np.clip(past[:, -evenings:] @ weights, 0, agents)


PREDICTORS = (
    *map(_lagged, range(1, LONGEST + 1)),
    *map(_mirrored, range(1, LONGEST + 1)),
    *map(_averaged, range(2, LONGEST + 1)),
    *map(_led_on, range(2, LONGEST + 1)),
)
"""Functions that predict the attendance: an earlier value, its mirror image, a mean of values, or a trend."""


@lru_cache(maxsize=8)
def _judged(went: tuple[int, ...], agents: int, forgetting: float) -> tuple[Attendance, Attendance]:
    """Return the forecasts of P predictors for the next evening, (P,), and their past errors, (P,).

    If a predictor needs more evenings than there are, the first evening is repeated.
    """
    padded = np.array([went[0]] * (LONGEST - 1) + list(went), dtype=np.float64)
    past = np.lib.stride_tricks.sliding_window_view(padded, LONGEST)
    predictions = np.array([predictor(past, agents) for predictor in PREDICTORS])
    off = np.abs(predictions[:, :-1] - np.array(went[1:]))
    weights = forgetting * (1 - forgetting) ** np.arange(off.shape[1])[::-1]
    return predictions[:, -1], off @ weights


@lru_cache(maxsize=4096)
def _own(seed: int, agent: int, number: int) -> NDArray[np.int64]:
    return seeding.stream(seed, f"predictors of {agent}").permutation(len(PREDICTORS))[:number]


class FreeRider(ScriptedModel):
    """Gives nothing and punishes nobody."""

    def contribution(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Give nothing."""
        return deciding(0)

    def punishment(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Punish nobody."""
        return deciding(NOBODY)


class Conditional(ScriptedModel):
    """Gives a fixed share of the others' mean contribution in the round before; in the first round, a random amount.

    Fractions of a token are rounded up or down at random, so that the mean is right. With `punishes`, the policy
    punishes the agent that gave least, if that agent gave less than the policy itself.

    Source: Fischbacher, Gächter and Fehr 2001, who found that people give in this way.
    """

    def __init__(self, name: str, slope: float, punishes: bool) -> None:
        super().__init__(name, slope=slope, punishes=punishes)
        check_number("model.slope", slope, 0, 1)
        self._slope, self._punishes = slope, punishes

    def contribution(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Follow the others."""
        had, rounds = math.floor(observation["tokens"]), observation["rounds"]
        if not rounds:
            return deciding(int(rng.integers(had + 1)))
        last = rounds[-1]
        others = (last["pot"] - last["given"]) / max(observation["agents"] - 1, 1)
        return deciding(min(math.floor(self._slope * others + rng.random()), had))

    def punishment(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Punish the first of the agents that gave least."""
        given, agent = observation["given"], observation["agent"]
        least = min(range(len(given)), key=given.__getitem__)
        is_less = self._punishes and given[least] < given[agent] and observation["tokens"] >= observation["cost"]
        return deciding(f"agent {least}" if is_less else NOBODY)


class GreedyCatch(ScriptedModel):
    """Asks for the whole stock."""

    def catch(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Ask for the whole stock."""
        return deciding(observation["stock"])

    def talk(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return SILENCE


class SustainableCatch(GreedyCatch):
    """Asks for the sustainable share, so that the stock grows back."""

    def catch(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Ask for half of the stock divided by the number of agents, in whole tons."""
        return deciding(sustainable(observation["stock"], observation["agents"]))


class BestResponse(ScriptedModel):
    """Says the name that would have earned most in the remembered meetings; a tie is decided at random."""

    def say(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say the name that the others said most often; without memories, any name."""
        names = sorted(observation["names"])
        heard = Counter(met["other"] for met in observation["memory"])
        most = max(heard[name] for name in names)
        best = [name for name in names if heard[name] == most]
        return deciding(best[int(rng.integers(len(best)))])


class FocalName(ScriptedModel):
    """Says the first name in the alphabet, so such agents have a convention from the start."""

    def say(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say the first name."""
        return deciding(min(observation["names"]))


class Planner(ScriptedModel):
    """Takes the action with the highest expected return over the remaining turns, which the world computes."""

    def check(self, question: Question) -> None:
        """Raise InputError for an environment whose rules are not given as a table."""
        if question.kind == "turn" and "best" not in question.told:
            raise InputError(
                f"Model '{self.name}' needs an environment with a table of its rules, such as world=frozen_lake. "
                "Choose another model for this world."
            )

    def turn(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the action with the highest expected return, which the observation states."""
        return json.dumps({"action": observation["best"], "reasoning": "It is worth most in the mean."})
