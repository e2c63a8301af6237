"""Every check of worlds sees what it is there for, and the shipped worlds pass them all."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from conformance.coins import BROKEN, Coins
from foundry.conformance.checking import WORLD_CHECKS
from foundry.conformance.finding import Status, failed, look, name_of
from foundry.conformance.playing import WorldCase
from foundry.prompts.prompt import Prompt

PROMPT = Prompt("coins", {"call": "You are agent {{ agent }}. It showed {{ shown }}. Heads, tails or pass?"})
SCHEMAS = {"call": {"type": "object"}}
BY_NAME = {name_of(check): check for check in WORLD_CHECKS}


def case(make: Callable[[], Coins], **changes: object) -> WorldCase:
    return WorldCase(make, **({"prompt": PROMPT, "schemas": SCHEMAS} | changes))


@pytest.fixture(scope="module")
def sound() -> WorldCase:
    return case(Coins)


@pytest.mark.parametrize("check", WORLD_CHECKS, ids=name_of)
def test_a_sound_world_passes(check, sound: WorldCase):
    found = look("world coins", check, sound)
    assert (found.status, found.note) == (Status.PASSED, "")


@pytest.mark.parametrize(("world", "name", "words"), BROKEN, ids=[world.__name__ for world, _, _ in BROKEN])
def test_a_world_that_breaks_a_rule_fails_the_check_of_that_rule(world: type[Coins], name: str, words: str):
    found = look("world coins", BY_NAME[name], case(world))
    assert found.status is Status.FAILED and words in found.note, found
    assert "\n" not in found.note


def test_every_check_is_seen_to_fail():
    without = {"follows its seed", "has a template for every question", "has a schema for every question"}
    assert set(BY_NAME) - {name for _, name, _ in BROKEN} == without


@pytest.mark.parametrize("prompt", [None, Prompt("other", {"shout": "?"}), Prompt("wrong", {"call": "{{ coin }}"})])
def test_a_prompt_that_does_not_put_the_questions_is_seen(prompt: Prompt | None):
    found = look("world coins", BY_NAME["has a template for every question"], case(Coins, prompt=prompt))
    assert found.status is (Status.SKIPPED if prompt is None else Status.FAILED)


@pytest.mark.parametrize("schemas", [{}, {"call": {}}])
def test_a_missing_schema_is_seen(schemas: dict[str, object]):
    check = BY_NAME["has a schema for every question"]
    assert failed([look("world coins", check, case(Coins, schemas=schemas))])
    assert look("world coins", check, case(Coins, schemas=None)).status is Status.SKIPPED


def test_a_world_that_ignores_its_seed_passes_and_is_told_so():
    same = type(
        "Same", (Coins,), {"start": lambda self, seed: self.world(self, 0), "personas": lambda self, seed: [{}] * 3}
    )
    found = look("world coins", BY_NAME["follows its seed"], case(same))
    assert found.status is Status.PASSED and "every seed gives the same episode" in found.note
