"""Makes canary calls to the servers of a model, and compares the replies with those of the known weights."""

import itertools
import logging
from collections.abc import Sequence

from foundry.canary import LIKELIEST, PROMPTS, Canary, Distance, Sign, Verdict
from foundry.errors import RequestError, ServerError, TransientError
from foundry.models.answers.answers import Answers
from foundry.models.answers.known_weights import KnownWeights, Signs
from foundry.models.base import ChatMessage, Model, ModelInfo, Request
from foundry.models.serving import serving_of
from foundry.models.wrappers.retried import RetriedModel

ALL = tuple(range(len(PROMPTS)))


class CanaryAsker:
    """Asks every server of a model for its canary, without log-probabilities if a server refuses them.

    Attributes:
        calls: number of canary calls so far.
    """

    def __init__(self, model: Model) -> None:
        retry = serving_of(model).retry
        ways = [model.canary_models(likeliest).values() for likeliest in (LIKELIEST, None)]
        self._ways = [[RetriedModel(model, retry) for model in models] for models in ways if models]
        self._failed = False
        self.calls = 0

    async def ask(self, prompts: Sequence[int] = ALL) -> list[Signs]:
        """Ask every server the canary's prompts with these numbers; return the answers of each server that answered.

        A call may fail without consequence, since a canary must not end a sweep. Only overload is reported.

        Raises:
            TransientError: a server is overloaded.
        """
        while self._ways:
            try:
                replies = [tuple([await self._sign(model, prompt) for prompt in prompts]) for model in self._ways[0]]
            except (RequestError, ServerError):
                del self._ways[0]
                continue
            answered = [signs for signs in replies if any(sign.text or sign.tokens for sign in signs)]
            if not answered and not self._failed:
                self._ways.clear()
            return answered
        return []

    async def _sign(self, model: Model, prompt: int) -> Sign:
        self.calls += 1
        messages = (ChatMessage("user", PROMPTS[prompt]),)
        try:
            reply = await model.ask(Request(messages, 0, "canary", {}, 0, prompt))
        except TransientError as error:
            if error.busy or error.late:
                raise
            self._failed = True
            return Sign(text="")
        return Sign.of((reply.thinking or "") + reply.text, reply.logprobs)


class CanaryWatch:
    """Compares a model's present canary with the canary of the weights that gave the cached answers."""

    def __init__(self, model: Model, known: KnownWeights, info: ModelInfo) -> None:
        """Take a model with a canary, the known sets of weights with the model's name, and the server's facts."""
        self._name = model.name
        self._known = known
        self._digest = info.digest or ""
        self._decides = info.measured
        self._asker = CanaryAsker(model)
        self._turns = itertools.cycle(ALL)
        self._signs: Signs = ()
        self._worst: Distance | None = None

    async def change(self) -> str | None:
        """Make canary calls; return how the weights differ from those of the cached answers, or None if they are equal.

        The first time, all prompts are asked; later one prompt at a time, and all again if its answer differs. If the
        server reports a digest, a difference is only logged, and the result is None.

        Raises:
            TransientError: a server does not answer now.
        """
        prompts = ALL if self._worst is None else (next(self._turns),)
        distance = self._held(prompts, await self._asker.ask(prompts))
        if distance is not None and distance.verdict is not Verdict.SAME and prompts != ALL:
            distance = self._held(ALL, await self._asker.ask())
        if distance is None:
            return None
        if distance.verdict is Verdict.OTHER and self._decides:
            return f"the server's canary belongs to other weights than the cached answers: {distance}"
        if self._worst is None or distance.order > self._worst.order:
            self._worst = distance
            self._warn(distance)
        return None

    def record(self) -> Canary | None:
        """Return the results of the canary calls, for the record of a run; None if no server answered a canary call."""
        signs = self._reference()
        verdict, words = (None, "") if self._worst is None else (self._worst.verdict, str(self._worst))
        known = Canary(model=self._name, signs=signs, calls=self._asker.calls, verdict=verdict, distance=words)
        return known if signs else None

    def _held(self, prompts: Sequence[int], replies: Sequence[Signs]) -> Distance | None:
        if not replies:
            return None
        signs = self._reference()
        if not signs:
            self._known.add(replies[0], self._digest)
            signs = self._signs = replies[0]
        then = [signs[prompt] for prompt in prompts]
        now, distance = max(
            ((reply, Distance.between(then, reply)) for reply in replies), key=lambda pair: pair[1].order
        )
        if distance.verdict is Verdict.OTHER and len(now) == len(ALL):
            self._known.digest_of(now)  # so that the next sweep knows that this name has several sets of weights
        return distance

    def _reference(self) -> Signs:
        self._signs = self._signs or self._known.all().get(self._digest, ())
        return self._signs

    def _warn(self, distance: Distance) -> None:
        if distance.verdict is not Verdict.SAME:
            logging.getLogger("foundry").warning(
                "%s: its server's weights, flags or version differ slightly from those that gave its cached answers "
                "(canary %s: %s).",
                self._name,
                distance.verdict,
                distance,
            )


def canary_of(model: Model) -> Model | None:
    """Return a copy of the model that makes canary calls to any of its servers; None for a model without a canary."""
    return next(iter(model.canary_models(LIKELIEST).values()), None)


def watch_of(model: Model, info: ModelInfo, answers: Answers) -> CanaryWatch | None:
    """Return an object that watches the canary of a model; None if the model has no canary."""
    canary = canary_of(model)
    if canary is None or info.digest is None:
        return None
    return CanaryWatch(model, KnownWeights(answers, canary, info.digest), info)
