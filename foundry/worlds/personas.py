"""Personas: attributes with weighted values, drawn for each agent."""

import math
from collections.abc import Mapping
from typing import TypeAlias

from numpy.random import Generator

from foundry.errors import InputError

Attributes: TypeAlias = Mapping[str, Mapping[str | int, float]]
"""Weights by attribute and value."""


def check_attributes(attributes: Attributes) -> None:
    """Reject weights that cannot be converted to probabilities.

    Raises:
        InputError: the value is not a mapping, a weight is negative or not finite, or all weights of an attribute are
            0.
    """
    shaped = isinstance(attributes, Mapping) and all(isinstance(weights, Mapping) for weights in attributes.values())
    if not shaped:
        raise InputError(f"world.personas={attributes} are no personas. Write {{attribute: {{value: weight}}}}.")
    for attribute, weights in attributes.items():
        values = list(weights.values())
        usable = all(isinstance(weight, int | float) and math.isfinite(weight) and weight >= 0 for weight in values)
        if not usable or sum(values) <= 0:
            raise InputError(
                f"world.personas.{attribute} has the weights {values}. Give numbers of 0 or more, one of them above 0."
            )


def draw_personas(attributes: Attributes, agents: int, rng: Generator) -> list[dict[str, str]]:
    """Return one persona per agent; each attribute is drawn independently."""
    personas: list[dict[str, str]] = [{} for _ in range(agents)]
    for attribute, weights in attributes.items():
        values = [str(value) for value in weights]
        total = sum(weights.values())
        shares = [weight / total for weight in weights.values()]
        drawn = rng.choice(len(values), size=agents, p=shares).tolist()
        for persona, index in zip(personas, drawn, strict=True):
            persona[attribute] = values[index]
    return personas
