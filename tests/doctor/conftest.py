"""Configurations as Hydra composes them."""

from __future__ import annotations

from typing import Any

import pytest

from foundry.composing.compose import compose


@pytest.fixture
def grid_config() -> dict[str, Any]:
    composed = compose(["model=scripted/stay", "world.agents=4", "world.steps=40"])
    assert composed is not None
    return dict(composed.conditions[0].config)
