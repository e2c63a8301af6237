"""Writes the list of signatures in docs/signatures.md from their modules: `python benchmarks/signature_page.py`."""

from __future__ import annotations

import inspect
import math
import sys
from pathlib import Path

from analysis.measure import Measure
from analysis.signature_modules import Part
from analysis.signatures import Signature, discover
from foundry import paths

PAGE = paths.PACKAGE.parent / "docs" / "signatures.md"
BEGIN, END = "<!-- begin of the list -->\n", "<!-- end of the list -->\n"


def with_list(page: str) -> str:
    """Return the page with the list of signatures made anew between its two marks."""
    before, rest = page.split(BEGIN)
    after = rest.split(END)[1]
    sections = [section(one) for one in sorted(discover(), key=lambda one: one.name)]
    return f"{before}{BEGIN}\n{''.join(sections)}{END}{after}"


def section(signature: Signature) -> str:
    """Return the section of a signature: what its modules say of themselves, and a line a measure."""
    modules = [f"*{form(part)}*, `{part.module}`: {introduction(part)}" for part in signature.parts]
    measures = [line(signature, name, measure) for name, measure in signature.measures.items()]
    return "\n".join([f"## {signature.name}\n", "\n\n".join(modules), "", *measures, "\n"])


def form(part: Part) -> str:
    """Return the form of the worlds that a module measures."""
    return part.module.split(".")[1]


def introduction(part: Part) -> str:
    """Return the docstring of a module in one line, without the signature's name before it."""
    text = " ".join(str(inspect.getdoc(sys.modules[part.module])).split())
    title, colon, rest = text.partition(": ")
    return rest if colon and len(title.split()) < 4 else text


def line(signature: Signature, name: str, measure: Measure) -> str:
    """Return what a measure is called, its range, its null, and its forms where not all have it."""
    forms = [form(part) for part in signature.parts if name in part.measures]
    named = f"**`{name}`**" if name in signature.headline else f"`{name}`"
    only = f" ({', '.join(forms)})" if len(forms) < len(signature.parts) else ""
    null = f"; null {measure.null}" if measure.null else ""
    return f"- {named}{only}: {measure.label}, {extent(measure)}{null}"


def extent(measure: Measure) -> str:
    """Return the range of a measure in words."""
    if math.isinf(measure.high):
        return "any" if math.isinf(measure.low) else f"{measure.low:g} up"
    return f"{measure.low:g}..{measure.high:g}"


if __name__ == "__main__":
    Path(PAGE).write_text(with_list(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
