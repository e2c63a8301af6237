"""Answers of a server whose weights can be exchanged: those to the canary are its weights' own."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from foundry.canary import PROMPTS
from openai_server import Body, ChatCase, grid_reply, refused

WORDS = ("sea", "fox", "red", "nine", "rain", "lamp", "stone", "blue", "door", "seven")


@dataclass
class Weighted:
    """Answers by the weights that it has: equal names are equal weights.

    Attributes:
        weights: their name now.
        noise: spread of the log-probabilities around those of the weights, as flags of a server make it.
        tells: whether it tells log-probabilities, says nothing of them, or refuses them.
        then: told of the number of every other call, from 1, before it is answered.
        canaries: bodies of the canary's calls; others stand in `asked` with the weights that answered.
    """

    weights: str = "first"
    noise: float = 0.0
    tells: bool | None = True
    then: Callable[[int], None] = lambda number: None
    canaries: list[Body] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def __call__(self, body: Body) -> str | ChatCase:
        prompt = body["messages"][0]["content"]
        if prompt in PROMPTS:
            self.canaries.append(body)
            return self._canary(prompt, body)
        self.then(len(self.asked) + 1)
        self.asked.append(self.weights)
        return grid_reply({**body, "seed": f"{self.weights}{body['seed']}"})

    def _canary(self, prompt: str, body: Body) -> ChatCase:
        if self.tells is None and "logprobs" in body:
            return refused(400, "no", code="unsupported_parameter", param="logprobs")
        rng = np.random.default_rng(list(hashlib.sha256(f"{self.weights}{prompt}".encode()).digest()))
        places = [
            dict(zip(rng.permutation(WORDS)[:5].tolist(), -np.sort(rng.uniform(0.5, 4, 5)), strict=True))
            for _ in range(16)
        ]
        rows = [
            [{"token": word, "logprob": float(value + self.noise)} for word, value in top.items()] for top in places
        ]
        told = [{**top[0], "top_logprobs": top} for top in rows]
        return ChatCase(text=" ".join(top[0]["token"] for top in rows), logprobs=told if self.tells else None)
