"""Applies overrides to a recorded run that is forked or probed, or to a recorded sweep that gets more runs."""

import itertools
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from foundry.composing.compose import Composed, compose
from foundry.composing.defaults import Defaults
from foundry.composing.settings import checked_settings
from foundry.errors import InputError, RecordError
from foundry.expansion import FORMAT, Condition, overridden, settings_key
from foundry.storing.store import SweepFolder
from foundry.storing.sweep_file import to_yaml

GROUPS = ("world", "model", "prompt")
SINGLE = ("seed", "sampling_seed", "baselines")
"""Keys of a recorded configuration that overrides may change, besides world, model and prompt."""
_AS_RECORDED = "as_recorded"
"""Name of a temporary option in each configuration group; it contains the recorded world, model or prompt."""
_INTERPOLATION = re.compile(r"(\\*)\$\{")
_OF_THE_SEED = re.compile(r"\$\{[^}]*\bseed\b")
"""A reference to the seed in a setting, such as `${seed}`."""


def compose_recorded(
    config: Mapping[str, Any], overrides: Sequence[str], defaults: Defaults | None = None
) -> Composed | None:
    """Apply overrides to the recorded configuration of a run, which includes its seed.

    Returns:
        The composed command line, or None if Hydra answered one of its own flags.
    """
    given = overridden(overrides)
    for group in GROUPS:
        if "defaults" in config[group]:  # these would be read as names of further files
            raise RecordError(f"The recorded {group} is refused: no {group} has a setting 'defaults'.")
    with tempfile.TemporaryDirectory() as name:
        for group in GROUPS:
            path = Path(name) / group / f"{_AS_RECORDED}.yaml"
            path.parent.mkdir()
            path.write_text(to_yaml(_literal(without_format(config[group], group, given))), encoding="utf-8")
        single = {key: config[key] for key in SINGLE if key in config and key not in given}
        if "record.frames" not in given:
            single["record"] = {"frames": config.get("record", {}).get("frames", False)}
        path = Path(name) / _AS_RECORDED / f"{_AS_RECORDED}.yaml"
        path.parent.mkdir()
        path.write_text(f"# @package _global_\n{to_yaml(_literal(single))}", encoding="utf-8")
        own = [f"{group}={_AS_RECORDED}" for group in GROUPS if group not in given]
        own.append(f"+{_AS_RECORDED}={_AS_RECORDED}")
        defaults = defaults or Defaults()
        if "model" not in given:
            defaults = defaults.without_servers()
        return compose([*overrides, *own], defaults, [Path(name)])


def without_format(part: Mapping[str, Any], group: str, given: set[str]) -> Mapping[str, Any]:
    """Return a recorded part; if the overrides name another format, remove the recorded one from the prompt."""
    is_replaced = group == "prompt" and FORMAT in given
    return {key: value for key, value in part.items() if key != FORMAT or not is_replaced}


def _literal(value: Any) -> Any:
    """Return settings with `${` escaped, so that Hydra resolves no reference in the text of a record."""
    if isinstance(value, str):
        return _INTERPOLATION.sub(lambda match: 2 * match[1] + r"\${", value)
    if isinstance(value, Mapping):
        return {key: _literal(inner) for key, inner in value.items()}
    return [_literal(inner) for inner in value] if isinstance(value, list | tuple) else value


def compose_growth(folder: SweepFolder, overrides: Sequence[str], defaults: Defaults | None = None) -> Composed | None:
    """Compose the runs that overrides add to a recorded sweep.

    If the overrides only name seeds, every recorded condition gets these seeds. Other overrides are applied to every
    recorded condition, with its own seeds unless the overrides name seeds.

    Returns:
        The composed runs, or None if Hydra answered one of its own flags.
    """
    given = overridden(overrides)
    _check_asked(folder, given)
    sources = _sources(folder.sweep.conditions, given)
    first = _composed(next(sources), overrides, given, defaults)
    if first is None:
        return None
    changed = {re.split(r"[.@/]", key)[0] for key in given}
    if changed <= {"seed", *first.settings}:
        _check_seeds(folder)
        conditions = [replace(condition, seeds=first.conditions[0].seeds) for condition in folder.sweep.conditions]
    else:
        rest = (_composed(source, overrides, given, defaults) for source in sources)
        conditions = [
            condition for composed in (first, *rest) if composed is not None for condition in composed.conditions
        ]
    asked = {key: value for key, value in first.settings.items() if key in changed}
    settings = {**first.settings, **folder.settings, **asked, "output": {"dir": str(folder.path)}}
    asked_for = ("resume", *first.chosen, *overrides)
    return replace(first, asked=asked_for, conditions=tuple(conditions), settings=checked_settings(settings))


def _check_asked(folder: SweepFolder, given: set[str]) -> None:
    if not {key for key in given if not key.startswith("-")}:
        raise InputError(
            f"Name the runs to add, as in: foundry resume {folder.path} seed=10-19, or model=, prompt= or world="
        )
    if "output.dir" in given:
        raise InputError(f"foundry resume adds runs to '{folder.path}' itself. Leave out output.dir.")
    kinds = {"foundry probe": folder.moments_file.exists()}
    kinds["foundry fork"] = any("fork" in condition.config for condition in folder.sweep.conditions)
    for command in (name for name, holds in kinds.items() if holds):
        raise InputError(
            f"Only the command that made '{folder.path}' can add runs to it: {command} ... output.dir={folder.path}"
        )


def _sources(conditions: Sequence[Condition], given: set[str]) -> Iterator[Condition]:
    """Merge conditions that differ only in settings that the overrides replace; join their seeds."""
    alike: dict[str, list[Condition]] = {}
    for condition in conditions:
        alike.setdefault(
            settings_key({key: part for key, part in condition.config.items() if key not in given}), []
        ).append(condition)
    for group in alike.values():
        yield replace(group[0], seeds=tuple(dict.fromkeys(seed for condition in group for seed in condition.seeds)))


def _composed(
    source: Condition, overrides: Sequence[str], given: set[str], defaults: Defaults | None
) -> Composed | None:
    seeds = [] if "seed" in given else [f"seed={','.join(map(str, source.seeds))}"]
    return compose_recorded(source.config, ["-m", *overrides, *seeds], defaults)


def _check_seeds(folder: SweepFolder) -> None:
    """Reject more seeds if a recorded setting depends on the seed; the record has no values for new seeds."""
    alike: dict[str, list[set[int]]] = {}
    for condition in folder.sweep.conditions:
        names: Mapping[str, Any] = {role: condition.config[role]["name"] for role in ("world", "model", "prompt")}
        alike.setdefault(settings_key({**names, **condition.factors}), []).append(set(condition.seeds))
    apart = (len(seeds_each) > 1 and _are_apart(seeds_each) for seeds_each in alike.values())
    if _OF_THE_SEED.search(folder.multirun()) or any(apart):
        raise InputError(
            f"Settings in '{folder.path}' depend on the seed, and foundry does not know their values for new seeds. "
            f"Repeat the command that made this sweep, with the new seeds: foundry -m ... output.dir={folder.path}"
        )


def _are_apart(sets: Sequence[set[int]]) -> bool:
    return all(seeds.isdisjoint(other) for seeds, other in itertools.combinations(sets, 2))
