"""A probe is counted before anything is asked, and the next one is planned by it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pandas as pd
import pytest

from probing.conftest import done, lines, runs

ASKED = ("-m", "model=scripted/herd,scripted/avoid", "edit=no_fire,mirror", "moments=20", "repeats=2")


@pytest.mark.slow
def test_a_plan_counts_the_calls_that_the_probe_then_makes(pilot: Path, tmp_path: Path):
    told = done("probe", str(pilot), "--plan", *ASKED, "output.dir=out", cwd=tmp_path)
    rows = [line.split() for line in told.splitlines()]
    assert rows[0] == ["edit", "moments", "conditions", "calls"] and not list(tmp_path.iterdir())
    done("probe", str(pilot), *ASKED, "output.dir=out", "analyze=false", "runner.workers=1", cwd=tmp_path)
    made = Counter[str]()
    for run in runs(tmp_path / "out"):
        made[run.factors["edit"]] += len(lines(run))
    planned = {edit: (int(moments), conditions, int(calls)) for edit, moments, conditions, calls in rows[1:4]}
    assert planned == {edit: (calls // 4, "2", calls) for edit, calls in made.items()}
    assert made["no_fire"] < made["none"] == made["mirror"] == 80
    assert f"at most 240 calls, fewer where an edit changes nothing; here {made.total()}" in told


def test_a_pilot_probe_says_how_many_seeds_are_needed(probed: Path):
    told = done("plan", "--pilot", str(probed), "--difference", "0.2", "--measure", "no_fire", cwd=probed.parent)
    rows = [line.split() for line in told.splitlines()]
    assert {f"{row[0]} {row[1]}" for row in rows[1:6]} == {
        f"{model}: no_fire" for model in ("left", "other", "scripted/avoid", "scripted/herd", "scripted/random")
    }
    (avoid,) = (row for row in rows if row[0] == "scripted/avoid:")
    assert avoid[2] == "3" and avoid[4] == "8" and int(avoid[7]) >= 5
    assert len(pd.read_csv(probed / "analysis" / "power.csv")) == 5
    assert rows[-1][0] == "run" and rows[-1][2] == "seeds"
