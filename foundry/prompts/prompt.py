"""A prompt: one template of Jinja2 per kind of question, in a sandbox where unknown names are errors."""

import difflib
import re
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from operator import methodcaller
from typing import Any, TypeAlias

from jinja2 import StrictUndefined, Template, TemplateError, TemplateSyntaxError, UndefinedError
from jinja2.filters import sync_do_join
from jinja2.runtime import Context
from jinja2.sandbox import ImmutableSandboxedEnvironment
from msgspec import structs

from foundry.errors import InputError, not_found
from foundry.models.base import ChatMessage
from foundry.prompts.formats import Format, unmarked
from foundry.worlds.base import Question

RENDER_ERRORS = (
    TemplateError,
    ArithmeticError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
    OverflowError,
)
"""Errors that can occur while a template is filled: Jinja2's own, and those of expressions in it."""

_TEMPLATE_FILE = "<template>"
_QUOTED = re.compile(r"'([^']*)'")


class PromptEnvironment(ImmutableSandboxedEnvironment):
    """In a template, `a.b` means the key `b` of the dict `a`, never a method, so that a key may be named `items`."""

    def getattr(self, obj: Any, attribute: str) -> Any:
        """Return the value of a key of a dict; for other objects, the attribute that the sandbox allows."""
        if isinstance(obj, dict):
            if attribute in obj:
                return obj[attribute]
            return self.undefined(obj=obj, name=attribute)
        return super().getattr(obj, attribute)


@cache
def environment_of(finalize: Callable[[Any], Any] | None = None) -> PromptEnvironment:
    """Return a Jinja2 environment, which applies the function `finalize` to each value that a template inserts.

    It adds two filters: `values`, the values of a dict, and `flat(n)`, a text in one line of at most n characters.
    """
    environment = PromptEnvironment(
        undefined=StrictUndefined, autoescape=False, trim_blocks=True, lstrip_blocks=True, finalize=finalize
    )
    environment.filters["values"] = methodcaller("values")
    environment.filters["flat"] = _flat
    environment.filters["join"] = sync_do_join  # the async one checks each time whether its parts must be awaited
    return environment


@lru_cache(maxsize=256)
def compiled(source: str, finalize: Callable[[Any], Any] | None = None) -> Template:
    """Compile the source of a template; cached, because this takes milliseconds.

    Raises:
        TemplateSyntaxError: the text is not a template.
    """
    return environment_of(finalize).from_string(source)


def fill(template: Template, observation: Mapping[str, Any]) -> str:
    """Fill a template with an observation, whose keys are the names in the template.

    It works like `Template.render`, but takes less time.

    Raises:
        RENDER_ERRORS: the template cannot be filled; the traceback contains lines of the template.
    """
    environment = template.environment
    names = {**environment.globals, **observation}
    try:
        return "".join(template.root_render_func(Context(environment, names, template.name, template.blocks)))
    except RENDER_ERRORS:
        environment.handle_exception()


def _flat(text: str, length: int) -> str:
    return " ".join(text.split())[:length]


def explain(error: Exception, where: str, observation: Mapping[str, Any]) -> InputError:
    """Return an error whose message is one line: the place of the fault in the template, and the fault."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == _TEMPLATE_FILE]
    message = f"{where}, line {lines[-1] if lines else '?'}: {error}."
    if isinstance(error, UndefinedError):
        names = _QUOTED.findall(str(error))
        close = difflib.get_close_matches(names[-1], _names(observation), n=1) if names else []
        message += f" Did you mean '{close[0]}'?" if close else f" Observed: {', '.join(sorted(observation))}."
    return InputError(message)


def _names(value: Any) -> set[str]:
    if isinstance(value, Mapping):
        return set(value).union(*map(_names, value.values()))
    return set().union(*map(_names, value)) if isinstance(value, list) else set()


Source: TypeAlias = str | Sequence[Mapping[str, str]]
"""The text of one user message, or a list of messages with `role` and `content`."""

ROLES = ("system", "user", "assistant")


@dataclass(frozen=True, slots=True)
class _Part:
    role: str
    template: Template


class Prompt:
    """Converts questions to messages for a model."""

    def __init__(self, name: str, templates: Mapping[str, Source], format: Mapping[str, Any] | None = None) -> None:
        """Compile the templates.

        Args:
            name: name of the prompt.
            templates: source of the template for each kind of question; a final line break is dropped.
            format: the argument of `Format.of`; None leaves the prompt unchanged.

        Raises:
            InputError: a source is not a template, or the format does not exist.
        """
        self.name = name
        self._format = None if format is None else Format.of(format)
        self._parts = {kind: self._compile(kind, source) for kind, source in templates.items()}

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of question that have a template."""
        return tuple(self._parts)

    def render(self, question: Question) -> tuple[ChatMessage, ...]:
        """Return the messages for a question; its images belong to the last user message.

        Raises:
            InputError: the kind of question has no template, or the template cannot be filled.
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
            raise InputError(f"{where}: use a text, or a list of {{role, content}}.")
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
            raise InputError(f"{where}: at least one message needs the role 'user'.")
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
