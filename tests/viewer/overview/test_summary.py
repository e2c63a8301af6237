"""What the analysis found of each group, and the table of signatures, read from their files."""

import json
import os
import re
from pathlib import Path

import msgspec
import pandas as pd
import pytest

from analysis.tables.texts import write_numbers
from foundry.errors import RecordError
from foundry.storing.store import SweepFolder
from foundry.viewer.signature_table import SignatureTable
from foundry.viewer.summary import claimed_measures, summary_of
from made_up_runs import sweep

MEASURES = ["failure.rate", "collision.rate", "path.success", "cost.calls", "path.length"]


def analysed(path: Path, **tables: str) -> SweepFolder:
    made = sweep(path / "made")
    made.analysis_dir.mkdir()
    for name, text in tables.items():
        (made.analysis_dir / f"{name}.csv").write_text(text, encoding="utf-8")
    return made


def test_success_comes_first_and_what_a_run_took_is_no_claim(tmp_path: Path):
    assert claimed_measures(analysed(tmp_path), MEASURES) == ["path.success", "collision.rate"]


def test_the_headlines_of_the_contrasts_are_claimed(tmp_path: Path):
    table = "measure,headline\npath.length,True\npath.length,True\ncollision.rate,False\nunknown.rate,True\n"
    assert claimed_measures(analysed(tmp_path, contrasts=table), MEASURES) == ["path.length"]


def test_groups_have_the_numbers_of_the_analysis_and_their_runs(tmp_path: Path):
    made = analysed(
        tmp_path,
        comparison="measure,model,baseline,runs,n,mean,sd,low,high,interval,note\n"
        "path.success,first,False,2,2,0.5,0.1,0.25,0.75,t,\n"
        "path.success,'=second,False,2,2,0.0,0.0,,,,no variation\n"
        "path.length,first,False,2,2,9,1,8,10,t,\n"
        "path.success,random,True,2,2,0.1,0.1,0,0.2,t,\n",
    )
    runs = made.runs()
    made.signatures_path.write_text(
        "run,model,path.success\n" + f"{runs[0].id},first,0.5\n{runs[2].id},'=second,0\n{runs[3].id},'=second,0\n",
        encoding="utf-8",
    )
    summary = summary_of(made, ["path.success"], SignatureTable(made.signatures_path))
    assert summary.columns == ["model"] and summary.part == ""
    assert [(group.values, group.baseline) for group in summary.groups] == [
        (["first"], False),
        (["=second"], False),
        (["random"], True),
    ]
    assert summary.groups[0].measures == {"path.success": (0.5, 0.25, 0.75, 2)}
    assert summary.groups[1].measures == {"path.success": (0.0, None, None, 2)}
    assert summary.group_of == [0, None, 1, 1]


def test_findings_have_the_moments_of_runs_of_this_sweep(tmp_path: Path):
    made = analysed(tmp_path, comparison="measure,model,baseline,n,mean,low,high\npath.success,first,False,2,0.5,,\n")
    first, second = (run.id for run in made.runs()[:2])
    moment = {"level_run": first, "reference_run": second, "seed": 0, "step": 3, "agent": 1}
    finding = {"sentence": "A.", "measure": "path.success", "label": "Success", "standing": "stands", "p": 0.01}
    finding["moments"] = [moment, moment | {"reference_run": "of-another-sweep"}]
    file = made.analysis_dir / "findings.json"
    file.write_text(json.dumps([finding]))
    table = SignatureTable(made.signatures_path)
    [found] = summary_of(made, ["path.success"], table).findings
    assert (found.sentence, found.label, [msgspec.structs.asdict(moment) for moment in found.moments]) == (
        "A.",
        "Success",
        [moment],
    )
    file.write_text("[{}]")
    with pytest.raises(RecordError, match=re.escape(f"{file} cannot be read")):
        summary_of(made, ["path.success"], table)


def test_without_an_analysis_there_are_no_groups(tmp_path: Path):
    made = sweep(tmp_path / "made")
    assert summary_of(made, MEASURES, SignatureTable(made.signatures_path)).groups == []


RUNS = ["a", "b", "c", "d"]


@pytest.fixture
def table(tmp_path: Path) -> SignatureTable:
    """What the analysis writes of three runs."""
    frame = pd.DataFrame(
        {"run": ["c", "a", "b"], "agents": [2, 4, 2], "seen": [True, False, True], "share": [0.1, float("nan"), 1e-3]}
    )
    write_numbers(tmp_path / "signatures", frame)
    return SignatureTable(tmp_path / "signatures.csv")


def told(table: SignatureTable) -> list[object]:
    return [
        table.names(),
        table.numbers("share", RUNS),
        table.numbers("seen", RUNS),
        table.texts("agents", RUNS),
        table.texts("seen", RUNS),
        table.texts("share", RUNS),
    ]


def test_both_files_say_the_same_in_the_order_of_the_runs(table: SignatureTable):
    from_parquet = told(table)
    table.file.with_suffix(".parquet").unlink()
    assert told(table) == from_parquet
    assert from_parquet == [
        ["run", "agents", "seen", "share"],
        [None, 0.001, 0.1, None],
        [0.0, 1.0, 1.0, None],
        ["4", "2", "2", ""],
        ["False", "True", "True", ""],
        ["", "0.001", "0.1", ""],
    ]


def test_a_csv_file_that_was_written_later_is_read(table: SignatureTable):
    assert table.numbers("share", ["a"]) == [None]
    table.file.write_text("run,share\na,0.5\nb\n", encoding="utf-8")
    later = table.file.with_suffix(".parquet").stat().st_mtime_ns + 10**9
    os.utime(table.file, ns=(later, later))
    assert table.numbers("share", RUNS) == [0.5, None, None, None]


def test_a_table_that_is_not_there_has_no_columns(tmp_path: Path):
    table = SignatureTable(tmp_path / "signatures.csv")
    assert table.names() == [] and table.mark == (0, 0)


def test_a_table_of_more_runs_is_read_anew(table: SignatureTable):
    assert table.numbers("share", RUNS)[3] is None
    write_numbers(table.file.with_suffix(""), pd.DataFrame({"run": ["d", "c"], "share": [0.25, 0.1]}))
    assert table.numbers("share", RUNS) == [None, None, 0.1, 0.25]
