"""A probe is counted before anything is asked, and the next one is planned by it."""

from __future__ import annotations

import hashlib
from collections import Counter
from pathlib import Path

import pandas as pd
import pytest

from analysis.paper.summary import EXPLORES
from commands import foundry
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
    rows = pd.read_csv(probed / "analysis" / "power.csv").set_index("context")
    assert set(rows.index) == {
        f"model={one}" for one in ("left", "other", "scripted/avoid", "scripted/herd", "scripted/random")
    }
    avoid = rows.loc["model=scripted/avoid"]
    assert (avoid["measure"], avoid["n_pairs"], avoid["difference"]) == ("change under no_fire", 3, 0.2)
    assert avoid["n_family"] >= 6 and "no_fire - none (model=scripted/avoid): run " in told


ASKED_ONCE = ("-m", "model=scripted/herd,scripted/avoid", "edit=no_fire", "moments=6", "repeats=1", "output.dir=out")


@pytest.mark.slow
def test_a_probe_that_was_declared_is_held_against_its_plan(pilot: Path, tmp_path: Path):
    asked = (str(pilot), *ASKED_ONCE)
    said = done("preregister", *asked, "--family", "no_fire", cwd=tmp_path).splitlines()
    plan = (tmp_path / "out" / "preregistration.yaml").read_bytes()
    assert said[0] == f"{hashlib.sha256(plan).hexdigest()}  out/preregistration.yaml"
    assert said[1] == "3 seeds, tests: 2 of edits" and said[-1].endswith(f"then: foundry probe {' '.join(asked)}")
    told = done("probe", *asked, cwd=tmp_path)
    assert "nothing differs from the plan" in " ".join(told.split())
    assert EXPLORES not in told and "known before" not in told
    assert "foundry resume" not in told, "a probe gets seeds from the sweeps that its moments come from"
    again = [word.replace("=out", "=again") for word in asked]
    said = done("preregister", *again, "--family", "no_fire", cwd=tmp_path).splitlines()
    assert said[2].startswith("known before the plan: runs in out; ask in other moments: ")
    assert "known before the plan: runs in out" in " ".join(done("probe", *again, cwd=tmp_path).split())
    refused = foundry("analyze", "out", "--family", "no_fire", cwd=tmp_path)
    assert refused.returncode == 2 and "leave --family and --margin out" in refused.stderr
    (tmp_path / "out" / "preregistration.yaml").write_bytes(plan + b"# later\n")
    told = done("analyze", "out", cwd=tmp_path)
    assert "counts as no plan, so all of this explores" in " ".join(told.split())


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ((), "Nothing is declared: name a model or an edit"),
        (("--family", "no_fir"), "Did you mean 'no_fire'?"),
        (("--family", "no_fire", "--looks", "6,8"), "A probe has no margins and no looks"),
    ],
)
def test_a_plan_of_a_probe_that_cannot_be_is_refused(pilot: Path, tmp_path: Path, more: tuple[str, ...], message: str):
    refused = foundry("preregister", str(pilot), *ASKED_ONCE, *more, cwd=tmp_path)
    assert refused.returncode == 2 and message in refused.stderr and not (tmp_path / "out").exists()
