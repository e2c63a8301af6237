"""Settings of models of the `transformers` library; imports nothing heavy."""

from __future__ import annotations

from typing import Annotated

import msgspec

from foundry.models.serving import Count, Serving

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]


class Sampling(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How tokens are drawn, in this order.

    Attributes:
        temperature: divides the logits; 0 takes the likeliest token.
        top_k: how many of the likeliest tokens are kept; 0 for all.
        top_p: of these, the likeliest that together have this probability.
        min_p: of these, those with at least this share of the likeliest one's probability.
        max_new_tokens: longest reply.
    """

    temperature: Annotated[float, msgspec.Meta(ge=0)]
    top_k: Annotated[int, msgspec.Meta(ge=0)]
    top_p: Annotated[float, msgspec.Meta(gt=0, le=1)]
    min_p: Share
    max_new_tokens: Count


class LocalServing(Serving, frozen=True, kw_only=True):
    """How a model is run within foundry.

    Attributes:
        device: `auto`, or what torch calls it.
        batch_size: calls that are answered together.
    """

    device: str
    batch_size: Count
