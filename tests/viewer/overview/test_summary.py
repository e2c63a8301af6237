"""What the analysis found of each group, read from its tables."""

from __future__ import annotations

import json
import re
from pathlib import Path

import msgspec
import pytest

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
    found = summary_of(made, ["path.success"], SignatureTable(made.signatures_path))
    assert found.columns == ["model"] and found.part == ""
    assert [(one.values, one.baseline) for one in found.groups] == [
        (["first"], False),
        (["=second"], False),
        (["random"], True),
    ]
    assert found.groups[0].measures == {"path.success": (0.5, 0.25, 0.75, 2)}
    assert found.groups[1].measures == {"path.success": (0.0, None, None, 2)}
    assert found.group_of == [0, None, 1, 1]


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
    assert (found.sentence, found.label, [msgspec.structs.asdict(one) for one in found.moments]) == (
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
