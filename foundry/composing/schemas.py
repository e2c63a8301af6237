"""What a schema lets a model decide must be something that its world reads."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from foundry.errors import InputError
from foundry.records import Outcome
from foundry.worlds.base import Answer, Question, Scenario

_EXAMPLES = {"string": "", "integer": 0, "number": 0, "boolean": False}


def check_schemas(model: Mapping[str, Any], scenario: Scenario, questions: Sequence[Question]) -> None:
    """Refuse a schema that offers choices which its world does not read, beside some that it does.

    Args:
        model: the configuration of a model, or of a population with its members.
        scenario: the world.
        questions: its first question of every kind.

    Raises:
        InputError: it does; names the choices and how to leave them out.
    """
    if type(scenario).read is Scenario.read:
        return
    held = [(schemas[asked.kind], asked) for schemas in _schemas(model) for asked in questions if asked.kind in schemas]
    for schema, question in held:
        for name, choices in _choices(schema):
            read = [one for one in choices if _is_read({**_example(schema), name: one}, scenario, question)]
            if read and len(read) < len(choices):
                others = ", ".join(str(one) for one in choices if one not in read)
                raise InputError(
                    f"The schema of questions of kind '{question.kind}' lets a model decide {others}, which world "
                    f"'{scenario.name}' does not read as it is set. Give "
                    f"schema.{question.kind}.properties.{name}.enum=[{','.join(map(str, read))}], or model.format=null."
                )


def _schemas(model: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield the schemas, by kind of question, that a model's replies are held to, or those of its members."""
    if model.get("format") == "schema":
        yield model.get("schemas") or {}
    for member in model.values():
        if isinstance(member, Mapping):
            yield from _schemas(member)


def _choices(schema: Mapping[str, Any]) -> Iterator[tuple[str, Sequence[Any]]]:
    for name, described in schema.get("properties", {}).items():
        if described.get("enum"):
            yield name, described["enum"]


def _example(schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return a reply as the schema asks for it: of each property the first choice, or the least there is."""
    return {
        name: described["enum"][0]
        if described.get("enum")
        else described.get("minimum", _EXAMPLES.get(str(described.get("type"))))
        for name, described in schema.get("properties", {}).items()
    }


def _is_read(reply: Mapping[str, Any], scenario: Scenario, question: Question) -> bool:
    return scenario.read(question, Answer(json.dumps(reply))).outcome is not Outcome.UNREADABLE
