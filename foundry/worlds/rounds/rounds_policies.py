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

Attendance: TypeAlias = NDArray[np.float64]
"""Attendances, oldest first; or a window of attendances for each evening."""

LONGEST = 8
"""Maximum number of evenings that a predictor uses."""
NOBODY = json.dumps({"action": "nobody"})


def decide(go: bool) -> str:
    """Return the reply that goes or stays."""
    return json.dumps({"action": "go" if go else "stay"})


class Tossing(ScriptedModel):
    """Goes with the same probability every evening."""

    def __init__(self, name: str, probability: float) -> None:
        super().__init__(name, probability=probability)
        if not 0 <= probability <= 1:
            raise InputError(f"model.probability is {probability}. Give a number from 0 to 1.")
        self._probability = probability

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw whether to go."""
        return decide(rng.random() < self._probability)


class Mixing(ScriptedModel):
    """Goes with the probability of the symmetric equilibrium, where going and staying have equal expected utility."""

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw whether to go."""
        bar = (observation[key] for key in ("agents", "places", "fun", "crowded", "home"))
        return decide(rng.random() < equilibrium(*bar))


@lru_cache(maxsize=64)
def equilibrium(agents: int, places: int, fun: float, crowded: float, home: float) -> float:
    """Return the probability of going in the symmetric equilibrium.

    For an agent that goes, the bar is fun if at most `places` - 1 of the others go; this number is binomial. Going is
    worth less the more likely the others go, so there is exactly one such probability. It is 1 if going is always worth
    more, and 0 if it never is.

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
    """Goes if the best of its predictors of the attendance expects room.

    Each agent draws its predictors for the whole run. The best predictor has the smallest error; the last evenings
    count most. Before the first attendance is known, the agent goes with the capacity as probability.

    Source: Arthur 1994, who gives examples of these kinds of predictors.
    """

    def __init__(self, name: str, predictors: int = 6, forgetting: float = 0.3, seed: int | None = None) -> None:
        super().__init__(name, predictors=predictors, forgetting=forgetting)
        if not 1 <= predictors <= len(PREDICTORS):
            raise InputError(f"model.predictors is {predictors}. Give a whole number from 1 to {len(PREDICTORS)}.")
        self._predictors, self._forgetting, self._seed = predictors, forgetting, seed or 0

    def in_run(self, context: RunContext) -> Model:
        """Return the model with predictors for the agents of a run."""
        return Inductive(self.name, self._predictors, self._forgetting, context.seed)

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Follow the best predictor."""
        went = tuple(one["went"] for one in observation["evenings"] if one["went"] is not None)
        agents, places = observation["agents"], observation["places"]
        if not went:
            return decide(rng.random() < places / agents)
        forecasts, errors = _judged(went, agents, self._forgetting)
        own = _own(self._seed, observation["agent"], self._predictors)
        best = own[np.argmin(errors[own])]
        return decide(bool(forecasts[best] <= places))


def _lagged(back: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: past[:, -back]


def _mirrored(back: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: agents - past[:, -back]


def _averaged(evenings: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: past[:, -evenings:].mean(axis=1)


def _led_on(evenings: int) -> Callable[[Attendance, int], Attendance]:
    """Return a function that extends the straight line through the last evenings by one evening."""
    times = np.arange(evenings) - (evenings - 1) / 2
    weights = 1 / evenings + times * ((evenings + 1) / 2) / (times**2).sum()
    return lambda past, agents: np.clip(past[:, -evenings:] @ weights, 0, agents)


PREDICTORS = (
    *map(_lagged, range(1, LONGEST + 1)),
    *map(_mirrored, range(1, LONGEST + 1)),
    *map(_averaged, range(2, LONGEST + 1)),
    *map(_led_on, range(2, LONGEST + 1)),
)
"""An earlier attendance, its mirror image, an average, or a trend."""


@lru_cache(maxsize=8)
def _judged(went: tuple[int, ...], agents: int, forgetting: float) -> tuple[Attendance, Attendance]:
    """Return each predictor's forecast for the next evening and its past error, (P,) each.

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
    """Return the predictors of an agent as indices of PREDICTORS."""
    return seeding.stream(seed, f"predictors of {agent}").permutation(len(PREDICTORS))[:number]


def give(tokens: int) -> str:
    """Return the reply that gives this number of tokens."""
    return json.dumps({"action": tokens})


class FreeRider(ScriptedModel):
    """Gives nothing and punishes nobody."""

    def contribution(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Give nothing."""
        return give(0)

    def punishment(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Punish nobody."""
        return NOBODY


class Conditional(ScriptedModel):
    """Gives a share of the others' mean contribution in the round before; at first a random number of tokens.

    It rounds fractions of a token up or down at random, so that the mean is right. If `punishes` is set, it punishes
    the agent that gave least, if that agent gave less than itself.

    Source: Fischbacher, Gächter and Fehr 2001, who found that people give in this way.
    """

    def __init__(self, name: str, slope: float, punishes: bool) -> None:
        super().__init__(name, slope=slope, punishes=punishes)
        if not 0 <= slope <= 1:
            raise InputError(f"model.slope is {slope}. Give a number from 0 to 1.")
        self._slope, self._punishes = slope, punishes

    def contribution(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Follow the others."""
        had, rounds = math.floor(observation["tokens"]), observation["rounds"]
        if not rounds:
            return give(int(rng.integers(had + 1)))
        last = rounds[-1]
        others = (last["pot"] - last["given"]) / max(observation["agents"] - 1, 1)
        return give(min(math.floor(self._slope * others + rng.random()), had))

    def punishment(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Punish the first of the agents that gave least."""
        given, agent = observation["given"], observation["agent"]
        least = min(range(len(given)), key=given.__getitem__)
        is_less = self._punishes and given[least] < given[agent] and observation["tokens"] >= observation["cost"]
        return json.dumps({"action": f"agent {least}"}) if is_less else NOBODY


class GreedyCatch(ScriptedModel):
    """Asks for the whole stock."""

    def catch(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Want the whole stock."""
        return json.dumps({"action": observation["stock"]})

    def talk(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say nothing."""
        return json.dumps({"message": None})


class SustainableCatch(GreedyCatch):
    """Takes the sustainable share, so that the stock grows back."""

    def catch(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Want an equal share of half of the stock, in whole tons."""
        return json.dumps({"action": observation["stock"] // 2 // observation["agents"]})


class BestResponse(ScriptedModel):
    """Says the name that would have earned most in the remembered meetings; a tie is decided at random."""

    def say(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say the others' most frequent name, or any name without memories."""
        names = sorted(observation["names"])
        heard = Counter(met["other"] for met in observation["memory"])
        most = max(heard[name] for name in names)
        best = [name for name in names if heard[name] == most]
        return json.dumps({"action": best[int(rng.integers(len(best)))]}, ensure_ascii=False)


class FocalName(ScriptedModel):
    """Says the first name in the alphabet, so such agents have a convention from the start."""

    def say(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say the first name."""
        return json.dumps({"action": min(observation["names"])}, ensure_ascii=False)


class Planner(ScriptedModel):
    """Takes the best action for the remaining turns, from `Question.secret`: `best`."""

    def check(self, question: Question) -> None:
        """Reject an environment without a table of rules."""
        if question.kind == "turn" and "best" not in question.told:
            raise InputError(f"Model '{self.name}' plans with a table of rules, which this environment does not have.")

    def turn(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Return the best action."""
        return json.dumps({"action": observation["best"], "reasoning": "It is worth most in the mean."})
