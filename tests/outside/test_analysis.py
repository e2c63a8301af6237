"""A world of a form that is not shipped goes through the analysis as those do that are."""

import hashlib
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

import analysis
from analysis import plots
from analysis.measuring.memory import code_version
from analysis.report import render
from analysis.report.material import gather
from analysis.signature_modules import code_lines
from commands import foundry, succeeds
from foundry.errors import InputError
from foundry.own_code import VARIABLE, use
from foundry.storing.store import SweepFolder
from report_pages import narrowed
from traces import no_traces


@dataclass(frozen=True)
class Outside:
    """A user's folder `mine` and a sweep `out`, both in `cwd`, where the commands are started."""

    cwd: Path

    @property
    def sweep(self) -> Path:
        return self.cwd / "out"

    def foundry(self, *arguments: str) -> str:
        """Run a command that ends well, with the user's folder; return what it printed."""
        return succeeds(*arguments, "--config-dir", "mine", cwd=self.cwd).stdout


@pytest.fixture(scope="module")
def outside(tmp_path_factory: pytest.TempPathFactory) -> Outside:
    """The user's folder with the finished sweep of two models and two seeds on the ring beside it."""
    cwd = tmp_path_factory.mktemp("outside")
    shutil.copytree(Path(__file__).with_name("mine"), cwd / "mine", ignore=shutil.ignore_patterns("__pycache__"))
    asked = ("-m", "world=ring", "prompt=ring", "model=walker,other", "seed=0-1", "output.dir=out", "runner.workers=1")
    cache = f"cache.path={cwd / 'answers.sqlite'}"
    succeeds("--config-dir", "mine", *asked, cache, "analyze=false", cwd=cwd)
    return Outside(cwd)


@pytest.fixture(scope="module")
def once(outside: Outside) -> analysis.Analysis:
    with no_traces():
        use([outside.cwd / "mine"])
        return analysis.analyze(outside.sweep, plots=False)


@pytest.fixture
def analysed(outside: Outside, once: analysis.Analysis) -> analysis.Analysis:
    use([outside.cwd / "mine"])
    return once


def test_it_runs_says_what_it_is_and_is_loaded_as_tidy_tables_its_own_record_file_among_them(outside: Outside):
    assert "4 runs" in outside.foundry("status", "out") or "complete" in outside.foundry("status", "out")
    for run in SweepFolder.open(outside.sweep).runs():
        assert run.declared.form == "ring" and set(run.declared.streams) == {"steps", "agents", "laps"}
    loaded = analysis.load(outside.sweep)
    assert list(loaded.steps.columns) == [
        "run", "world", "model", "prompt", "seed",
        "step", "agent", "kind", "action", "outcome", "utility", "message", "place", "place_next",
    ]  # fmt: skip
    assert len(loaded.steps) == 4 * 6 * 4 and len(loaded.agents) == 4 * 4
    ends = loaded.steps[(loaded.steps["place_next"] == 0) & (loaded.steps["place"] != 0)]
    assert loaded.streams["laps"][["run", "step", "agent"]].to_numpy().tolist() == (
        ends[["run", "step", "agent"]].to_numpy().tolist()
    )


def test_it_is_measured_by_its_own_signatures_and_by_those_of_every_form(analysed: analysis.Analysis):
    names = {name.partition(".")[0] for name in analysed.table.measures}
    assert {"rounding", "restless", "outcome", "action", "heterogeneity", "persona_effect", "utility", "cost"} <= names
    assert not names & {"clustering", "warning", "viewpoint"}
    steps = analysis.load(analysed.path.parent).steps
    home = steps["place_next"].eq(0).groupby(steps["run"], sort=False).mean()
    assert analysed.runs["rounding.home"].tolist() == pytest.approx(home.tolist())
    assert not analysed.runs["rounding.home_readable"].equals(analysed.runs["rounding.home"])
    assert "rounding.home" in analysed.declared and "restless.change" not in analysed.declared
    assert {"rounding.home", "restless.change"} <= set(analysed.contrasts["measure"])


def test_the_tables_say_where_each_signature_came_from_and_its_steps_are_a_parquet_file(analysed: analysis.Analysis):
    sources = pd.read_csv(analysed.path / "sources.csv").set_index("signature")
    assert set(sources["form"]) == {"ring"}
    own = analysed.path.parents[1] / "mine" / "signatures" / "rounding.py"
    row = sources.loc["rounding"]
    assert (row["origin"], row["module"]) == ("mine/signatures/rounding.py", "rounding.py")
    assert row["sha256"] == hashlib.sha256(code_lines(own).encode()).hexdigest()
    assert tuple(sources.loc["cost", ["origin", "module"]]) == ("foundry", "analysis.any.signatures.cost")
    steps = pd.read_parquet(analysed.path / "steps.parquet")
    assert {"place", "place_next", "action", "utility", "said"} <= set(steps.columns) and len(steps) == 4 * 6 * 4
    assert steps["place"].dtype.kind == "i" and "message" not in steps


@pytest.mark.slow
def test_the_commands_analyse_it_and_plan_with_it(outside: Outside, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(plots, "FORMATS", ("svg",))  # two thirds of the time go into the others
    assert "tables: " in outside.foundry("analyze", "out", "--plots", "--family", "restless.change")
    assert "restless.change" in (outside.sweep / "analysis" / "summary.md").read_text(encoding="utf-8")
    drawn = {path.name for path in (outside.sweep / "analysis/plots").iterdir()}
    assert {"rounding.svg", "restless.svg", "outcome.svg"} <= drawn
    assert "rounding.home" in outside.foundry("plan", "--pilot", "out", "--measure", "rounding.home")


@pytest.mark.slow
def test_its_report_says_how_it_is_measured_and_by_whose_code(outside: Outside, analysed: analysis.Analysis):
    found = narrowed(gather(outside.sweep), ("rounding.",))
    page = render(found, outside.sweep, analysed.path / "plots")
    assert "mine/signatures/rounding.py" in page and "steps that end in the first place / steps" in page
    assert "labelled" not in page  # nobody labelled any message


BROKEN = {
    "def measure(": "SyntaxError",
    "import no_such_module": "No module named 'no_such_module'",
    "NAME = 'x'": "is not a signature (module 'foundry_own_signatures_bad' has no attribute",
    "NAME, MEASURES, HEADLINE = 'x', {}, ()\ndef measure(run): return {}": "is not annotated",
    "from analysis.any.any_run import AnyRun\nNAME, MEASURES, HEADLINE = 'restless', {}, ()\n"
    "def measure(run: AnyRun): return {}": "has the name 'restless'",
    "from analysis.any.any_run import AnyRun\nNAME, MEASURES, HEADLINE = 'x', {}, ()\n"
    "def measure(run: AnyRun): return {'a': 1 / 0}": "cannot measure run",
    "from analysis.any.any_run import AnyRun\nNAME, MEASURES, HEADLINE = 'x', {}, ()\n"
    "def measure(run: AnyRun): return {'a': 'b'}": "'b' is not a number",
    "NAME, MEASURES, HEADLINE = 'x', {}, ()\ndef measure(run: dict): return {}": "is not the class of runs of any form",
}


@pytest.mark.parametrize("text", BROKEN, ids=BROKEN.get)
def test_a_broken_signature_is_named_in_one_line(outside: Outside, tmp_path: Path, monkeypatch, text: str):
    mine = copied(outside, tmp_path, "mine")
    (mine / "signatures/bad.py").write_text(text + "\n", encoding="utf-8")
    monkeypatch.setenv(VARIABLE, str(mine))
    with pytest.raises(InputError, match=re.escape(BROKEN[text])) as raised:
        analysis.analyze(tmp_path / "out", plots=False)
    assert "mine/signatures/bad.py" in str(raised.value) and "\n" not in str(raised.value)


def test_a_broken_signature_hurts_only_who_uses_it(outside: Outside, tmp_path: Path):
    mine = copied(outside, tmp_path, "mine")
    (mine / "signatures/bad.py").write_text("def measure(\n", encoding="utf-8")
    done = foundry("analyze", "out", "--config-dir", "mine", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("foundry: mine/signatures/bad.py") and done.stderr.count("\n") == 1
    table = analysis.analyze(tmp_path / "out", plots=False).runs
    assert table["outcome.readable"].notna().all() and "restless.change" not in table


@pytest.mark.slow
def test_what_was_measured_is_measured_again_when_the_users_signature_changes(
    outside: Outside, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    signatures = copied(outside, tmp_path, "one") / "signatures"
    before, again = measured_with(tmp_path, "one", monkeypatch), measured_with(tmp_path, "one", monkeypatch)
    text = (signatures / "restless.py").read_text(encoding="utf-8")
    (tmp_path / "two/signatures").mkdir(parents=True)
    (tmp_path / "two/signatures/restless.py").write_text(text.replace(": mean(pairs)", ": mean(pairs) / 2"))
    assert before == again and measured_with(tmp_path, "two", monkeypatch) == pytest.approx([one / 2 for one in before])


def copied(outside: Outside, folder: Path, name: str) -> Path:
    """Copy the sweep, and of the user's folder what needs no class of another file; return that folder."""
    shutil.copytree(outside.sweep, folder / "out")
    (folder / name / "signatures").mkdir(parents=True)
    shutil.copy(outside.cwd / "mine/signatures/restless.py", folder / name / "signatures")
    return folder / name


def measured_with(folder: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    monkeypatch.setenv(VARIABLE, str(folder / name))
    return list(analysis.analyze(folder / "out", plots=False).runs["restless.change"])


def test_a_form_whose_file_says_something_else_is_named(outside: Outside, tmp_path: Path, monkeypatch):
    (tmp_path / "mine/forms").mkdir(parents=True)
    (tmp_path / "mine/forms/ring.py").write_text("ANALYSIS = 7\n", encoding="utf-8")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    with pytest.raises(InputError, match=r"^mine/forms/ring\.py: ANALYSIS must be"):
        analysis.load(outside.sweep)


def test_a_module_beside_the_users_signatures_counts_as_theirs(tmp_path: Path):
    versions = []
    for name, text in (("one", "MOST = 1\n"), ("two", "MOST = 2\n"), ("three", "MOST = 1\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "limits.py").write_text(text, encoding="utf-8")
        versions.append(code_version((tmp_path / name,)))
    assert versions[0] == versions[2] != versions[1]
