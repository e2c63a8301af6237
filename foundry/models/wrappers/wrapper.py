"""The base class of models that wrap another model."""

from typing import Any

from foundry.models.base import Model


def _passed_on(name: str) -> Any:
    return property(lambda wrapper: getattr(wrapper.inner, name))


class Wrapper(Model):
    """Passes everything but `ask` on to the wrapped model."""

    parameters = _passed_on("parameters")
    kinds = _passed_on("kinds")
    longest_reply = _passed_on("longest_reply")
    context_length = _passed_on("context_length")
    next_served = _passed_on("next_served")
    inspect = _passed_on("inspect")
    canaries = _passed_on("canaries")
    confirm = _passed_on("confirm")
    warm_up = _passed_on("warm_up")
    unload = _passed_on("unload")
    close = _passed_on("close")

    def __init__(self, inner: Model) -> None:
        self.inner = inner
        self.name = inner.name
        self.costs = inner.costs
