"""The spread of news of a fire: which agent first warned which other, and which agents the news could have reached.

In each step, agents first perceive, then speak, then hear the messages of this step. An agent can therefore pass on a
message of step t at step t + 1 or later.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.formulas import mean, ratio

NEVER: int = np.iinfo(np.int64).max
"""Stands for the step of an event that never happens."""

NOBODY = -1


@dataclass(frozen=True)
class Cascade:
    """The way in which each agent learnt of a fire; every array has one element per agent, (N,).

    The forest has an edge from the sender of an agent's first warning to this agent, if the agent sent no warning
    before.

    Attributes:
        direct: whether the agent perceived a fire before it received any warning.
        told: whether it received a warning before it perceived a fire, or without ever perceiving one.
        told_at: step of the first received warning, or NEVER.
        parent: sender of that warning if an edge of the forest leads to the agent, or NOBODY.
    """

    direct: BoolArray
    told: BoolArray
    told_at: IntArray
    parent: IntArray

    @property
    def edges(self) -> int:
        """Number of agents that another agent's warning told of a fire first."""
        return int((self.parent != NOBODY).sum())

    @cached_property
    def depths(self) -> IntArray:
        """Number of warnings from the root of each agent's tree down to the agent, (N,)."""
        depths = np.zeros(len(self.parent), dtype=np.int64)
        for agent in self._downwards():
            depths[agent] = depths[self.parent[agent]] + 1
        return depths

    @property
    def depth(self) -> int:
        """Number of warnings in the longest chain, from a root of the forest on."""
        return int(self.depths.max(initial=0))

    @property
    def trees(self) -> int:
        """Number of trees with two agents or more."""
        parents = np.unique(self.parent[self.parent != NOBODY])
        return int((self.parent[parents] == NOBODY).sum())

    @property
    def virality(self) -> float:
        """Structural virality, mean over the trees of two agents or more; NaN without such trees.

        The virality of a tree is the mean distance over all pairs of its n agents: 2 - 2/n for a star, (n + 1)/3 for a
        chain. Source: Goel et al. 2015.
        """
        below, roots = self._below_and_roots()
        pairs = np.zeros(len(below), dtype=np.float64)
        linked = np.flatnonzero(self.parent != NOBODY)
        # An edge lies on the paths between the agents below it and all others in its tree.
        np.add.at(pairs, roots[linked], below[linked] * (below[roots[linked]] - below[linked]))
        sizes = below[np.unique(roots[linked])]
        sums = pairs[np.unique(roots[linked])]
        return mean(
            ratio(2 * total, size * (size - 1)) for total, size in zip(sums.tolist(), sizes.tolist(), strict=True)
        )

    def _downwards(self) -> list[int]:
        """Return the agents with a parent, by the step at which they were told; each comes after its parent."""
        order = np.argsort(self.told_at, kind="stable")
        return [int(agent) for agent in order if self.parent[agent] != NOBODY]

    def _below_and_roots(self) -> tuple[IntArray, IntArray]:
        """Return, for each agent, (N,), the number of agents in its subtree, itself included, and its tree's root."""
        below, roots = np.ones(len(self.parent), dtype=np.int64), np.arange(len(self.parent))
        for agent in reversed(self._downwards()):
            below[self.parent[agent]] += below[agent]
        for agent in self._downwards():
            roots[agent] = roots[self.parent[agent]]
        return below, roots


def first_step(flags: BoolArray) -> IntArray:
    """Return the 1-based step at which each agent's flag is first set, or NEVER, (N,); flags has shape (T, N)."""
    return np.where(flags.any(axis=0), flags.argmax(axis=0) + 1, NEVER)


def trace(perceived_at: IntArray, warned_at: IntArray, heard: IntArray) -> Cascade:
    """Return how each agent learnt of a fire.

    The first warning to an agent is the one at the lowest step; among several, the one from the lowest id.

    Args:
        perceived_at: step at which each agent first perceives a fire, or NEVER, (N,).
        warned_at: step at which each agent first sends a warning, or NEVER, (N,).
        heard: rows (step, sender, recipient) of delivered warnings, (M, 3).
    """
    told_at = np.full(len(perceived_at), NEVER)
    sender = np.full(len(perceived_at), NOBODY)
    # Written from the last to the first, so the first remains.
    ordered = heard[np.lexsort((heard[:, 1], heard[:, 0]))[::-1]]
    told_at[ordered[:, 2]], sender[ordered[:, 2]] = ordered[:, 0], ordered[:, 1]
    is_told = told_at < perceived_at
    return Cascade(
        direct=(perceived_at < NEVER) & ~is_told,
        told=is_told,
        told_at=told_at,
        parent=np.where(is_told & (warned_at > told_at), sender, NOBODY),
    )


def spread(perceived_at: IntArray, links: IntArray) -> IntArray:
    """Return the step at which news would reach each agent if all agents always passed it on, or NEVER, (N,).

    Args:
        perceived_at: step at which each agent first sees a fire itself, or NEVER, (N,).
        links: rows (step, from, to), (K, 3). News takes one link per step, because an agent passes it on a step later.
    """
    reached = np.full(len(perceived_at), NEVER)
    ordered = links[np.argsort(links[:, 0], kind="stable")]
    steps, starts = np.unique(ordered[:, 0], return_index=True)
    for step, rows in zip(steps.tolist(), np.split(ordered, starts[1:]), strict=False):
        knows = (perceived_at <= step) | (reached < NEVER)  # until here only news from earlier steps is recorded
        arrived = rows[knows[rows[:, 1]], 2]
        reached[arrived] = np.minimum(reached[arrived], step)
    return reached


@dataclass(frozen=True)
class Relays:
    """How many agents that were told of a fire could pass the warning on, and how many of these agents did.

    Both arrays have one number for each of S ways of labelling the same messages, (S,).
    """

    could: IntArray
    did: IntArray

    @property
    def shares(self) -> FloatArray:
        """Agents that passed a warning on / agents that could, (S,); NaN if no agent could."""
        return np.asarray(np.where(self.could > 0, self.did / np.maximum(self.could, 1), np.nan))


def find_relays(
    warned: BoolArray, told_at: IntArray, perceived_at: IntArray, *, able: BoolArray, within: int
) -> Relays:
    """Return how many agents could pass a warning on, and how many did, for S ways of labelling the same messages.

    Args:
        warned: whether an agent sent a warning, by labelling, step and agent, (S, T, N).
        told_at: step of the first received warning, or NEVER, by labelling and agent, (S, N).
        perceived_at: step at which each agent first perceives a fire, or NEVER, (N,).
        able: whether the agent decided on a message, (T, N); an agent without a decision in time could not relay.
        within: number of steps after `told_at` that count. Steps from `perceived_at` on do not count, because the agent
            may then report a fire that it sees itself.
    """
    rows, agents = np.ogrid[: warned.shape[0], : warned.shape[2]]
    start = np.minimum(told_at, warned.shape[1])
    # An agent that is not told has no such steps and must not look back.
    end = np.maximum(np.minimum(np.minimum(start + within, warned.shape[1]), perceived_at - 1), start)
    decided, sent = _running(able[None])[0], _running(warned)
    could = (told_at < perceived_at) & (decided[end, agents] > decided[start, agents])
    did = could & (sent[rows, end, agents] > sent[rows, start, agents])
    return Relays(could.sum(axis=1), did.sum(axis=1))


def _running(flags: BoolArray) -> NDArray[np.int32]:
    """Return how many flags are set before each step, (S, T + 1, N); `flags` has shape (S, T, N)."""
    counts = np.zeros((flags.shape[0], flags.shape[1] + 1, flags.shape[2]), dtype=np.int32)
    np.cumsum(flags, axis=1, out=counts[:, 1:])
    return counts
