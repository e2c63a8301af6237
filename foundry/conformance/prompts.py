"""Checks of prompts: each accepts every question of its world, and is deterministic."""

from collections.abc import Iterator, Sequence
from copy import deepcopy
from typing import Any

from jinja2 import meta, nodes

from foundry.conformance.playing import WorldCase, require
from foundry.prompts.prompt import environment_of


def has_every_kind(case: WorldCase) -> None:
    """There is a template for every kind of question in the world."""
    prompt, kinds = case.make_prompt(), case.scenario.kinds
    missing = [kind for kind in kinds if kind not in prompt.kinds]
    lacks = f"prompt '{prompt.name}' has no template for {', '.join(missing)}"
    require(not missing, f"{lacks}, which {case.scenario.name} asks: add one, or choose another prompt")


def fills_every_question(case: WorldCase) -> None:
    """A prompt can be made for every question of an episode: templates use only names in the observation."""
    prompt = case.make_prompt()
    for question in case.put:
        for message in prompt.render(question):
            says_something = message.role != "user" or bool(message.content.strip() or message.images)
            where = f"a '{question.kind}' of step {question.step}"
            require(says_something, f"{where} gives a user message without any text")


def names_what_is_observed(case: WorldCase) -> None:
    """Every name in a template, used or not, occurs in some question of its kind."""
    observed: dict[str, set[str]] = {}
    for question in case.put:
        observed.setdefault(question.kind, set()).update(question.observation)
    for kind, known in observed.items():
        for source in _sources(case.templates.get(kind, "")):
            unknown = sorted(_named(source) - known)
            names = f"template '{kind}' uses {', '.join(unknown)}"
            require(not unknown, f"{names}, which no observation contains; it can use {', '.join(sorted(known))}")


def _sources(template: Any) -> Iterator[str]:
    if isinstance(template, str):
        yield template
    elif isinstance(template, Sequence):
        yield from (str(message["content"]) for message in template)


def _named(source: str) -> set[str]:
    """Return the names that a template looks up, except those that it only tests for existence."""
    environment = environment_of()
    tree = environment.parse(source)
    names = {
        one.node.name for one in tree.find_all(nodes.Test) if one.name == "defined" and isinstance(one.node, nodes.Name)
    }
    return set(meta.find_undeclared_variables(tree)) - names - set(environment.globals)


def is_the_same_every_time(case: WorldCase) -> None:
    """Equal questions give equal messages, even from a copy of the prompt; questions are not changed."""
    prompt, copy = case.make_prompt(), case.make_prompt()
    for question in case.put:
        before = deepcopy(dict(question.observation))
        require(
            prompt.render(question) == prompt.render(question) == copy.render(question),
            f"a second prompt for a '{question.kind}' differs: templates may only depend on the observation",
        )
        require(
            dict(question.observation) == before, f"filling in the question '{question.kind}' changes the observation"
        )


def shows_the_images(case: WorldCase) -> None:
    """The prompt includes the images of the observation."""
    prompt = case.make_prompt()
    for question in case.put:
        sent = [image for message in prompt.render(question) for image in message.images]
        has = f"a '{question.kind}' has {len(question.images)} images"
        require(sent == list(question.images), f"{has}, but {len(sent)} are sent")
