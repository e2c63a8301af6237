"""Reads the definitions of measures from the docstrings of signatures."""

import inspect
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace

from analysis.form import FormAnalysis
from analysis.signature_modules import SHIPPED, Part
from analysis.signatures import Signature
from foundry.texts import one_line

_ITEM = re.compile(r"- ([\w*<>]+(?:, [\w*<>]+)*): ")


@dataclass(frozen=True)
class Block:
    """A paragraph; or an item of a list, with the names of the measures that it defines and their nulls."""

    text: str
    name: str = ""
    null: str = ""


@dataclass(frozen=True)
class Definition:
    """The definitions of a signature's measures for one form.

    Attributes:
        module: name of the module, or the path of your own file.
    """

    module: str
    blocks: tuple[Block, ...]


def definitions(signature: Signature, forms: Iterable[FormAnalysis]) -> list[Definition]:
    """Return the definitions of a signature's measures, one per form that has its own."""
    parts = dict.fromkeys(signature.part(form.run) for form in forms)
    return [_definition(part) for part in parts if part is not None]


def _definition(part: Part) -> Definition:
    text = part.about or _docstrings(part)
    where = part.module if part.origin == SHIPPED else part.origin
    return Definition(where, tuple(_with_null(block, part) for block in blocks(text)))


def _docstrings(part: Part) -> str:
    module = sys.modules[part.function.__module__]
    return "\n\n".join(filter(None, (inspect.getdoc(module), inspect.getdoc(part.function))))


def _with_null(block: Block, part: Part) -> Block:
    measures = [part.measures[name] for name in block.name.split(", ") if name in part.measures]
    return replace(block, null="; ".join(dict.fromkeys(str(measure.null) for measure in measures if measure.null)))


def blocks(text: str) -> list[Block]:
    """Split a docstring into paragraphs and items; an item begins with `- name: `."""
    definitions: list[Block] = []
    for paragraph in re.split(r"\n\s*\n", text.strip()):
        for part in re.split(r"\n(?=- )", paragraph):
            plain = one_line(part)
            named = _ITEM.match(plain)
            definitions.append(Block(plain[named.end() :], named[1]) if named else Block(plain))
    return definitions
