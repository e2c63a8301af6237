"""Computes the best policy of an environment whose rules are a table of transition probabilities (`P`)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foundry.errors import InputError


def plan_of(env: Any, steps: int) -> NDArray[np.int64] | None:
    """Return the best action at each turn in each state, (turns, states); None if the environment has no table `P`.

    The method is backward induction (Bellman 1957) over the remaining turns; the first of equally good actions wins.

    Args:
        env: an environment whose `P[state][action]` is a list of (probability, next state, reward, ended).
        steps: maximum number of turns in an episode.
    """
    rules = getattr(env.unwrapped, "P", None)
    if not isinstance(rules, Mapping):
        return None
    limit = env.spec.max_episode_steps if env.spec is not None else None
    turns = min(steps, limit or steps)
    chance, follows, reward, goes_on = _arrays(rules)
    if not (chance * reward).any():
        raise InputError(f"{_as_set(env)} never gives a reward. Give its map a goal in world.settings.")
    if np.isnan(getattr(env.unwrapped, "initial_state_distrib", 0.0)).any():
        raise InputError(f"{_as_set(env)} has no start. Give its map a start in world.settings.")
    value = np.zeros(len(rules))
    choices = []
    for _ in range(turns):
        expected = (chance * (reward + goes_on * value[follows])).sum(axis=2)
        choices.append(expected.round(12).argmax(axis=1))
        value = expected.max(axis=1)
    return np.array(choices[::-1])


def _as_set(env: Any) -> str:
    return f"Environment '{env.spec.id}', as it is set," if env.spec is not None else "The environment, as it is set,"


def _arrays(rules: Mapping[int, Mapping[int, Any]]) -> tuple[Any, ...]:
    """Return four (states, actions, outcomes) arrays: probability, next state, reward, 1 if the episode goes on."""
    most = max(len(outcomes) for actions in rules.values() for outcomes in actions.values())
    shape = (len(rules), len(rules[0]), most)
    chance, reward, goes_on = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    follows = np.zeros(shape, dtype=np.int64)
    for state, actions in rules.items():
        for action, outcomes in actions.items():
            for place, (odds, after, got, ended) in enumerate(outcomes):
                at = (state, action, place)
                chance[at], follows[at], reward[at], goes_on[at] = odds, after, got, not ended
    return chance, follows, reward, goes_on
