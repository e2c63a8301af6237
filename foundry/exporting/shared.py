"""What the writers of all formats share: declared measures, words for sampling, the files they wrote."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Files:
    """What was written.

    Attributes:
        paths: the files.
        notes: what was left out, and why, one line each.
    """

    paths: tuple[Path, ...]
    notes: tuple[str, ...] = ()


_WORDS = {
    "temperature": "temperature",
    "top_p": "top_p",
    "top_k": "top_k",
    "frequency_penalty": "frequency_penalty",
    "presence_penalty": "presence_penalty",
    "stop": "stop",
    "max_tokens": "max_tokens",
    "max_completion_tokens": "max_tokens",
    "num_predict": "max_tokens",
}


def sampling(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return those parameters of a call that other tools know, by their common names.

    Args:
        parameters: `Call.parameters`; Ollama has them below `options`.
    """
    given = {**parameters, **parameters.get("options", {})}
    found = {_WORDS[name]: value for name, value in given.items() if name in _WORDS and value is not None}
    if found.get("max_tokens", 1) < 1:  # Ollama's words for no limit
        del found["max_tokens"]
    return found


@dataclass(frozen=True)
class Measured:
    """What a declared measure is.

    Attributes:
        name: `<signature>.<measure>`.
        label: a few words, with the unit where there is one.
        low: least possible value; -inf where there is none.
        high: greatest possible value; inf where there is none.
        null: what chance alone gives and whose number that is, or empty.
        better: `high` or `low` where one end is what the agents are to reach, or empty: most behaviour has none.
    """

    name: str
    label: str
    low: float
    high: float
    null: str
    better: str


@dataclass(frozen=True)
class Mean:
    """The mean of a measure over the runs of a condition, with its interval.

    Attributes:
        n: runs that have a value.
        mean: NaN without values.
        sd: standard deviation, ddof 1; NaN with fewer than two values.
        low: lower end of the 95 % interval; NaN where there is none.
        high: upper end.
        interval: how it was computed, or empty.
    """

    n: int
    mean: float
    sd: float
    low: float
    high: float
    interval: str


@dataclass(frozen=True)
class Scores:
    """The declared measures of a sweep.

    Attributes:
        measures: what they are.
        of_runs: values by run id and name; NaN where undefined, no value where the run does not have the measure.
        of_conditions: means by the condition's number in the sweep and name.
    """

    measures: tuple[Measured, ...]
    of_runs: Mapping[str, Mapping[str, float]]
    of_conditions: Mapping[int, Mapping[str, Mean]]
