"""Every measure once more, from the JSON lines, with plain loops that share no code with the analysis."""

import math
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis import signatures
from analysis.grid.grid_run import Fire, GridRun
from analysis.grid.signatures.warning import measure
from grid_runs import grid_run
from plain_grid import (
    clustering,
    communication,
    cost,
    idle_rate,
    outcome,
    path_efficiency,
    place_choice,
    reach,
    relayed,
    stability,
    warning,
)
from plain_run import Plain, exploration, hazard, movement
from walkers import Habits

RECOMPUTED: dict[str, Callable[[Plain], Iterator[tuple[str, float]]]] = {
    check.__name__: check
    for check in (
        clustering, communication, cost, exploration, hazard, idle_rate, movement, outcome, path_efficiency,
        place_choice, stability, warning,
    )
}  # fmt: skip

GRID = [signature for signature in signatures.discover() if signature.name in RECOMPUTED]


STEPS, AGENTS = st.integers(1, 3), st.integers(0, 2)
LINKS = st.tuples(STEPS, AGENTS, AGENTS).filter(lambda link: link[1] != link[2])

ELSEWHERE = {"evacuation", "survival"}
"""Signatures that are about other worlds than the recorded one; see `test_leaving` and `test_living`."""


def test_every_signature_of_2d_runs_is_recomputed():
    own = {
        signature.name for signature in signatures.discover() if any(part.run is GridRun for part in signature.parts)
    }
    assert set(RECOMPUTED) == {*own, "cost"} - ELSEWHERE


@pytest.mark.parametrize(
    ("seed", "speak", "unreadable", "steps"), [(0, 0.4, 0.1, 25), (1, 0.08, 0.4, 20), (2, 0.9, 0, 8)]
)
def test_every_signature_agrees_with_plain_loops(seed: int, speak: float, unreadable: float, steps: int, recorded):
    written = recorded(seed=seed, habits=Habits(speak=speak, unreadable=unreadable), steps=steps)
    every, readable = Plain(written.folder), Plain(written.folder, readable_only=True)
    expected, found = {}, {}
    for signature in GRID:
        recompute, name = RECOMPUTED[signature.name], signature.name
        expected |= {f"{name}.{measure}": value for measure, value in recompute(every)}
        if signature.readable_too:
            expected |= {f"{name}.{measure}_readable": value for measure, value in recompute(readable)}
        run = written.view_of(signature)
        found |= signature.columns(run, run.only_readable())
    assert set(found) == set(expected)
    assert found == pytest.approx(expected, abs=1e-9, rel=1e-9, nan_ok=True)


@settings(max_examples=40)
@given(st.dictionaries(AGENTS, STEPS, min_size=1), st.lists(LINKS, min_size=3, max_size=9))
def test_news_over_passing_contacts_reaches_whom_plain_loops_reach(perceived: dict[int, int], links: list[Any]):
    seen = np.zeros((4, 4, 1), dtype=np.bool_)
    seen[np.array(list(perceived.values())) - 1, list(perceived)] = True
    contacts = np.array(links, dtype=np.int64).reshape(-1, 3)
    fires = [Fire("fire", 1, (0, 0), 9.0)]
    measures = measure(grid_run([[(0, 0)] * 5] * 4, fires=fires, fires_seen=seen, contacts=contacts))
    plain: Any = SimpleNamespace(agents=range(4), steps=range(1, 5))
    expected = relayed(plain, perceived, links)
    assert measures["n_reachable"] == len(expected)
    assert measures["oracle_reach"] == pytest.approx(reach(plain, expected, perceived), nan_ok=True)


def test_what_is_recomputed_is_defined_in_one_of_the_runs(recorded):
    run = recorded(seed=3, habits=Habits(speak=0.15, unreadable=0.2), steps=40).run
    assert {column for column, value in signatures.measure(run).items() if math.isnan(value)} == set()
