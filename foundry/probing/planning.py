"""What a probe will ask, counted before anything is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from foundry.composing.preflight import scenario_of
from foundry.expansion import Condition, expand
from foundry.probing.composing import Probe
from foundry.worlds.probe.world import ProbeScenario


@dataclass(frozen=True)
class Planned:
    """What is asked with an edit.

    Attributes:
        edit: its name.
        moments: in how many moments it changes something.
        conditions: how many models, prompts and formats are asked in them.
        calls: how many calls that makes.
    """

    edit: str
    moments: int
    conditions: int
    calls: int


def planned(probe: Probe, scratch: Path) -> Sequence[Planned]:
    """Count what a probe will ask, edit by edit.

    Args:
        probe: the probe.
        scratch: a folder that holds nothing else.

    Raises:
        RecordError: its moments cannot be made again.
    """
    sweep = probe.placed(scratch, expand(probe.composed.asked, probe.composed.conditions))
    by_edit: dict[str, list[Condition]] = {}
    for condition in sweep.conditions:
        by_edit.setdefault(condition.config["world"]["edit"]["name"], []).append(condition)
    return [_planned(edit, conditions) for edit, conditions in by_edit.items()]


def _planned(edit: str, conditions: Sequence[Condition]) -> Planned:
    scenario = cast(ProbeScenario, scenario_of(conditions[0].config))
    moments = sum(scenario.count_moments(seed) for seed in conditions[0].seeds)
    return Planned(edit, moments, len(conditions), moments * len(conditions) * scenario.repeats)
