"""Finds out by canary calls which weights a server has, if it reports no digest and had other weights before."""

import asyncio
import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from foundry.expansion import Sweep, settings_key
from foundry.models.answers.answers import Answers
from foundry.models.answers.known_weights import KnownWeights, Signs, with_weights
from foundry.models.answers.opening import existing_answers, open_answers
from foundry.models.base import Model, ModelInfo
from foundry.models.wrappers.canaries import CanaryAsker, canary_of
from foundry.running.build import build, each_info, members_of
from foundry.storing.store import SweepFolder


def identified(sweep: Sweep, infos: Mapping[str, ModelInfo], cache: str, *, ask: bool = True) -> dict[str, ModelInfo]:
    """Return the facts about each model. If a server reports no digest, foundry adds one for the present weights.

    If only one set of weights is known for the model's name, this makes no calls; the first call of the sweep checks
    the canary. If several sets are known, each with its own keys of answers, the canary says which set answers now.

    Args:
        sweep: the sweep.
        infos: the servers' facts, by `expansion.settings_key`.
        cache: address of the answer cache, which knows the canaries.
        ask: whether to make canary calls; if not, the weights that were found last are assumed.
    """
    digests = {
        model.name: _digest(model, known, ask) for model, _, known in _measured(sweep, infos, existing_answers, cache)
    }
    return {key: _with_digests(info, digests) for key, info in infos.items()}


def remember(folder: SweepFolder, infos: Mapping[str, ModelInfo], cache: str) -> None:
    """If the cache does not know the weights with which a sweep began, copy them from the records to the cache."""
    for model, digest, known in _measured(folder.sweep, infos, open_answers, cache):
        if digest not in known.all():
            summaries = (run.summary() for run in SweepFolder.open(folder.path).runs())
            canaries = (canary for summary in summaries if summary is not None for canary in summary.canaries)
            begun = next((canary for canary in canaries if canary.model == model.name), None)
            if begun is not None:
                known.add(begun.signs, digest)


def _measured(
    sweep: Sweep, infos: Mapping[str, ModelInfo], opened: Callable[[str], Answers | None], cache: str
) -> Iterator[tuple[Model, str, KnownWeights]]:
    configs = {settings_key(condition.config["model"]): condition.config["model"] for condition in sweep.conditions}
    measured = {key: info for key, info in infos.items() if any(model_info.measured for model_info in each_info(info))}
    answers = opened(cache) if measured else None
    if answers is None:
        return
    with contextlib.closing(answers):
        for key, info in measured.items():
            for model, model_info in zip(members_of(build(configs[key])), each_info(info), strict=True):
                canary = canary_of(model) if model_info.measured else None
                if canary is not None and model_info.digest is not None:
                    yield model, model_info.digest, KnownWeights(answers, canary, model_info.digest)


def _with_digests(info: ModelInfo, digests: Mapping[str, str]) -> ModelInfo:
    members = tuple(_with_digests(member, digests) for member in info.members)
    return replace(with_weights(info, digests.get(info.name, "")), members=members)


def _digest(model: Model, known: KnownWeights, ask: bool) -> str:
    """Return the digest of the weights that now answer; "" if at most one set of weights is known."""
    digests = list(known.all())
    if len(digests) < 2:
        return ""
    replies = asyncio.run(_asked(model)) if ask else []
    return known.digest_of(replies[0]) if replies else digests[-1]


async def _asked(model: Model) -> list[Signs]:
    try:
        return await CanaryAsker(model).ask()
    finally:
        await model.close()
