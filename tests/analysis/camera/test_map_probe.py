"""The measures of answers after a walk, on answers worked out by hand."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

from analysis import signatures
from analysis.camera.signatures import map_probe

WORLD = {"questions": ["nearer", "side", "count", "distance"]}


def answer(kind: str, said: Any, truth: Any, chance: float | None = None, scale: float | None = None) -> dict[str, Any]:
    return {"kind": kind, "answer": said, "truth": truth, "chance": chance, "scale": scale}


ANSWERS = (
    answer("nearer", "A", "A", 0.5),
    answer("side", None, "left", 0.5),
    answer("count", 2, 2, 0.25),
    answer("distance", 3.0, 4.5, scale=3.0),
)


def test_what_is_right_is_counted_beyond_chance_and_what_could_not_be_read_is_wrong_or_left_out(camera):
    run = dataclasses.replace(camera(3).run, answers=ANSWERS, world=WORLD)
    found = map_probe.measure(run)
    assert found["accuracy"] == pytest.approx(2 / 3) and found["chance"] == pytest.approx(5 / 12)
    assert found["above_chance"] == pytest.approx(1 / 4)
    assert (found["accuracy_nearer"], found["accuracy_side"], found["chance_count"]) == (1, 0, 0.25)
    assert (found["distance_error"], found["distance_relative"]) == (1.5, 0.5)
    assert (found["n_questions"], found["n_distances"]) == (3, 1)
    run = dataclasses.replace(camera(3).run, answers=ANSWERS, world=WORLD)
    found = map_probe.measure(run.only_readable())
    assert found["accuracy"] == 1 and math.isnan(found["accuracy_side"]) and found["n_questions"] == 2
    silent = (answer("distance", None, 4.5, scale=3.0),)
    assert math.isnan(map_probe.measure(dataclasses.replace(run, answers=silent))["distance_error"])
    assert not run.all_readable
    assert not any(name.startswith("map_probe.") for name in signatures.measure(camera(3).run))
