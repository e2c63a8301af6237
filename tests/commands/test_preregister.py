"""`foundry preregister`, what is said of a declared sweep, and one that goes on `until=answered`."""

import hashlib
import re
import shutil
import tarfile
from pathlib import Path

import pandas as pd
import pytest
import zstandard

from analysis import Analysis, analyze
from analysis.paper.summary import EXPLORES
from analysis.planned.holding import made_late
from analysis.tables.texts import claim_of
from commands import foundry, refusal, statuses, succeeds
from foundry.storing.store import SweepFolder
from ollama_cases import BAD_OPTION
from ollama_server import OllamaServer
from own_market import write_market

MODELS = "model=scripted/random,scripted/avoid"
SWEEP = ("-m", MODELS, "seed=0-7", "world.agents=3", "world.steps=3", "analyze=false", "output.dir=out")
NNI = "clustering.nni"
DECLARED = ("--family", NNI, "--family", "idle_rate.chosen", "--looks", "6,8")
SMALL = ("seed=0-7", "world.agents=2", "world.steps=2", "analyze=false", "output.dir=out")
LOOKS = ("--family", "idle_rate.chosen", "--looks", "6,8")
UNLIKE = ("-m", "model=scripted/random,scripted/stay", *SMALL)


@pytest.fixture(scope="module")
def declared(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("declared")
    done = succeeds("preregister", *SWEEP, *DECLARED, cwd=folder)
    (folder / "said.txt").write_text(done.stdout)
    succeeds(*SWEEP, cwd=folder)
    return folder


@pytest.fixture(scope="module")
def analysed(declared) -> Analysis:
    return analyze(declared / "out", plots=False)


def test_the_hash_is_that_of_the_file_and_the_next_command_is_said(declared):
    said = (declared / "said.txt").read_text().splitlines()
    content = (declared / "out" / "preregistration.yaml").read_bytes()
    assert said[0] == f"{hashlib.sha256(content).hexdigest()}  out/preregistration.yaml"
    assert said[1] == (
        "8 seeds; tests: 2 for 1 pair of levels of model; looks after 6 seeds (level 0.037), 8 seeds (level 0.029)"
    )
    assert said[-1].endswith(f"then: foundry {' '.join(SWEEP)} until=answered")
    assert (
        "For clustering.nni and idle_rate.chosen, only a difference ends the sweep early; else all 8 seeds"
        in "".join(said)
    )


def test_every_row_says_what_it_can_claim(analysed):
    rows = analysed.contrasts[analysed.contrasts["headline"]]
    assert set(rows["measure"]) == {"clustering.nni", "idle_rate.chosen"}
    assert set(map(claim_of, rows.to_dict("records"))) == {"declared, look 2, alpha .029"}
    others = analysed.contrasts[~analysed.contrasts["headline"]]
    assert set(others["claim"]) == {"exploratory"}
    assert "look 2 of 2, at 8 seeds, level 0.029 of a single test; nothing differs from the plan" in analysed.notes[0]


@pytest.mark.exhaustive
def test_the_report_says_what_was_declared(declared):
    succeeds("report", "out", cwd=declared)
    page = (declared / "out" / "report.html").read_text()
    assert "declared, look 2, alpha .029" in page
    assert "declared before the runs" in page


def test_a_report_with_a_pilot_has_a_page_and_tables_of_its_own_and_counts_declared_seeds(declared, analysed):
    pilot = (*SWEEP[:2], "seed=20-22", *SWEEP[3:-1], "output.dir=pilot")
    succeeds(*pilot, cwd=declared)
    before = own_results(declared / "out")
    said = succeeds("report", "out", "pilot", cwd=declared).stdout
    joint = declared / "out" / "report_with_pilot.html"
    assert said.startswith("report of 22 runs in out/report_with_pilot.html; ") and "go on with" not in said
    assert " · 8 seeds declared, 3 exploratory</p>" in joint.read_text(encoding="utf-8")
    assert own_results(declared / "out") == before
    assert len(pd.read_csv(declared / "out" / "analysis_with_pilot" / "signatures.csv")) == 22


def own_results(folder: Path) -> dict[Path, bytes]:
    """Return the page and the tables of a sweep alone."""
    own = [folder / "report.html", *(folder / "analysis").rglob("*.*")]
    return {file: file.read_bytes() for file in own if file.is_file() and file.suffix != ".sqlite"}


def test_a_bundle_carries_the_plan_and_the_looks(declared, analysed):
    succeeds("bundle", "out", "out.tar.zst", cwd=declared)
    stream = zstandard.ZstdDecompressor().stream_reader((declared / "out.tar.zst").read_bytes())
    with tarfile.open(fileobj=stream, mode="r|") as bundle:
        assert {"preregistration.yaml", "looks.jsonl"} <= {one.name for one in bundle}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("analyze", "out", "--family", "clustering.nni"), "leave --family and --margin out"),
        (("preregister", *SWEEP, *DECLARED), "already has a plan"),
    ],
)
def test_a_plan_stays_as_it_is(declared, words, message):
    assert message in refusal(*words, cwd=declared)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--looks", "6,8"), "No measure is declared"),
        (("--family", NNI, "--looks", "six"), "must have the form N,N"),
        (("--family", NNI, "--widest", f"{NNI}=one"), f"such as clustering.largest_group=0.1; got {NNI}=one"),
        (("--family", "clustering.mni"), "Did you mean 'clustering.nni'"),
    ],
)
def test_what_cannot_be_declared_is_one_line_and_leaves_no_folder(tmp_path, words, message):
    assert message in refusal("preregister", *SWEEP, *words, cwd=tmp_path)
    assert not (tmp_path / "out").exists()


def test_nothing_is_declared_once_a_sweep_has_begun(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "sweep.yaml").write_text("{}")
    assert "a plan must precede the runs" in refusal("preregister", *SWEEP, *DECLARED, cwd=tmp_path)


@pytest.mark.slow
def test_a_plan_that_a_sweep_did_not_begin_with_declares_nothing(declared, tmp_path):
    out = Path(shutil.copytree(declared / "out", tmp_path / "out"))
    sweep, plan = out / "sweep.yaml", out / "preregistration.yaml"
    whole, first = sweep.read_text(), plan.read_text()

    def late(plan_of_the_sweep: str, text: str) -> str:
        sweep.write_text(re.sub(r"plan: .*\n", plan_of_the_sweep, whole))
        plan.write_text(text)
        return made_late(SweepFolder.open(out))

    assert made_late(SweepFolder.open(out)) == ""
    assert "the sweep began with a different plan (SHA-256" in late(r"\g<0>", first.replace("nni", "largest_group"))
    later = re.sub(r"made: .*", "made: '2999-01-01T00:00:00+00:00'", first)
    said = late(f"plan: {hashlib.sha256(later.encode()).hexdigest()}\n", later)
    assert "the plan was made at 2999-01-01T00:00:00+00:00, after the first run had started at " in said
    said = late("", first)
    assert "does not count as a plan, so all findings are exploratory: the sweep began without a plan" in said
    analysis = analyze(out, plots=False)
    assert analysis.notes[0] == said
    assert set(analysis.contrasts["claim"]) == {"exploratory"} and analysis.summary[0] == EXPLORES
    assert "began without this plan" in refusal(*SWEEP, "until=answered", cwd=tmp_path)


@pytest.mark.slow
def test_every_declared_row_says_what_was_known_and_unseen_seeds_are_proposed(tmp_path):
    served = ("-m", "model=qwen3:4b,llama3.2", "seed=0-5", "world.agents=2", "world.steps=1", "analyze=false")
    with OllamaServer() as server:
        to = {"cwd": tmp_path, "OLLAMA_HOST": server.url}
        succeeds(*served, "output.dir=out", **to)
        analyze(tmp_path / "out", plots=False)
        said = succeeds("preregister", *served, "output.dir=again", "--family", NNI, **to)
        known = "already recorded before the plan: 48 answers, runs in out"
        assert f"{known}; seeds without runs and cached answers: seed=6-11" in said.stdout
        succeeds(*served, "output.dir=again", **to)
    rows = analyze(tmp_path / "again", plots=False).contrasts
    declared = rows[rows["claim"] == "declared"]
    assert len(declared) and declared["note"].str.contains(known).all()


@pytest.mark.slow
def test_a_sweep_stops_at_the_look_that_answers_it_and_goes_on_later_and_is_analysed_as_it_asked(tmp_path):
    asked = [*(word for word in UNLIKE if word != "analyze=false"), "world=bar", "world.steps=8"]  # few pictures
    succeeds("preregister", *asked, *LOOKS, cwd=tmp_path)
    done = succeeds(*asked, "until=answered", cwd=tmp_path)
    assert "\nall declared tests are answered at look 1 of 2, at 6 seeds" in done.stdout
    assert done.stdout.count("tables: out/analysis") == 1
    folder = SweepFolder.open(tmp_path / "out")
    assert {condition.seeds for condition in folder.sweep.conditions} == {tuple(range(6))} and len(
        folder.sweep.history
    ) == 1
    assert folder.settings["analyze"] is True
    assert "tables: out/analysis" in foundry("resume", "out", "seed=6-7", cwd=tmp_path).stdout


@pytest.mark.slow
def test_a_run_that_fails_each_time_is_missing_from_the_look_as_planned_and_holds_up_none(tmp_path):
    own = ("--config-dir", str(write_market(tmp_path)))
    market = ("-m", "world=market", "prompt=market", "world.leaky=[2]", "model=bidder,miser", "seed=0-7", *SMALL[-2:])
    succeeds("preregister", *own, *market, *LOOKS, cwd=tmp_path)
    done = foundry(*own, *market, "until=answered", cwd=tmp_path)
    assert done.returncode == 3
    assert "\nnot all declared tests are answered at look 1 of 2, at 6 seeds" in done.stdout
    assert "\nstill open: idle_rate.chosen (" in done.stdout
    assert "; as planned, 2 failed runs left out" in done.stdout
    assert "\nall declared tests are answered at look 2 of 2, at 8 seeds" in done.stdout
    assert "try the failed runs again with: foundry resume out" in done.stdout
    assert sorted(statuses(tmp_path / "out")) == ["complete"] * 14 + ["failed"] * 2


@pytest.mark.slow
def test_runs_that_have_not_ended_hold_up_the_look(tmp_path):
    served = ("-m", "model=qwen3:4b,llama3.2", *SMALL, "runner.open_runs=1")
    with OllamaServer(lambda body: BAD_OPTION) as server:
        succeeds("preregister", *served, *LOOKS, cwd=tmp_path, OLLAMA_HOST=server.url)
        done = foundry(*served, "until=answered", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert done.returncode == 3
    assert "the sweep was stopped" in done.stderr and "answered" not in done.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            (*UNLIKE, "until=answered"),
            "folder 'out' contains no preregistration.yaml. Make a plan with: foundry preregister",
        ),
        ((*UNLIKE[:-1], "until=answered"), "no output.dir is named"),
        ((*UNLIKE, "until=soon"), "until must be null or answered; got soon"),
    ],
)
def test_nothing_is_answered_that_was_not_declared(tmp_path, words, message):
    assert message in refusal(*words, cwd=tmp_path)


def test_another_sweep_than_was_declared_is_refused(tmp_path):
    succeeds("preregister", *UNLIKE, *LOOKS, cwd=tmp_path)
    line = refusal(*UNLIKE, "world.steps=3", "until=answered", cwd=tmp_path)
    assert "16 runs of preregistration.yaml. Your overrides leave out 16 of these runs and add 16 other runs" in line
