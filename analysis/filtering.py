"""Selects the runs of an analysis by their settings."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from analysis.measuring.runs import RunResult
from analysis.tables.signature_table import factor_value, setting
from foundry.errors import InputError, not_found
from foundry.storing.store import Condition, expand_ranges, write_atomically

FILTER_FILE = "filter.json"
_KNOWN = ("world", "model", "prompt", "seed", "sampling_seed")
_NOT_OF_BASELINES = ("prompt", "sampling_seed")
"""Settings by which baselines are not filtered, because scripted policies ignore these settings."""


@dataclass(frozen=True)
class Filter:
    """A selection of runs.

    A run is selected if, for every key in `only`, it has one of the values, and for no key in `without` it has one. A
    key is `world`, `model`, `prompt`, `seed`, `sampling_seed` or the path of a setting, such as `world.steps`. Filters
    on models, prompts and sampling seeds do not exclude baselines, unless `without` names a baseline as model.
    """

    only: Mapping[str, Sequence[str]]
    without: Mapping[str, Sequence[str]]

    @classmethod
    def of(cls, only: Iterable[str] = (), without: Iterable[str] = ()) -> "Filter":
        """Return the filter from texts of the form KEY=VALUE[,VALUE...]; seeds may be ranges, such as 0-9.

        Raises:
            InputError: a text does not have this form.
        """
        return cls(_read("--only", only), _read("--without", without))

    def __bool__(self) -> bool:
        return bool(self.only or self.without)

    def __str__(self) -> str:
        kinds = {"only": self.only, "without": self.without}
        return "; ".join(
            f"{name} {key}={','.join(values)}" for name, chosen in kinds.items() for key, values in chosen.items()
        )

    def check(self, conditions: Sequence[Condition]) -> None:
        """Raise an InputError if no condition has a key or a value of the filter."""
        for key, asked in (*self.only.items(), *self.without.items()):
            values = {value_text(value) for condition in conditions for value in _values(condition, key)}
            if not any(condition.factors.get(key, "") is None for condition in conditions):
                values.discard("null")  # value of settings that a world lacks
            if not values and key != "sampling_seed":
                names = (*_KNOWN, *(name for condition in conditions for name in condition.factors))
                raise not_found("Setting", key, names, "Other settings are named by paths, such as world.steps.")
            for value in asked:
                if value not in values:
                    raise not_found(key if "." in key else key.capitalize(), value, values)

    def taken(self, results: Sequence[RunResult]) -> list[RunResult]:
        """Return the selected runs, or raise an InputError if none is left."""
        chosen = [result for result in results if self.takes(result)]
        if all(result.baseline for result in chosen):
            raise InputError(f"The filter '{self}' leaves none of {len(results)} runs: remove a part of it.")
        return chosen

    def takes(self, run: RunResult) -> bool:
        """Return whether a run is selected."""
        ours: Callable[[str], bool] = (lambda key: key not in _NOT_OF_BASELINES) if run.baseline else (lambda key: True)
        only = {key: asked for key, asked in self.only.items() if ours(key) and not (run.baseline and key == "model")}
        without = {key: asked for key, asked in self.without.items() if ours(key)}
        return all(value_text(factor_value(run, key)) in asked for key, asked in only.items()) and not any(
            value_text(factor_value(run, key)) in asked for key, asked in without.items()
        )

    def write(self, folder: Path, taken: int, of: int, things: str = "runs") -> None:
        """Write the filter and the number of selected runs or answers to a file; without a filter, remove this file."""
        file = folder / FILTER_FILE
        if self:
            content = {"only": self.only, "without": self.without, things: taken, "of": of}
            write_atomically(file, msgspec.json.format(msgspec.json.encode(content), indent=1) + b"\n")
        else:
            file.unlink(missing_ok=True)


def _read(option: str, texts: Iterable[str]) -> dict[str, tuple[str, ...]]:
    by_key: dict[str, tuple[str, ...]] = {}
    for text in texts:
        key, _, values = expand_ranges(text).partition("=")
        if not key or not values:
            raise InputError(f"{option} {text} does not have the form KEY=VALUE, such as model=llama3.2 or seed=0-9")
        by_key[key] = (*by_key.get(key, ()), *values.split(","))
    return by_key


def _values(condition: Condition, key: str) -> Sequence[Any]:
    return condition.seeds if key == "seed" else (setting(condition.factors, condition.config, key),)


def value_text(value: object) -> str:
    """Return the value of a setting as filters write it."""
    return value if isinstance(value, str) else msgspec.json.encode(value).decode()
