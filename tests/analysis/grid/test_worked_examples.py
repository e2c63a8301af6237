"""The formulas against worked examples that were checked with independent libraries."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from analysis.stats.intervals import estimate

EXAMPLES = json.loads(Path(__file__).with_name("worked_examples.json").read_text(encoding="utf-8"))


def example(name: str):
    return EXAMPLES[name]["inputs"], EXAMPLES[name]["expected"]


def close(expected: object) -> object:
    return pytest.approx(expected, abs=1e-9, rel=1e-9)


def test_the_interval_of_a_mean():
    inputs, expected = example("paired_t_ci")
    found = estimate(np.array(inputs["diffs"]))
    assert [found.low, found.high] == close(expected)
