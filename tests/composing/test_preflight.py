"""A schema offers a model what its world reads, and nothing else."""

from __future__ import annotations

from typing import Any

import pytest

from foundry.composing.compose import compose
from foundry.composing.preflight import check_schemas, first_questions, scenario_of
from foundry.errors import InputError

HELD = "model.format=schema"
MIX = "model=mix/llama3.2@50%+qwen3@50%"


def checked(*overrides: str) -> None:
    composed = compose(overrides if MIX in overrides else ["model=llama3.2", *overrides])
    assert composed is not None
    config: dict[str, Any] = dict(composed.conditions[0].config)
    scenario = scenario_of(config)
    check_schemas(config["model"], scenario, tuple(first_questions(scenario, 0)))


@pytest.mark.parametrize(
    "world", ["cafe_library", "evacuation", "survival", "bar", "fishery", "public_goods_punishment"]
)
def test_the_schema_that_a_world_chooses_offers_what_it_reads(world: str):
    checked(HELD, f"world={world}")


@pytest.mark.parametrize(
    ("overrides", "offered", "left"),
    [
        ((HELD, "world=survival", "world.sharing=false"), "share", "[move,stay,gather,attack,reproduce]"),
        ((HELD, "schema=survival"), "gather, share, attack, reproduce", "[move,stay]"),
        ((MIX, "model.members.m2.model.format=schema", "schema=survival"), "gather, share, attack, reproduce", ""),
    ],
)
def test_what_is_switched_off_is_not_offered(overrides: tuple[str, ...], offered: str, left: str):
    with pytest.raises(InputError, match=f"decide {offered}, .*does not read") as refused:
        checked(*overrides)
    assert left in str(refused.value) and "\n" not in str(refused.value)


def test_a_schema_that_leaves_it_out_is_taken_and_so_is_free_text():
    checked(HELD, "world=survival", "world.sharing=false", "schema.action.properties.action.enum=[move,stay,gather]")
    checked("world=survival", "world.sharing=false")
