"""Sampling with a seed per row, so that a reply does not depend on the batch it was made in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch

from foundry.models.local.settings import Sampling


class SeededRows:
    """Chooses every row's next token by its own generator; the generation then finds that token alone.

    One uniform number is drawn per row and token and looked up in the row's cumulative distribution, so that
    rounding, which does depend on the batch, moves a choice only where that number meets a boundary.
    """

    def __init__(self, sampling: Sampling, seeds: Sequence[int]) -> None:
        self._sampling = sampling
        self._generators = [torch.Generator().manual_seed(seed) for seed in seeds]

    def __call__(self, input_ids: Any, scores: Any) -> Any:
        """Return scores, shape (rows, vocabulary), with the chosen token at 0 and all others at -inf."""
        chosen = self._chosen(scores.to(torch.float64 if scores.dtype == torch.float64 else torch.float32))
        return torch.full_like(scores, float("-inf")).scatter_(1, chosen, 0.0)

    def _chosen(self, scores: Any) -> Any:
        if self._sampling.temperature == 0:
            return scores.argmax(dim=1, keepdim=True)
        kept = min(self._sampling.top_k or scores.shape[1], scores.shape[1])
        values, tokens = torch.topk(scores, kept, dim=1)
        chances = _kept_chances(values, self._sampling)
        draws = [torch.rand((1,), generator=generator, dtype=torch.float64) for generator in self._generators]
        drawn = torch.stack(draws).to(device=scores.device, dtype=scores.dtype)
        below = chances.cumsum(dim=1) <= drawn * chances.sum(dim=1, keepdim=True)
        last = (chances > 0).sum(dim=1, keepdim=True) - 1
        return tokens.gather(1, torch.minimum(below.sum(dim=1, keepdim=True), last))


def _kept_chances(values: Any, sampling: Sampling) -> Any:
    """Return the probabilities, not normalised, of logits in falling order, shape (rows, kept); 0 for those dropped."""
    chances = torch.softmax(values / sampling.temperature, dim=1)
    before = chances.cumsum(dim=1) - chances
    dropped = (before >= sampling.top_p) | (chances < sampling.min_p * chances[:, :1])
    dropped[:, 0] = False
    return chances.masked_fill(dropped, 0.0)
