"""How tests wait for other processes: by the clock, whatever a look costs."""

from __future__ import annotations

import itertools

import pytest

import commands
from commands import PATIENCE_S, wait_until


def test_a_test_that_waits_gives_up_by_the_clock_and_not_by_the_number_of_its_looks(monkeypatch: pytest.MonkeyPatch):
    seconds = itertools.count(step=PATIENCE_S / 2)
    monkeypatch.setattr(commands, "monotonic", lambda: next(seconds))
    looks = itertools.count()
    with pytest.raises(AssertionError, match="in vain: the end"):
        wait_until(lambda: next(looks) == 3, "the end")
    assert next(looks) == 2
