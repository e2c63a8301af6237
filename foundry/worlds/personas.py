"""Personas: attributes with weighted values, drawn for each agent."""

import math
from collections.abc import Mapping
from typing import TypeAlias

from numpy.random import Generator

from foundry.errors import InputError

Attributes: TypeAlias = Mapping[str, Mapping[str | int, float]]
"""The weight of each value of each attribute, as in `{age: {young: 1, old: 3}}`."""


def check_attributes(attributes: Attributes) -> None:
    """Check that weights can be converted to probabilities.

    Raises:
        InputError: this is no mapping, a weight is negative or not finite, or all weights of an attribute are 0.
    """
    shaped = isinstance(attributes, Mapping) and all(isinstance(weights, Mapping) for weights in attributes.values())
    if not shaped:
        raise InputError(f"world.personas must be a mapping such as {{age: {{young: 1, old: 3}}}}; got {attributes!r}.")
    for attribute, weights in attributes.items():
        values = list(weights.values())
        usable = all(isinstance(weight, int | float) and math.isfinite(weight) and weight >= 0 for weight in values)
        if not usable or sum(values) <= 0:
            raise InputError(
                f"world.personas.{attribute} needs weights of at least 0, and at least one above 0; got {values}."
            )


def draw_personas(attributes: Attributes, agents: int, rng: Generator) -> list[dict[str, str]]:
    """Draw a persona for each agent; attributes are drawn independently."""
    personas: list[dict[str, str]] = [{} for _ in range(agents)]
    for attribute, weights in attributes.items():
        values = [str(value) for value in weights]
        total = sum(weights.values())
        shares = [weight / total for weight in weights.values()]
        drawn = rng.choice(len(values), size=agents, p=shares).tolist()
        for persona, index in zip(personas, drawn, strict=True):
            persona[attribute] = values[index]
    return personas
