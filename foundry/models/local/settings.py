"""Settings of models of the `transformers` library; this module does not import the library."""

from __future__ import annotations

from typing import Annotated

import msgspec

from foundry.models.serving import Count, Serving

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]


class Sampling(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings that say how a model draws its tokens; they stand under `options` in `conf/model/hf.yaml`."""

    temperature: Annotated[float, msgspec.Meta(ge=0)]
    top_k: Annotated[int, msgspec.Meta(ge=0)]
    top_p: Annotated[float, msgspec.Meta(gt=0, le=1)]
    min_p: Share
    max_new_tokens: Count


class LocalServing(Serving, frozen=True, kw_only=True):
    """Settings for running a model within foundry, as in `conf/model/hf.yaml`."""

    device: str
    batch_size: Count
