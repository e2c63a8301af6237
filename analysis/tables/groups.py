"""Groups the runs that differ only in their seeds."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from analysis.measuring.runs import RunResult
from analysis.tables.signature_table import ANY_PROMPT, SignatureTable
from foundry.storing.store import leaves, without_servers

PARTS = ("world", "model", "prompt")
"""The named parts of a configuration."""

SCHEMAS = "schemas"
"""Name of the setting of a model that contains the schemas of its replies."""

NOT_SET = "none"
"""The text for a swept setting that is null, or that a world lacks."""

_MOST_SHOWN = 40
"""Maximum number of characters of the settings after a name; a hash replaces longer texts."""


def group_columns(results: Sequence[RunResult], table: SignatureTable) -> pd.DataFrame:
    """Return the columns that define groups, one row per run of the table.

    `model` is always included; `world`, `prompt` and other swept settings are included if runs differ in them. If two
    worlds, models or prompts have the same name but different settings, these settings follow the name, unless a swept
    setting already distinguishes them. A world adds the schemas of its replies to the settings of models, but schemas
    distinguish models only within a world.
    """
    frame = _as_texts(table.frame[["model", "world", "prompt", *_factors(table)]])
    worlds = frame["world"].copy()
    for part in PARTS:
        # Uses only its own name and swept settings: two models in different worlds of one name must not look
        # comparable.
        keys = list(frame[[part, *_factors(table)]].itertuples(index=False, name=None))
        # Runs of one condition share their parts, so each part is processed once.
        shared = {id(result.config[part]): result.config[part] for result in results}
        settings = {known: _settings(config) for known, config in shared.items()}
        configs = [
            {} if part == "prompt" and result.baseline and name == ANY_PROMPT else settings[id(result.config[part])]
            for name, result in zip(frame[part], results, strict=True)
        ]
        own, brought = zip(*map(_split, configs), strict=True)
        names = _distinct_names(frame[part].tolist(), own, keys)
        frame[part] = _distinct_names(names, brought, list(zip(names, keys, worlds, strict=True)))
    return frame[["model", *(name for name in frame.columns[1:] if frame[name].nunique() > 1)]]


def swept_columns(table: SignatureTable) -> pd.DataFrame:
    """Return the columns that define groups.

    Only the table is read, so worlds, models or prompts with equal names count as equal.
    """
    frame = _as_texts(table.frame[["model", "world", "prompt", *_factors(table)]])
    return frame[["model", *(name for name in frame.columns[1:] if frame[name].nunique() > 1)]]


def group_keys(groups: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return the group of each row, given the columns that define groups."""
    return list(_as_texts(groups).itertuples(index=False, name=None))


def _as_texts(frame: pd.DataFrame) -> pd.DataFrame:
    # astype(str) keeps missing values, and a missing label equals nothing, not even itself.
    return frame.astype(object).where(frame.notna(), NOT_SET).astype(str)


def _factors(table: SignatureTable) -> list[str]:
    return [key for key in table.factors if key != "sampling_seed"]


def _settings(config: Mapping[str, Any]) -> dict[str, str]:
    return dict(leaves({key: value for key, value in without_servers(config).items() if key != "name"}))


def _split(settings: dict[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """Split the settings of a part into its own settings, and the schemas of replies, which a world adds."""
    brought = {path: value for path, value in settings.items() if SCHEMAS in path.split(".")}
    return {path: value for path, value in settings.items() if path not in brought}, brought


def _distinct_names(
    names: Sequence[str], configs: Sequence[dict[str, str]], keys: Sequence[tuple[Any, ...]]
) -> list[str]:
    """Return the names; if equal names stand for different settings, these settings follow the name."""
    first = {key: config for key, config in reversed(list(zip(keys, configs, strict=True)))}
    hiding = {name for name, config, key in zip(names, configs, keys, strict=True) if config != first[key]}
    variants: dict[str, list[dict[str, str]]] = {name: [] for name in hiding}
    for name, config in zip(names, configs, strict=True):
        if name in hiding and config not in variants[name]:
            variants[name].append(config)
    return [
        f"{name} {_difference(config, variants[name])}" if name in hiding else name
        for name, config in zip(names, configs, strict=True)
    ]


def _difference(config: dict[str, str], variants: Sequence[dict[str, str]]) -> str:
    paths = dict.fromkeys(path for variant in variants for path in variant)
    differing = [path for path in paths if len({variant.get(path) for variant in variants}) > 1]
    text = ", ".join(f"{path}={config.get(path, 'none')}" for path in differing)
    if len(text) > _MOST_SHOWN:
        return "#" + hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()[:6]
    return f"[{text}]"
