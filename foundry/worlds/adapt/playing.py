"""One episode of an environment of any library: the agents that act now, and their rewards."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from foundry.worlds.adapt.spaces import mask_of


@dataclass(frozen=True)
class Seen:
    """The input of an agent before its decision.

    Attributes:
        state: the environment's observation.
        mask: 1 for each action that is legal now; None for all.
    """

    state: Any
    mask: list[int] | None


class Playing(ABC):
    """A running episode.

    Attributes:
        env: the library's environment.
    """

    env: Any

    @abstractmethod
    def asked(self) -> Mapping[int, Seen]:
        """Return the agents that must act now, by id; empty once the episode is over."""

    @abstractmethod
    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply an action of the environment per agent; return the rewards, by id."""

    def picture(self) -> Any:
        """Return the present state as pixels, (height, width, 3), or None if the environment draws none."""
        return self.env.render()

    def close(self) -> None:
        """Release the environment."""
        self.env.close()


class OfOne(Playing):
    """An episode of a Gymnasium environment."""

    def __init__(self, env: Any, seed: int) -> None:
        """Begin an episode with this seed."""
        self.env = env
        self.state, info = env.reset(seed=seed)
        self._mask = mask_of(self.state, info)
        self._over = False

    def asked(self) -> Mapping[int, Seen]:
        """Return the one agent, until the environment ends or truncates the episode."""
        return {} if self._over else {0: Seen(self.state, self._mask)}

    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply its action."""
        self.state, reward, ended, cut, info = self.env.step(actions[0])
        self._mask, self._over = mask_of(self.state, info), bool(ended or cut)
        return {0: float(reward)}


class OfAll(Playing):
    """An episode of a PettingZoo environment whose agents all act at once."""

    def __init__(self, env: Any, seed: int) -> None:
        """Begin an episode with this seed."""
        self.env = env
        self._ids = {name: place for place, name in enumerate(env.possible_agents)}
        self._states, self._infos = env.reset(seed=seed)

    def asked(self) -> Mapping[int, Seen]:
        """Return the remaining agents."""
        states, infos = self._states, self._infos or {}
        return {self._ids[name]: Seen(states[name], mask_of(states[name], infos.get(name))) for name in self.env.agents}

    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply an action of each agent."""
        names = list(self._ids)
        self._states, rewards, _, _, self._infos = self.env.step({names[one]: act for one, act in actions.items()})
        return {self._ids[name]: float(reward) for name, reward in rewards.items()}


class InTurn(Playing):
    """An episode of a PettingZoo environment whose agents act in turn."""

    def __init__(self, env: Any, seed: int) -> None:
        """Begin an episode with this seed."""
        self.env = env
        env.reset(seed=seed)
        self._ids = {name: place for place, name in enumerate(env.possible_agents)}

    def asked(self) -> Mapping[int, Seen]:
        """Return the agent whose turn it is."""
        if not self.env.agents:
            return {}
        state, _, _, _, info = self.env.last()
        return {self._ids[self.env.agent_selection]: Seen(state, mask_of(state, info))}

    def take(self, actions: Mapping[int, Any]) -> Mapping[int, float]:
        """Apply the action of the agent whose turn it is.

        The rewards are those that become known now: of the next agent, and of agents that are out and are skipped.
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
