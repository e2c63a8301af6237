"""Plays environments of Gymnasium and PettingZoo through one interface: who acts now, and with which reward."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from foundry.declared import Actions
from foundry.errors import InputError

MASK = "action_mask"
"""Key under which an environment lists its legal actions, in the observation or in the infos."""


@dataclass(frozen=True)
class Choices:
    """The possible decisions in an environment, under the names that a world gives them.

    Attributes:
        labels: name of each action, in the order of the space; empty if the decision is a number.
        first: number of the first action in the space.
        low: smallest number, if the decision is a number.
        shape: shape of the array that the environment takes for a number; () for a plain number.
        idle: name of the action that does nothing, or None.
    """

    labels: tuple[str, ...] = ()
    first: int = 0
    low: float | None = None
    high: float | None = None
    shape: tuple[int, ...] = ()
    idle: str | None = None

    @cached_property
    def actions(self) -> Actions:
        """The possible decisions."""
        return Actions(labels=self.labels, low=self.low, high=self.high, whole=False, idle=self.idle)

    def legal(self, mask: Sequence[int] | None) -> Actions:
        """Return the decisions that a mask of legal actions allows; without a mask (None), all decisions are legal."""
        if mask is None or all(mask):
            return self.actions
        labels = tuple(label for label, allowed in zip(self.labels, mask, strict=True) if allowed)
        return Actions(labels=labels, idle=self.idle if self.idle in labels else None)

    def taken(self, decided: Any) -> Any:
        """Convert a decision to an action of the environment."""
        if self.labels:
            return self.first + self.labels.index(decided)
        return np.full(self.shape, decided, dtype=np.float32) if self.shape else float(decided)


def choices_of(space: Any, labels: Sequence[str] | None, idle: str | None, where: str) -> Choices:
    """Convert an action space of the library to possible decisions."""
    kind = type(space).__name__
    if kind == "Box" and int(np.prod(space.shape)) == 1 and labels is None and idle is None:
        low, high = (float(np.reshape(end, -1)[0]) for end in (space.low, space.high))
        return Choices(low=low, high=high, shape=space.shape)
    if kind != "Discrete":
        raise InputError(
            f"{where} takes actions of the kind {space}, which foundry cannot read from a reply. Wrap it to take a "
            "finite set (Discrete) or one number (Box of one value, without world.actions)."
        )
    count, first = int(space.n), int(space.start)
    named = tuple(labels or map(str, range(first, first + count)))
    if len(named) != count or len(set(named)) != count or not all(isinstance(name, str) and name for name in named):
        raise InputError(
            f"world.actions={list(named)} must name the {count} actions of {where}, each once and in order."
        )
    if idle is not None and idle not in named:
        raise InputError(f"world.idle={idle} is not an action of {where}. Choose from {', '.join(named)}.")
    return Choices(labels=named, first=first, idle=idle)


def plain(value: Any) -> Any:
    """Convert an observation to plain containers, numbers and texts."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return value if isinstance(value, str | int | float | bool | None) else str(value)


def mask_of(*infos: Any) -> list[int] | None:
    """Return the first mask of legal actions in an observation or info; None if neither has one."""
    for info in infos:
        if isinstance(info, Mapping) and MASK in info:
            return [int(allowed) for allowed in info[MASK]]
    return None


@dataclass(frozen=True)
class AgentView:
    """The data for an agent before its decision.

    Attributes:
        state: the environment's observation.
        mask: 1 for each action that is legal now; None for all.
    """

    state: Any
    mask: list[int] | None


class Playing(ABC):
    """A running episode."""

    env: Any

    @abstractmethod
    def asked(self) -> Mapping[int, AgentView]:
        """Return the agents that must act now, by id; empty once the episode is over."""

    @abstractmethod
    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply the agents' actions, and return the agents' rewards; actions and rewards are given by agent id."""

    def picture(self) -> Any:
        """Return the present state as pixels, (height, width, 3), or None if the environment draws none."""
        return self.env.render()

    def close(self) -> None:
        """Release the environment."""
        self.env.close()


class OfOne(Playing):
    """An episode of a Gymnasium environment."""

    def __init__(self, env: Any, seed: int) -> None:
        self.env = env
        self.state, info = env.reset(seed=seed)
        self._mask = mask_of(self.state, info)
        self._over = False

    def asked(self) -> Mapping[int, AgentView]:
        """Return agent 0; nothing once the episode is over."""
        return {} if self._over else {0: AgentView(self.state, self._mask)}

    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply its action."""
        self.state, reward, ended, cut, info = self.env.step(actions[0])
        self._mask, self._over = mask_of(self.state, info), bool(ended or cut)
        return {0: float(reward)}


class OfAll(Playing):
    """An episode of a PettingZoo environment in which all agents act at once."""

    def __init__(self, env: Any, seed: int) -> None:
        self.env = env
        self._ids = {name: place for place, name in enumerate(env.possible_agents)}
        self._states, self._infos = env.reset(seed=seed)

    def asked(self) -> Mapping[int, AgentView]:
        """Return all agents that are still in the episode."""
        states, infos = self._states, self._infos or {}
        return {
            self._ids[name]: AgentView(states[name], mask_of(states[name], infos.get(name))) for name in self.env.agents
        }

    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply an action of each agent."""
        names = list(self._ids)
        self._states, rewards, _, _, self._infos = self.env.step({names[agent]: act for agent, act in actions.items()})
        return {self._ids[name]: float(reward) for name, reward in rewards.items()}


class InTurn(Playing):
    """An episode of a PettingZoo environment in which agents act in turn."""

    def __init__(self, env: Any, seed: int) -> None:
        self.env = env
        env.reset(seed=seed)
        self._ids = {name: place for place, name in enumerate(env.possible_agents)}

    def asked(self) -> Mapping[int, AgentView]:
        """Return the agent whose turn it is."""
        if not self.env.agents:
            return {}
        state, _, _, _, info = self.env.last()
        return {self._ids[self.env.agent_selection]: AgentView(state, mask_of(state, info))}

    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply the action of the agent whose turn it is.

        Return the rewards that become known now: those of the next agent and of agents that left the episode.
        """
        (action,) = actions.values()
        self.env.step(action)
        rewards: dict[int, float] = {}
        while self.env.agents:
            _, reward, ended, cut, _ = self.env.last()
            rewards[self._ids[self.env.agent_selection]] = float(reward)
            if not (ended or cut):
                break
            self.env.step(None)
        return rewards
