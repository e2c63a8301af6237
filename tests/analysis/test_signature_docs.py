"""The tables of docs/signatures.md and the measures say the same."""

from __future__ import annotations

import math
import re

import pytest

from analysis import signatures
from analysis.measure import Measure
from foundry import paths

TEXT = (paths.PACKAGE.parent / "docs" / "signatures.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"(?ms)^## (\w+)\n(.*?)(?=^## |\Z)", TEXT))
NUMBERS = re.compile(r"any|-?[\d.]+?(\.\.-?[\d.]+| up)")
"""A range without a letter in it, such as T or N, which only the documentation knows."""


def in_words(measure: Measure) -> str:
    if math.isinf(measure.high):
        return "any" if math.isinf(measure.low) else f"{measure.low:g} up"
    return f"{measure.low:g}..{measure.high:g}"


def rows(section: str) -> list[list[str]]:
    """Return the cells of the rows that are about measures."""
    lines = [line for line in section.splitlines() if line.startswith("| `")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]


@pytest.mark.parametrize("signature", signatures.discover(), ids=lambda one: one.name)
def test_every_measure_is_in_the_table_of_its_signature_with_its_range_and_its_null(signature: signatures.Signature):
    found = rows(SECTIONS[signature.name])
    assert all(len(cells) == 7 for cells in found), "measure, definition, unit, range, null, undefined, source"
    ranges = {name: cells[3] for cells in found for name in re.findall("`(.+?)`", cells[0])}
    nulls = {name: cells[4] for cells in found for name in re.findall("`(.+?)`", cells[0])}
    assert set(signature.measures) <= set(ranges)
    for name, measure in signature.measures.items():
        assert ranges[name] == in_words(measure) or not NUMBERS.fullmatch(ranges[name]), name
        assert nulls[name] == (str(measure.null) if measure.null else ""), name


def test_the_signatures_are_in_the_order_of_the_alphabet():
    assert list(SECTIONS) == sorted(signature.name for signature in signatures.discover())
