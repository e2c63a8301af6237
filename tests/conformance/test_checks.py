"""Every check sees what it is there for, and passes a part that holds its rule."""

import itertools
from typing import Any

import pytest

from conformance import broken_models, broken_signatures, coins
from conformance.coins import PROMPT, Coins, question_with, with_world
from foundry.conformance.checking import CHECKS
from foundry.conformance.playing import Finding, Status, WorldCase, look, name_of
from foundry.models.base import ChatMessage
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question

SCHEMAS = {"call": {"type": "object"}}


def world(make: type[Coins] = Coins, asked_by: Prompt = PROMPT, schemas: Any = SCHEMAS) -> WorldCase:
    return WorldCase(make, lambda: asked_by, schemas=schemas)


TEMPLATES = {"call": "Agent {{ agent }}, it showed {{ shown }}.{% if mood is defined %} {{ mood }}{% endif %}"}
NUMBERS = itertools.count()
SHOWING = with_world("Showing", question=question_with(images=(b"\x89PNG",)))


class Numbered(Prompt):
    """Renders a question otherwise each time."""

    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        (message,) = super().render(question)
        return (ChatMessage("user", f"{message.content} {next(NUMBERS)}", message.images),)


class Blind(Prompt):
    """Sends no images."""

    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        return (ChatMessage("user", "Call."),)


def prompt(templates: dict[str, Any], kind: type[Prompt] = Prompt, asking: type[Coins] = Coins) -> WorldCase:
    return WorldCase(asking, lambda: kind("own", templates), templates)


SOUND = {
    "world": world(),
    "model": broken_models.SOUND,
    "prompt": prompt(TEMPLATES),
    "signature": broken_signatures.SOUND,
}
BROKEN = {
    "world": [
        *((world(make), name, words) for make, name, words in coins.BROKEN),
        (world(asked_by=Prompt("other", {"shout": "?"})), "has a template for every question", "no template for call"),
        (world(asked_by=Prompt("wrong", {"call": "{{ coin }}"})), "has a template for every question", "coin"),
        (world(schemas={}), "has a schema for every question", "no schema for 'call'"),
        (world(schemas={"call": {}}), "has a schema for every question", "has no `type`"),
    ],
    "model": broken_models.BROKEN,
    "prompt": [
        (prompt({"shout": "?"}), "has every kind", "no template for call"),
        (prompt({"call": "{{ agnet }}"}), "fills every question", "Did you mean 'agent'?"),
        (prompt({"call": " "}), "fills every question", "an empty user message"),
        (prompt({"call": "{% if agent > 99 %}{{ coin }}{% endif %}"}), "names what is observed", "uses coin"),
        (prompt(TEMPLATES, Numbered), "is the same every time", "the second time"),
        (prompt(TEMPLATES, Blind, SHOWING), "shows the images", "the messages contain 0"),
    ],
    "signature": broken_signatures.BROKEN,
}
"""By the kind of part: a case, the check that must see what is wrong with it, and words of the note."""


def looked(kind: str, name: str, case: Any) -> Finding:
    return look("own", next(check for check in CHECKS[kind] if name_of(check) == name), case)


@pytest.mark.parametrize(("kind", "name"), [(kind, name_of(check)) for kind in SOUND for check in CHECKS[kind]])
def test_a_sound_part_passes(kind: str, name: str):
    finding = looked(kind, name, SOUND[kind])
    assert (finding.status, finding.note) == (Status.PASSED, "")


@pytest.mark.parametrize(("kind", "place"), [(kind, place) for kind in BROKEN for place in range(len(BROKEN[kind]))])
def test_a_part_that_breaks_a_rule_fails_the_check_of_that_rule(kind: str, place: int):
    case, name, words = BROKEN[kind][place]
    finding = looked(kind, name, case)
    assert finding.status is Status.FAILED and words in finding.note, finding
    assert "\n" not in finding.note


@pytest.mark.parametrize("kind", BROKEN)
def test_every_check_is_seen_to_fail(kind: str):
    never = {"follows its seed"} if kind == "world" else set()
    assert {name_of(check) for check in CHECKS[kind]} - {name for _, name, _ in BROKEN[kind]} == never


def test_a_world_that_ignores_its_seed_passes_and_is_told_so():
    same = {"start": lambda self, seed: self.world(self, 0), "personas": lambda self, seed: [{}] * 3}
    finding = looked("world", "follows its seed", world(type("Same", (Coins,), same)))
    assert finding.status is Status.PASSED and "every seed gives the same episode" in finding.note


def test_a_model_that_costs_something_is_asked_nothing():
    paid = broken_models.case(broken_models.Paid)
    findings = [look("model own", check, paid) for check in CHECKS["model"]]
    assert [finding.check for finding in findings if finding.status is Status.SKIPPED] == [
        "answers the same", "leaves the observation as it is", "refuses other kinds",
    ]  # fmt: skip
    assert not [finding for finding in findings if finding.status is Status.FAILED]


def test_a_signature_of_another_form_is_tried_on_nothing():
    finding = looked("signature", "measures what it describes", broken_signatures.FOREIGN)
    assert finding.status is Status.SKIPPED and "Other" in finding.note
