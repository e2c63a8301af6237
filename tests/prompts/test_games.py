"""Prompts of games and of grids with further parts say what holds in the world as it is set, and nothing else."""

from functools import lru_cache
from typing import Any

import pytest
import yaml

from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.models.base import ChatMessage
from foundry.paths import conf_dir
from foundry.worlds.base import Answer

OURS = ("message", "action", "move", "nearer", "side", "count", "order", "distance")
"""The kinds of question of the worlds with space, whose prompts have tests of their own."""


@lru_cache
def told(*overrides: str, rounds: int = 0) -> str:
    """Return what the first agent is told when it is asked after so many silent answers of all."""
    composed = compose([*overrides, "model=scripted/random"])
    config: dict[str, Any] = dict(composed.conditions[0].config)
    world = scenario_of(config).start(0)
    for _ in range(rounds):
        world.advance([Answer("")] * len(world.pending()))
    messages: tuple[ChatMessage, ...] = prompt_of(config).render(world.pending()[0])
    return "\n".join(message.content for message in messages)


@pytest.mark.parametrize(("prompt", "anew", "kept", "punish"), [
    ("public_goods", "each has 20 tokens anew", "what you have in the next round", "costs 1 tokens and takes 3"),
    ("public_goods_japanese", "全員が新たに20枚", "次のラウンドの持ち分", "罰するには1枚かかり、相手は3枚を失います"),
])  # fmt: skip
def test_who_gives_knows_whether_tokens_come_anew_and_whether_punishment_follows(
    prompt: str, anew: str, kept: str, punish: str
):
    plain = told("world=public_goods", f"prompt={prompt}")
    assert anew in plain and kept not in plain and punish not in plain
    carried = told("world=public_goods_punishment", f"prompt={prompt}", "world.reset=false")
    assert kept in carried and anew not in carried and punish in carried


@pytest.mark.parametrize(
    ("prompt", "nobody"), [("public_goods", "punish nobody"), ("public_goods_japanese", "足りない")]
)
def test_who_cannot_pay_for_punishment_is_told_so(prompt: str, nobody: str):
    asked = ("world=public_goods_punishment", f"prompt={prompt}")
    assert nobody in told(*asked, "world.cost=50", rounds=1) and nobody not in told(*asked, rounds=1)
    assert 'agent 1"' not in told(*asked, "world.cost=50", rounds=1)


@pytest.mark.parametrize("prompt", ["survival", "survival_japanese"])
def test_deeds_that_a_world_has_not_are_not_offered(prompt: str):
    asked = ("world=survival", f"prompt={prompt}", "world.agents=2")
    everything = told(*asked, rounds=1)
    assert all(f'- "{deed}"' in everything for deed in ("gather", "share", "attack", "reproduce"))
    less = told(*asked, "world.attack=null", "world.sharing=false", "world.reproduction=null", rounds=1)
    assert '- "gather"' in less
    assert not any(word in less for word in ("share", "attack", "reproduce", '"target"', '"amount"'))


@pytest.mark.parametrize(("prompt", "first"), [("naming", "your first meeting"), ("naming_japanese", "最初の出会い")])
def test_only_the_first_meeting_is_said_to_be_the_first(prompt: str, first: str):
    asked = ("world=naming", f"prompt={prompt}", "world.memory=0", "world.agents=2")
    assert first in told(*asked) and first not in told(*asked, rounds=1)


@pytest.mark.parametrize("prompt", ["cliff_walking", "cliff_walking_japanese"])
def test_a_slippery_cliff_is_said_to_be_slippery(prompt: str):
    pytest.importorskip("gymnasium")
    asked = ("world=cliff_walking", f"prompt={prompt}")
    words = ("slippery", "滑り")
    assert not any(word in told(*asked) for word in words)
    assert any(word in told(*asked, "world.settings.is_slippery=true") for word in words)


def test_whoever_has_a_persona_in_a_game_is_told_it():
    files = (conf_dir() / "prompt").glob("*.yaml")
    games = {path.stem: yaml.safe_load(path.read_text("utf-8"))["templates"] for path in files}
    asked = {(name, kind): text for name, kinds in games.items() for kind, text in kinds.items() if kind not in OURS}
    assert asked and [one for one, text in asked.items() if "persona" not in text] == []
