"""The Jinja2 environment of all prompts: sandboxed, and strict about names."""

from __future__ import annotations

import difflib
import re
import traceback
from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from operator import methodcaller
from typing import Any

from jinja2 import StrictUndefined, Template, TemplateError, UndefinedError
from jinja2.filters import sync_do_join
from jinja2.runtime import Context
from jinja2.sandbox import ImmutableSandboxedEnvironment

from foundry.errors import InputError

RENDER_ERRORS = (
    TemplateError,
    ArithmeticError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
    OverflowError,
)
"""What filling a template can raise: Jinja2's own errors, and those of the expressions in it."""

_TEMPLATE_FILE = "<template>"
_QUOTED = re.compile(r"'([^']*)'")


class PromptEnvironment(ImmutableSandboxedEnvironment):
    """Looks names up among the keys of a dict only, so that no key is hidden by a method of the same name."""

    def getattr(self, obj: Any, attribute: str) -> Any:
        """Return the entry of a dict, else what the sandbox allows."""
        if isinstance(obj, dict):
            if attribute in obj:
                return obj[attribute]
            return self.undefined(obj=obj, name=attribute)
        return super().getattr(obj, attribute)


@cache
def environment_of(finalize: Callable[[Any], Any] | None = None) -> PromptEnvironment:
    """Return the environment whose templates do this to each value that they fill in.

    Filters beyond Jinja2's own: `values`, the values of a dict; `flat(n)`, a text in one line of at most n characters.
    """
    environment = PromptEnvironment(
        undefined=StrictUndefined, autoescape=False, trim_blocks=True, lstrip_blocks=True, finalize=finalize
    )
    environment.filters["values"] = methodcaller("values")
    environment.filters["flat"] = _flat
    environment.filters["join"] = sync_do_join  # the other asks each time whether what it joins must be awaited
    return environment


@lru_cache(maxsize=256)
def compiled(source: str, finalize: Callable[[Any], Any] | None = None) -> Template:
    """Return the template of a text; a sweep asks for each many times, and compiling one takes milliseconds.

    Raises:
        TemplateSyntaxError: it is none.
    """
    return environment_of(finalize).from_string(source)


def fill(template: Template, observation: Mapping[str, Any]) -> str:
    """Return the text of a template in which the keys of an observation are names.

    As `Template.render` does it, which takes half as long again to lay the globals and the observation together.

    Raises:
        RENDER_ERRORS: it cannot be filled; the traceback has the template's own lines.
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
    """Return the one line that says where in a template what went wrong."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == _TEMPLATE_FILE]
    message = f"{where}, line {lines[-1] if lines else '?'}: {error}."
    if isinstance(error, UndefinedError):
        names = _QUOTED.findall(str(error))
        close = difflib.get_close_matches(names[-1], _names(observation), n=1) if names else []
        message += f" Did you mean '{close[0]}'?" if close else f" Observed: {', '.join(sorted(observation))}."
    return InputError(message)


def _names(value: Any) -> set[str]:
    """Return all keys of nested dicts and lists."""
    if isinstance(value, Mapping):
        return set(value).union(*map(_names, value.values()))
    return set().union(*map(_names, value)) if isinstance(value, list) else set()
