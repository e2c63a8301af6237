"""Policies for the El Farol bar: a coin of any bias, the symmetric mixed equilibrium, and Arthur's predictors."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import bdtr

from foundry import seeding
from foundry.errors import InputError
from foundry.models.base import Model, RunContext
from foundry.models.scripted.base import ScriptedModel

Attendance: TypeAlias = NDArray[np.float64]
"""How many went, oldest first; or, by `sliding`, one such row for each moment."""

LONGEST = 8
"""Evenings that a predictor looks back at most."""


def decide(go: bool) -> str:
    """Return the reply that goes or stays."""
    return json.dumps({"action": "go" if go else "stay"})


class Tossing(ScriptedModel):
    """Goes with the same probability every evening, whatever was."""

    def __init__(self, name: str, probability: float) -> None:
        """Set the odds.

        Args:
            name: name of the model.
            probability: of going, 0..1.
        """
        super().__init__(name)
        if not 0 <= probability <= 1:
            raise InputError(f"model.probability is {probability}. Give a number from 0 to 1.")
        self._probability = probability

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw whether to go."""
        return decide(rng.random() < self._probability)

    def parameters(self) -> dict[str, Any]:
        """Return the policy and its odds."""
        return super().parameters() | {"probability": self._probability}


class Mixing(ScriptedModel):
    """Goes with the probability with which going and staying are worth the same if all others go with it, too."""

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw whether to go."""
        bar = (observation[key] for key in ("agents", "places", "fun", "crowded", "home"))
        return decide(rng.random() < equilibrium(*bar))


@lru_cache(maxsize=64)
def equilibrium(agents: int, places: int, fun: float, crowded: float, home: float) -> float:
    """Return the probability of going in the symmetric equilibrium.

    For who goes the bar is fun when at most `places` - 1 of the others go, whose number is binomial. Going is worth the
    less the more likely the others go, so there is one such probability; 1 or 0 where nothing makes the two alike.

    Args:
        agents: number of agents.
        places: how many can go before it is crowded.
        fun: utility of going where it is not crowded.
        crowded: of going where it is.
        home: of staying.
    """

    def gain(probability: float) -> float:
        is_fun = float(bdtr(places - 1, agents - 1, probability)) if 0 < places < agents else float(places > 0)
        return fun * is_fun + crowded * (1 - is_fun) - home

    if gain(1.0) >= 0:
        return 1.0
    return float(brentq(gain, 0.0, 1.0, xtol=1e-12)) if gain(0.0) > 0 else 0.0


class Inductive(ScriptedModel):
    """Goes when the predictor that has lately been nearest to the attendance, of a few of its own, says there is room.

    Each agent draws its predictors for the whole run. A predictor is the better the less it was off, the last evenings
    counting most. Before the first attendance is known a coin of the capacity decides.

    Source: Arthur 1994; his predictors are examples, of which these are the kinds.
    """

    def __init__(self, name: str, predictors: int = 6, forgetting: float = 0.3, seed: int | None = None) -> None:
        """Set how agents predict.

        Args:
            name: name of the model.
            predictors: how many each agent has, at least 1.
            forgetting: weight of the last evening's error, the errors before it sharing the rest; 0..1.
            seed: that the predictors are drawn by; a run sets its own.
        """
        super().__init__(name)
        if not 1 <= predictors <= len(PREDICTORS):
            raise InputError(f"model.predictors is {predictors}. Give a whole number from 1 to {len(PREDICTORS)}.")
        self._predictors, self._forgetting, self._seed = predictors, forgetting, seed or 0

    def in_run(self, context: RunContext) -> Model:
        """Return the model with the predictors of this run's agents."""
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

    def parameters(self) -> dict[str, Any]:
        """Return the policy and how it predicts."""
        return super().parameters() | {"predictors": self._predictors, "forgetting": self._forgetting}


def _lagged(back: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: past[:, -back]


def _mirrored(back: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: agents - past[:, -back]


def _averaged(evenings: int) -> Callable[[Attendance, int], Attendance]:
    return lambda past, agents: past[:, -evenings:].mean(axis=1)


def _led_on(evenings: int) -> Callable[[Attendance, int], Attendance]:
    """Return the straight line through the last evenings, one further."""
    times = np.arange(evenings) - (evenings - 1) / 2
    weights = 1 / evenings + times * ((evenings + 1) / 2) / (times**2).sum()
    return lambda past, agents: np.clip(past[:, -evenings:] @ weights, 0, agents)


PREDICTORS = (
    *map(_lagged, range(1, LONGEST + 1)),
    *map(_mirrored, range(1, LONGEST + 1)),
    *map(_averaged, range(2, LONGEST + 1)),
    *map(_led_on, range(2, LONGEST + 1)),
)
"""The attendance of so many evenings ago, its mirror image, an average, a trend."""


@lru_cache(maxsize=8)
def _judged(went: tuple[int, ...], agents: int, forgetting: float) -> tuple[Attendance, Attendance]:
    """Return what each predictor says of the next evening, and how far off it has been, (P,) each.

    Before there are as many evenings as a predictor looks back, the first one stands for those before it.
    """
    padded = np.array([went[0]] * (LONGEST - 1) + list(went), dtype=np.float64)
    past = np.lib.stride_tricks.sliding_window_view(padded, LONGEST)
    said = np.array([predictor(past, agents) for predictor in PREDICTORS])
    off = np.abs(said[:, :-1] - np.array(went[1:]))
    weights = forgetting * (1 - forgetting) ** np.arange(off.shape[1])[::-1]
    return said[:, -1], off @ weights


@lru_cache(maxsize=4096)
def _own(seed: int, agent: int, number: int) -> NDArray[np.int64]:
    """Return the predictors of an agent, indices of PREDICTORS."""
    return seeding.stream(seed, f"predictors of {agent}").permutation(len(PREDICTORS))[:number]
