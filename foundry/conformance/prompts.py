"""What every prompt variant must hold: it asks every question of its world, the same way every time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from jinja2 import meta, nodes

from foundry.conformance.finding import require
from foundry.conformance.playing import WorldCase
from foundry.prompts.environment import environment_of
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question


@dataclass(frozen=True)
class PromptCase:
    """A prompt to be checked.

    Attributes:
        make: builds it anew.
        templates: its templates as they are written, by kind of question.
        world: the world whose questions it puts.
    """

    make: Callable[[], Prompt]
    templates: Mapping[str, Any]
    world: WorldCase

    @property
    def questions(self) -> Sequence[Question]:
        """The questions of an episode with usual replies, and of one with replies that hold no text."""
        return (*self.world.usual.questions, *self.world.silent.questions)


def has_every_kind(case: PromptCase) -> None:
    """There is a template for every kind of question that the world asks."""
    prompt, kinds = case.make(), case.world.scenario.kinds
    missing = [kind for kind in kinds if kind not in prompt.kinds]
    require(not missing, f"it has no template for {', '.join(missing)}, which {case.world.scenario.name} asks: add one")


def fills_every_question(case: PromptCase) -> None:
    """Every question of an episode can be put: no template names what the observation does not hold."""
    prompt = case.make()
    for question in case.questions:
        for message in prompt.render(question):
            require(
                message.role != "user" or bool(message.content.strip() or message.images),
                f"a '{question.kind}' of step {question.step} gives a user message without any text",
            )


def names_what_is_observed(case: PromptCase) -> None:
    """No part of a template, used or not, names what no question of its kind tells."""
    observed: dict[str, set[str]] = {}
    for question in case.questions:
        observed.setdefault(question.kind, set()).update(question.observation)
    for kind, known in observed.items():
        for source in _sources(case.templates.get(kind, "")):
            unknown = sorted(_named(source) - known)
            require(
                not unknown,
                f"template '{kind}' names {', '.join(unknown)}, which no observation holds; there are: "
                f"{', '.join(sorted(known))}",
            )


def _sources(template: Any) -> Iterator[str]:
    if isinstance(template, str):
        yield template
    elif isinstance(template, Sequence):
        yield from (str(message["content"]) for message in template)


def _named(source: str) -> set[str]:
    """Return the names that a template looks up, without those of which it asks whether they are defined."""
    environment = environment_of()
    tree = environment.parse(source)
    asked = {
        one.node.name for one in tree.find_all(nodes.Test) if one.name == "defined" and isinstance(one.node, nodes.Name)
    }
    return set(meta.find_undeclared_variables(tree)) - asked - set(environment.globals)


def is_the_same_every_time(case: PromptCase) -> None:
    """Equal questions give equal messages, from a copy too, and a question stays as it is."""
    one, other = case.make(), case.make()
    for question in case.questions:
        before = deepcopy(dict(question.observation))
        first = one.render(question)
        require(
            first == one.render(question) == other.render(question),
            f"a '{question.kind}' is put another way the second time: let a template depend on the observation alone",
        )
        require(dict(question.observation) == before, f"filling '{question.kind}' changes the observation")


def shows_the_images(case: PromptCase) -> None:
    """What an agent sees is sent with the prompt."""
    prompt = case.make()
    for question in case.questions:
        sent = [image for message in prompt.render(question) for image in message.images]
        require(
            sent == list(question.images),
            f"a '{question.kind}' has {len(question.images)} images, {len(sent)} are sent",
        )


CHECKS = (has_every_kind, fills_every_question, names_what_is_observed, is_the_same_every_time, shows_the_images)
