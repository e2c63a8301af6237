"""Builds the table of signatures: one row per run, with its settings, its status and every measure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.labelling.correcting import COPIES
from analysis.measuring.runs import Questions, RunResult

KEYS = ("run", "world", "model", "prompt", "seed", "status")
"""The first columns of the table of signatures."""

ANY_PROMPT = "any"
"""If prompts are swept, tables show this name as a baseline's prompt, because scripted policies read no prompt."""


@dataclass(frozen=True)
class SignatureTable:
    """The table of signatures, with the kinds of its columns.

    Attributes:
        frame: one row per run, in the order of the sweeps. Columns: `sweep` if there are several, KEYS, `baseline` if
            there are any, the factors, then the measures. Undefined and missing values are NaN.
        present: the measures that each run has, even if undefined; they depend on the form of its world.
        questions: the decisions for which each run's world asks; empty if unknown.
        copies: values of measures on copies with random labels, (rows, COPIES) each; NaN in rows without copies.
    """

    frame: pd.DataFrame
    factors: tuple[str, ...]
    measures: tuple[str, ...]
    present: tuple[frozenset[str], ...]
    questions: tuple[Questions, ...] = ()
    copies: Mapping[str, FloatArray] = field(default_factory=dict)


def build_table(results: Sequence[RunResult]) -> SignatureTable:
    """Return the table of the given runs."""
    factors = list(dict.fromkeys(key for result in results for key in result.factors))
    kinds = {names: frozenset(names) for names in dict.fromkeys(result.measures.names for result in results)}
    measures = _measure_columns(kinds)
    by_sweep = len({result.sweep for result in results}) > 1
    by_baseline = any(result.baseline for result in results)
    prompts = {result.keys["prompt"] for result in results if not result.baseline}
    rows = [
        {
            **({"sweep": result.sweep} if by_sweep else {}),
            **result.keys,
            **({"prompt": ANY_PROMPT} if result.baseline and len(prompts) > 1 else {}),
            **({"baseline": result.baseline} if by_baseline else {}),
            **{key: factor_value(result, key) for key in factors},
        }
        for result in results
    ]
    head = [*(["sweep"] if by_sweep else []), *KEYS, *(["baseline"] if by_baseline else [])]
    present = tuple(kinds[result.measures.names] for result in results)
    values = pd.DataFrame(_values(results, kinds, measures), columns=measures)
    known = pd.DataFrame(rows, columns=[*head, *factors])
    known = known.assign(**{key: _as_set(known[key], [row[key] for row in rows]) for key in factors})
    frame = pd.concat([known, values], axis=1)
    questions = tuple(result.questions for result in results)
    return SignatureTable(frame, tuple(factors), tuple(measures), present, questions, _copies(results))


def _copies(results: Sequence[RunResult]) -> dict[str, FloatArray]:
    names = dict.fromkeys(name for result in results for name in result.copies)
    nothing = np.full(COPIES, np.nan)
    return {name: np.array([result.copies.get(name, nothing) for result in results]) for name in names}


def _as_set(column: pd.Series[Any], settings: Sequence[Any]) -> pd.Series[Any]:
    return pd.Series(settings, index=column.index, dtype=object) if column.isna().any() else column


def _values(results: Sequence[RunResult], kinds: Iterable[tuple[str, ...]], measures: Sequence[str]) -> FloatArray:
    column = {name: index for index, name in enumerate(measures)}
    columns = {names: [column[name] for name in names] for names in kinds}
    numbers = np.full((len(results), len(measures)), np.nan)
    for row, result in zip(numbers, results, strict=True):
        row[columns[result.measures.names]] = result.measures.array
    return numbers


def _measure_columns(kinds: Iterable[tuple[str, ...]]) -> list[str]:
    """Return all measures in the order of their first appearance; measures of one signature stand together."""
    names = list(dict.fromkeys(name for names in kinds for name in names))
    order = {name: index for index, name in enumerate(dict.fromkeys(name.partition(".")[0] for name in names))}
    return sorted(names, key=lambda name: order[name.partition(".")[0]])


def factor_value(result: RunResult, key: str) -> Any:
    """Return a run's value of a swept setting; None if the run lacks the setting."""
    return setting(result.factors, result.config, key)


def setting(factors: Mapping[str, Any], config: Mapping[str, Any], key: str) -> Any:
    """Return a setting as tables show it: a model, for example, by its name; None if it does not exist."""
    value: Any = factors.get(key)
    if key not in factors:
        value = config
        for part in (key.partition("@")[2] or key).split("."):
            value = value.get(part) if isinstance(value, dict) else None
    if isinstance(value, dict):
        return value.get("name", value.get("_target_", str(value)))
    return value if isinstance(value, str | int | float | None) else str(value)
