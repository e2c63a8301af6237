"""Runs whose decisions are drawn by probabilities that their tokens tell."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from analysis.any.any_arrays import objects
from analysis.any.any_run import AnyRun, Probabilities
from blind_any_runs import LABELS, any_run
from foundry import seeding
from foundry.canary import TokenLogprobs
from foundry.certainty import Certainty, Sampling, certainty_of

OPENLY = {"top_k": 0, "top_p": 1.0, "min_p": 0.0}
"""Options of a call with which every token can be drawn."""


def place(token: str, **chances: float) -> TokenLogprobs:
    """Return a token with the chances of the likeliest ones in its place, its own among them."""
    top = {name: math.log(chance) for name, chance in chances.items()}
    return TokenLogprobs(token, top[token], top)


def told(decided: str, chances: Mapping[str, float], **options: float) -> Certainty:
    sampling = Sampling.of({"temperature": 1.0, **OPENLY, **options})
    found = certainty_of(decided, [place(decided, **chances)], decided, LABELS, sampling)
    assert found is not None
    return found


def told_run(run: AnyRun, certainties: list[Certainty | None], truth: list[str | None] | None = None) -> AnyRun:
    """Return a run with what its tokens tell, and which decisions are right."""
    right = [None] * len(certainties) if truth is None else truth
    return replace(run, probabilities=Probabilities(objects(certainties), objects(right), truth is not None))


@dataclass(frozen=True)
class TellingCrowd:
    """Agents that draw each decision by chances of its own, at a temperature; what is right is drawn by them, too.

    Attributes:
        said: the temperature that the calls say; None says the one that is used.
    """

    temperature: float = 1.0
    said: float | None = None
    steps: int = 40
    agents: int = 8

    def play(self, seed: int) -> AnyRun:
        rng = seeding.stream(seed, "telling")
        chances = rng.dirichlet([1.0] * len(LABELS), size=(self.steps, self.agents))
        powers = chances ** (1 / self.temperature)
        powers /= powers.sum(axis=-1, keepdims=True)
        cells = [(step, agent) for step in range(self.steps) for agent in range(self.agents)]
        decided = [LABELS[rng.choice(3, p=powers[cell])] for cell in cells]
        right: list[str | None] = [LABELS[rng.choice(3, p=chances[cell])] for cell in cells]
        said = self.temperature if self.said is None else self.said
        certainties = [
            told(label, dict(zip(LABELS, np.maximum(chances[cell], 1e-12).tolist(), strict=True)), temperature=said)
            for label, cell in zip(decided, cells, strict=True)
        ]
        run = any_run([(step + 1, agent, label) for (step, agent), label in zip(cells, decided, strict=True)])
        return told_run(run, [*certainties], right)


TELLING = {"at temperature 1": TellingCrowd(), "at temperature .5": TellingCrowd(temperature=0.5)}
"""Crowds that draw as their tokens tell, and are right as often as they are sure."""
