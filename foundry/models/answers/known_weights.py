"""Remembers, in the cache of answers, the canary of each set of weights that was found behind the name of a model."""

from dataclasses import replace

import msgspec

from foundry.canary import MARK, PROMPTS, Distance, Sign, Verdict, listed, short_of
from foundry.models.answers.answers import Answers
from foundry.models.base import ChatMessage, Model, ModelInfo, Reply, RequestKeys

MOST = 1000
"""Maximum number of sets of weights that foundry distinguishes under one model name."""
_MESSAGES = tuple(ChatMessage("user", prompt) for prompt in PROMPTS)
Signs = tuple[Sign, ...]


def with_weights(info: ModelInfo, digest: str) -> ModelInfo:
    """Return the facts about a model with the digest of the weights that answer now."""
    _, mark, weights = digest.partition(MARK)
    if info.digest is None or not mark:
        return info
    weights_named = None if info.weights is None else listed(info.weights) + mark + weights
    return replace(info, digest=listed(info.digest) + mark + weights, weights=weights_named)


class _Row(msgspec.Struct):
    digest: str
    signs: Signs


class KnownWeights:
    """The canaries of all sets of weights found behind one name, in the order in which they were found.

    Each canary is stored as an answer. The key of this answer is made of the canary's prompts and number.
    """

    def __init__(self, answers: Answers, model: Model, digest: str) -> None:
        """Take the cache, the model that makes the canary calls, and a present or earlier digest of this model."""
        self._answers = answers
        self._name = model.name
        self._plain = listed(digest)
        self._keys = RequestKeys(model, self._plain)

    def all(self) -> dict[str, Signs]:
        """Return the canary of each known set of weights, by digest."""
        known: dict[str, Signs] = {}
        for number in range(MOST):
            reply = self._answers.get([key := self._key(number)]).get(key)
            if reply is None:
                break
            row = msgspec.json.decode(reply.text, type=_Row)
            known[row.digest] = row.signs
        return known

    def add(self, signs: Signs, digest: str) -> None:
        """Store the canary of a set of weights under the digest of these weights."""
        row = Reply(text=msgspec.json.encode(_Row(digest, signs)).decode())
        self._answers.put({self._key(len(self.all())): row}, self._name)

    def digest_of(self, signs: Signs) -> str:
        """Return the digest of the weights with this canary; if the canary matches no known weights, store it."""
        distances = {digest: Distance.between(known, signs) for digest, known in self.all().items()}
        near = {digest: away for digest, away in distances.items() if away.verdict is not Verdict.OTHER}
        if near:
            return min(near, key=lambda digest: near[digest].order)
        digest = f"{self._plain}{MARK}{short_of(signs)}" if distances else self._plain
        self.add(signs, digest)
        return digest

    def _key(self, number: int) -> str:
        return self._keys.key(_MESSAGES, number)
