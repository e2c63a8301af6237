"""Plans of made-up conditions."""

from collections.abc import Sequence
from typing import Any

from analysis.planned.declaring import declared
from foundry.storing.preregistration import Part, PlannedCondition, Preregistration

MEASURES = ("idle_rate.chosen", "clustering.nni")
LOOKS = (6, 9, 12)


def condition(model: str, seeds: Sequence[int] = range(12), **factors: str) -> PlannedCondition:
    part = Part(name="p", sha256="0")
    return PlannedCondition(
        factors={"model": model, **factors},
        world=Part(name=factors.get("world", "p"), sha256="0"),
        prompt=part,
        model=Part(name=model, sha256="0"),
        runs={f"{model}{seed}": seed for seed in seeds},
    )


def plan(compared: str = "ab", **changes: Any) -> Preregistration:
    usual: dict[str, Any] = {"family": MEASURES, "margins": {}, "looks": LOOKS}
    said: dict[str, Any] = {"foundry": "0", "commit": None, "asked": [], "models": [], "answers_known": 0}
    return declared([condition(model) for model in compared], ["grid"] * len(compared), **{**usual, **said, **changes})
