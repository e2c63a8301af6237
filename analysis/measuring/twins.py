"""Compares a run with its twin, which differs only in one setting of the world, such as fires that burn or not."""

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from analysis.form import Twin, form_of
from analysis.measuring.runs import RunResult, Values
from analysis.signatures import READABLE_SUFFIX

_IDENTITY = ("world", "prompt", "model", "sampling_seed", "seed", "fork")
"""The parts of a configuration that define a run."""


def beyond_twins(results: Sequence[RunResult]) -> list[RunResult]:
    """Add to each run that has a twin the differences from its twin, in the measures that the form's `Twin` names.

    A twin is also compared with itself, so its differences are 0.
    """
    pairs = [(form_of(result.form).twin, result) for result in results]
    twins = {_pair(twin, result): result for twin, result in pairs if twin is not None and not _is_told(twin, result)}
    held = {_pair(twin, result) for twin, result in pairs if twin is not None and _is_told(twin, result)}
    return [
        result
        if twin is None or (pair := _pair(twin, result)) not in twins or pair not in held
        else replace(result, measures=_differences(twin, result.measures, twins[pair].measures))
        for twin, result in pairs
    ]


def _is_told(twin: Twin, result: RunResult) -> bool:
    return bool(result.config["world"].get(twin.setting, twin.told) == twin.told)


def _pair(twin: Twin, result: RunResult) -> str:
    parts: dict[str, Any] = {key: result.config.get(key) for key in _IDENTITY}
    parts["world"] = {key: value for key, value in parts["world"].items() if key != twin.setting}
    parts["model"] = {key: value for key, value in parts["model"].items() if key != "server"}
    return json.dumps(parts, sort_keys=True, default=str)


def _differences(twin: Twin, own: Values, others: Values) -> Values:
    beyond = {
        f"{difference}{suffix}": own[f"{measure}{suffix}"] - others[f"{measure}{suffix}"]
        for measure, difference in twin.measures.items()
        for suffix in ("", READABLE_SUFFIX)
        if f"{measure}{suffix}" in own and f"{measure}{suffix}" in others
    }
    return Values({**own, **beyond})
