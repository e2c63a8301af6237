"""Overrides over the configuration of a recorded run, in place of the shipped one."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from foundry.composing.compose import Composed, compose
from foundry.composing.defaults import Defaults
from foundry.errors import RecordError
from foundry.expansion import FORMAT, overridden
from foundry.storing.sweep_file import to_yaml

GROUPS = ("world", "model", "prompt")
SINGLE = ("seed", "sampling_seed", "baselines")
"""Recorded settings that belong to no group."""
_AS_RECORDED = "as_recorded"
"""The option of a group that is a run's own configuration."""
_INTERPOLATION = re.compile(r"(\\*)\$\{")


def compose_recorded(
    config: Mapping[str, Any], overrides: Sequence[str], defaults: Defaults | None = None
) -> Composed | None:
    """Compose overrides over a run's own configuration, with its seed.

    Args:
        config: the run's effective configuration; its seed holds where no override has one.
        overrides: as `foundry` takes them.
        defaults: the user's own; none of them changes what was recorded.

    Returns:
        What was composed, or None when Hydra answered a flag of its own.

    Raises:
        InputError: an override cannot be read.
        RecordError: the recorded configuration has a key that would be read as more than a setting.
    """
    given = overridden(overrides)
    for group in GROUPS:
        if "defaults" in config[group]:  # would be read as names of further files
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
        return compose([*overrides, *own], defaults, [Path(name)])


def without_format(part: Mapping[str, Any], group: str, given: set[str]) -> Mapping[str, Any]:
    """Return a recorded part; a prompt without its format where another is asked for, in whose place that stands."""
    is_replaced = group == "prompt" and FORMAT in given
    return {key: value for key, value in part.items() if key != FORMAT or not is_replaced}


def _literal(value: Any) -> Any:
    """Return settings in which `${` stands for itself: they are resolved already, or recorded by someone else."""
    if isinstance(value, str):
        return _INTERPOLATION.sub(lambda found: 2 * found[1] + r"\${", value)
    if isinstance(value, Mapping):
        return {key: _literal(inner) for key, inner in value.items()}
    return [_literal(inner) for inner in value] if isinstance(value, list | tuple) else value
