"""What the docstrings of the signatures say, cut into paragraphs and items."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from analysis.signatures import FUNCTIONS, Signature

_ITEM = re.compile(r"- ([\w*]+(?:, [\w*]+)*): ")


@dataclass(frozen=True)
class Block:
    """A paragraph, or an item of a list with the names that it defines, and their nulls."""

    text: str
    name: str = ""
    null: str = ""


@dataclass(frozen=True)
class Definition:
    """How one kind of run is measured.

    Attributes:
        module: where the code is.
        blocks: what its docstrings say.
    """

    module: str
    blocks: tuple[Block, ...]


def definitions(signature: Signature, kinds: set[type]) -> list[Definition]:
    """Return the definitions of a signature for these kinds of runs.

    One that says no more than that it is the same as for the other kind brings that one along.
    """
    own = [kind for kind in FUNCTIONS if kind in kinds and kind in signature.functions]
    found = {kind: _definition(function, signature) for kind, function in signature.functions.items()}
    alone = all(any(block.name for block in found[kind].blocks) for kind in own)
    return [one for kind, one in found.items() if own and (kind in own or not alone)]


def _definition(function: Callable[..., Any], signature: Signature) -> Definition:
    module = sys.modules[function.__module__]
    text = "\n\n".join(filter(None, (inspect.getdoc(module), inspect.getdoc(function))))
    return Definition(function.__module__, tuple(_with_null(block, signature) for block in blocks(text)))


def _with_null(block: Block, signature: Signature) -> Block:
    """Return the block with what chance gives of the measures that it defines."""
    measures = [signature.measures[name] for name in block.name.split(", ") if name in signature.measures]
    return replace(block, null="; ".join(dict.fromkeys(str(one.null) for one in measures if one.null)))


def blocks(text: str) -> list[Block]:
    """Return a docstring as paragraphs and items; an item begins with `- name: `."""
    found: list[Block] = []
    for paragraph in re.split(r"\n\s*\n", text.strip()):
        for part in re.split(r"\n(?=- )", paragraph):
            plain = " ".join(part.split())
            named = _ITEM.match(plain)
            found.append(Block(plain[named.end() :], named[1]) if named else Block(plain))
    return found
