"""A prompt variant: one template per kind of question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from jinja2 import Template, TemplateSyntaxError
from msgspec import structs

from foundry.errors import InputError, not_found
from foundry.models.base import ChatMessage
from foundry.prompts.environment import RENDER_ERRORS, compiled, explain, fill
from foundry.prompts.formats import Format, unmarked
from foundry.worlds.base import Question

Source: TypeAlias = str | Sequence[Mapping[str, str]]
"""One user message, or a list of {role, content}."""

ROLES = ("system", "user", "assistant")


@dataclass(frozen=True, slots=True)
class _Part:
    role: str
    template: Template


class Prompt:
    """Turns questions into messages.

    Attributes:
        name: name of the variant.
    """

    def __init__(self, name: str, templates: Mapping[str, Source], format: Mapping[str, Any] | None = None) -> None:
        """Compile the templates.

        Args:
            name: name of the variant.
            templates: Jinja2 source by kind of question; the keys of the observation are its variables, and a
                last line break is dropped.
            format: which format of a space they are written in, as `Format.of` takes it; None: as they are.

        Raises:
            InputError: a template is none, there is no such format, or it has nothing to change in this prompt.
        """
        self.name = name
        self._format = None if format is None else Format.of(format)
        self._parts = {kind: self._compile(kind, source) for kind, source in templates.items()}

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of question it has a template for."""
        return tuple(self._parts)

    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        """Return the messages that ask this question, its images with the last user message.

        Raises:
            InputError: there is no template for this kind of question, or it cannot be filled.
        """
        parts = self._parts.get(question.kind)
        if parts is None:
            raise not_found(f"Template of prompt '{self.name}' for questions of kind", question.kind, self._parts)
        messages = [ChatMessage(part.role, self._fill(part.template, question)) for part in parts]
        if question.images:
            _attach(messages, question.images)
        return tuple(messages)

    def _compile(self, kind: str, source: Source) -> tuple[_Part, ...]:
        if isinstance(source, str):
            source = [{"role": "user", "content": source}]
        where = f"Prompt '{self.name}', template '{kind}'"
        if not isinstance(source, Sequence) or not source:
            raise InputError(f"{where}: give a text, or a list of {{role, content}}.")
        parts = []
        for entry in source:
            if not isinstance(entry, Mapping) or entry.keys() != {"role", "content"}:
                raise InputError(f"{where}: each message needs `role` and `content`, and nothing else.")
            if entry["role"] not in ROLES:
                raise not_found(f"{where}: role", str(entry["role"]), ROLES)
            try:
                template = self._compiled(entry["content"])
            except TemplateSyntaxError as error:
                raise InputError(f"{where}, line {error.lineno}: {error.message}.") from error
            parts.append(_Part(entry["role"], template))
        if all(part.role != "user" for part in parts):
            raise InputError(f"{where}: one message needs the role 'user'.")
        return tuple(parts)

    def _compiled(self, source: str) -> Template:
        return compiled(source) if self._format is None else compiled(self._format.marked(source), unmarked)

    def _fill(self, template: Template, question: Question) -> str:
        try:
            text = fill(template, question.observation)
            return text if self._format is None else self._format.laid_out(text)
        except RENDER_ERRORS as error:
            where = f"Prompt '{self.name}', template '{question.kind}'"
            raise explain(error, where, question.observation) from error


def _attach(messages: list[ChatMessage], images: tuple[bytes, ...]) -> None:
    last = max(index for index, message in enumerate(messages) if message.role == "user")
    messages[last] = structs.replace(messages[last], images=images)
