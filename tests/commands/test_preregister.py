"""`foundry preregister`, and what is said of a sweep that was declared."""

from __future__ import annotations

import hashlib
import tarfile
from pathlib import Path

import pytest
import zstandard

from analysis import Analysis, analyze
from analysis.tables.texts import claim_of
from commands import foundry

MODELS = "model=scripted/random,scripted/avoid"
SWEEP = ("-m", MODELS, "seed=0-7", "world.agents=3", "world.steps=3", "analyze=false", "output.dir=out")
DECLARED = ("--family", "clustering.nni", "--family", "idle_rate.chosen", "--looks", "6,8")


@pytest.fixture(scope="module")
def declared(tmp_path_factory) -> Path:
    """Return a folder with a declared sweep that was run."""
    folder = tmp_path_factory.mktemp("declared")
    done = foundry("preregister", *SWEEP, *DECLARED, cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "said.txt").write_text(done.stdout)
    done = foundry(*SWEEP, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def analysed(declared) -> Analysis:
    """Return what is found of it."""
    return analyze(declared / "out", plots=False)


def test_the_hash_is_that_of_the_file_and_the_next_command_is_said(declared):
    said = (declared / "said.txt").read_text().splitlines()
    content = (declared / "out" / "preregistration.yaml").read_bytes()
    assert said[0] == f"{hashlib.sha256(content).hexdigest()}  out/preregistration.yaml"
    assert said[1] == "8 seeds, 2 (model) tests; looks at 6 (level 0.037), 8 (level 0.029)"
    assert said[-1].endswith(f"then: foundry {' '.join(SWEEP)}")


def test_every_row_says_what_it_can_claim(analysed):
    rows = analysed.contrasts[analysed.contrasts["headline"]]
    assert set(rows["measure"]) == {"clustering.nni", "idle_rate.chosen"}
    assert set(map(claim_of, rows.to_dict("records"))) == {"declared, look 2, alpha .029"}
    others = analysed.contrasts[~analysed.contrasts["headline"]]
    assert set(others["claim"]) == {"exploratory"}
    assert "look 2 of 2, at 8 seeds, level 0.029 of a single test; nothing differs from the plan" in analysed.notes[0]


@pytest.mark.exhaustive
def test_the_report_says_what_was_declared(declared):
    assert foundry("report", "out", cwd=declared).returncode == 0
    page = (declared / "out" / "report.html").read_text()
    assert "declared, look 2, alpha .029" in page
    assert "declared before the runs" in page


def test_a_bundle_carries_the_plan_and_the_looks(declared, analysed):
    assert foundry("bundle", "out", "out.tar.zst", cwd=declared).returncode == 0
    stream = zstandard.ZstdDecompressor().stream_reader((declared / "out.tar.zst").read_bytes())
    with tarfile.open(fileobj=stream, mode="r|") as bundle:
        assert {"preregistration.yaml", "looks.jsonl"} <= {one.name for one in bundle}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("analyze", "out", "--family", "clustering.nni"), "leave --family and --margin out"),
        (("preregister", *SWEEP, *DECLARED), "has a plan already"),
    ],
)
def test_a_plan_stays_as_it_is(declared, words, message):
    done = foundry(*words, cwd=declared)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert message in done.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--looks", "6,8"), "No measure is declared"),
        (("--family", "clustering.nni", "--looks", "six"), "has not the form N,N"),
        (("--family", "clustering.mni"), "Did you mean 'clustering.nni'"),
    ],
)
def test_what_cannot_be_declared_is_one_line_and_leaves_no_folder(tmp_path, words, message):
    done = foundry("preregister", *SWEEP, *words, cwd=tmp_path)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_nothing_is_declared_once_runs_have_ended(tmp_path):
    (tmp_path / "out" / "runs" / "one").mkdir(parents=True)
    (tmp_path / "out" / "runs" / "one" / "run.json").write_text("{}")
    done = foundry("preregister", *SWEEP, *DECLARED, cwd=tmp_path)
    assert done.returncode == 2
    assert "a plan is made before the runs" in done.stderr
