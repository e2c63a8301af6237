"""`foundry preregister`, and what is said of a sweep that was declared."""

from __future__ import annotations

import hashlib
import re
import shutil
import tarfile
from pathlib import Path

import pytest
import zstandard

from analysis import Analysis, analyze
from analysis.paper.summary import EXPLORES
from analysis.tables.texts import claim_of
from commands import foundry
from ollama_server import OllamaServer

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
    assert said[1] == "8 seeds, pairs: 1 (model) with 2 tests; looks at 6 (level 0.037), 8 (level 0.029)"
    assert said[-1].endswith(f"then: foundry {' '.join(SWEEP)} until=answered")
    assert "Only a difference answers clustering.nni and idle_rate.chosen: without one all 8 seeds" in "".join(said)


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
        (
            ("--family", "clustering.nni", "--widest", "clustering.nni=one"),
            "--widest clustering.nni=one has not the form",
        ),
        (("--family", "clustering.mni"), "Did you mean 'clustering.nni'"),
    ],
)
def test_what_cannot_be_declared_is_one_line_and_leaves_no_folder(tmp_path, words, message):
    done = foundry("preregister", *SWEEP, *words, cwd=tmp_path)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_nothing_is_declared_once_a_sweep_has_begun(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "sweep.yaml").write_text("{}")
    done = foundry("preregister", *SWEEP, *DECLARED, cwd=tmp_path)
    assert done.returncode == 2
    assert "a plan is made before the runs" in done.stderr


@pytest.mark.slow
def test_a_plan_that_is_put_beside_a_finished_sweep_declares_nothing(declared, tmp_path):
    sweep = Path(shutil.copytree(declared / "out", tmp_path / "out")) / "sweep.yaml"
    sweep.write_text(re.sub(r"plan: .*\n", "", sweep.read_text()))  # as where it began without one
    found = analyze(tmp_path / "out", plots=False)
    assert "counts as no plan, so all of this explores: the sweep began without a plan" in found.notes[0]
    assert set(found.contrasts["claim"]) == {"exploratory"} and found.summary[0] == EXPLORES
    done = foundry(*SWEEP, "until=answered", cwd=tmp_path)
    assert done.returncode == 2 and "did not begin with the plan" in done.stderr


@pytest.mark.slow
def test_another_plan_or_one_of_a_later_date_declares_nothing(declared, tmp_path):
    sweep = Path(shutil.copytree(declared / "out", tmp_path / "out"))
    plan = sweep / "preregistration.yaml"
    first = plan.read_text()
    plan.write_text(first.replace("nni", "largest_group"))
    assert "the sweep began with another one (SHA-256" in analyze(sweep, plots=False).notes[0]
    later = re.sub(r"made: .*", "made: '2999-01-01T00:00:00+00:00'", first)
    plan.write_text(later)
    text = (sweep / "sweep.yaml").read_text()
    (sweep / "sweep.yaml").write_text(re.sub(r"plan: .*", f"plan: {hashlib.sha256(later.encode()).hexdigest()}", text))
    found = analyze(sweep, plots=False)
    assert "it was made at 2999-01-01T00:00:00+00:00, after the first run of " in found.notes[0]
    assert set(found.contrasts["claim"]) == {"exploratory"}


@pytest.mark.slow
def test_every_declared_row_says_what_was_known_and_unseen_seeds_are_proposed(tmp_path):
    served = [word.replace(MODELS, "model=qwen3:4b,llama3.2").replace("steps=3", "steps=1") for word in SWEEP]
    again = [word.replace("=out", "=again") for word in served]
    with OllamaServer() as server:
        assert foundry(*served, cwd=tmp_path, OLLAMA_HOST=server.url).returncode == 0
        analyze(tmp_path / "out", plots=False)
        said = foundry("preregister", *again, *DECLARED, cwd=tmp_path, OLLAMA_HOST=server.url)
        assert said.returncode == 0, said.stderr
        known = "known before the plan: 96 answers, runs in out"
        assert f"{known}; ask for seeds that nobody has seen: seed=8-15" in said.stdout
        assert foundry(*again, cwd=tmp_path, OLLAMA_HOST=server.url).returncode == 0
    rows = analyze(tmp_path / "again", plots=False).contrasts
    declared = rows[rows["claim"] == "declared"]
    assert len(declared) and declared["note"].str.contains(known).all()
