"""Checks of prompts: a prompt accepts every question of its world, and is deterministic."""

from collections.abc import Iterator, Sequence
from copy import deepcopy
from typing import Any

from jinja2 import meta, nodes

from foundry.conformance.playing import WorldCase, require
from foundry.prompts.prompt import environment_of


def has_every_kind(case: WorldCase) -> None:
    """The prompt has a template for every kind of question that the world asks."""
    prompt, kinds = case.make_prompt(), case.scenario.kinds
    missing = [kind for kind in kinds if kind not in prompt.kinds]
    require(
        not missing,
        f"prompt '{prompt.name}' has no template for {', '.join(missing)}, which world '{case.scenario.name}' asks: "
        "add a template, or choose another prompt",
    )


def fills_every_question(case: WorldCase) -> None:
    """Templates use only names that are in the observation, in every question of an episode."""
    prompt = case.make_prompt()
    for question in case.put:
        for message in prompt.render(question):
            says_something = message.role != "user" or bool(message.content.strip() or message.images)
            require(
                says_something,
                f"a '{question.kind}' question of step {question.step} gives an empty user message: add text to its "
                "template",
            )


def names_what_is_observed(case: WorldCase) -> None:
    """A template uses only keys of its observations, even in branches that no question takes."""
    observed: dict[str, set[str]] = {}
    for question in case.put:
        observed.setdefault(question.kind, set()).update(question.observation)
    for kind, known in observed.items():
        for source in _sources(case.templates.get(kind, "")):
            unknown = sorted(_named(source) - known)
            require(
                not unknown,
                f"template '{kind}' uses {', '.join(unknown)}, which no observation contains: use only "
                f"{', '.join(sorted(known))}",
            )


def _sources(template: Any) -> Iterator[str]:
    if isinstance(template, str):
        yield template
    elif isinstance(template, Sequence):
        yield from (str(message["content"]) for message in template)


def _named(source: str) -> set[str]:
    """Return the variables that a template uses, except variables that it tests for existence (`is defined`)."""
    environment = environment_of()
    tree = environment.parse(source)
    names = {
        test.node.name
        for test in tree.find_all(nodes.Test)
        if test.name == "defined" and isinstance(test.node, nodes.Name)
    }
    return set(meta.find_undeclared_variables(tree)) - names - set(environment.globals)


def is_the_same_every_time(case: WorldCase) -> None:
    """Equal questions give equal messages, even from a copy of the prompt; the prompt does not change questions."""
    prompt, copy = case.make_prompt(), case.make_prompt()
    for question in case.put:
        before = deepcopy(dict(question.observation))
        require(
            prompt.render(question) == prompt.render(question) == copy.render(question),
            f"a '{question.kind}' question gives other messages the second time: let templates depend only on the "
            "observation",
        )
        require(
            dict(question.observation) == before,
            f"template '{question.kind}' changes the observation: templates must only read it",
        )


def shows_the_images(case: WorldCase) -> None:
    """The messages contain all images of a question, in order."""
    prompt = case.make_prompt()
    for question in case.put:
        sent = [image for message in prompt.render(question) for image in message.images]
        require(
            sent == list(question.images),
            f"a '{question.kind}' question has {len(question.images)} images, but the messages contain {len(sent)}: "
            "show all images, in order",
        )
