"""The findings that an analysis writes, and the moments that are their examples."""

import json
import re
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import foundry
from analysis.findings.moments import ALL_BUT_OWN_WORDS, MESSAGE, PROMPT, first_moment
from analysis.findings.ranking import findings
from analysis.paper.sentence import Sides
from analysis.paper.summary import EXPLORES
from analysis.stats.contrasts import contrasts
from analysis.tables.comparison import compare
from analysis.tables.groups import swept_columns
from foundry.storing.run_files import calls_bytes
from foundry.storing.store import RunFolder, SweepFolder
from signature_tables import table

WORLD = ("world.agents=4", "world.steps=4")


@pytest.mark.slow
def test_every_analysis_writes_the_largest_gaps_with_recorded_moments_the_matrix_and_the_furthest_runs(
    tmp_path, monkeypatch
):
    swept = tmp_path / "sweep"
    foundry.sweep("model=scripted/random,scripted/stay,scripted/echo", "seed=0-3", f"output.dir={swept}", *WORLD)
    with pytest.raises(foundry.InputError, match=r"findings.json' does not exist. Run foundry analyze .*sweep first"):
        _ = foundry.load(swept).findings
    analysed = foundry.analyze(swept, plots=False)
    first = (swept / "analysis" / "findings.json").read_bytes()
    assert EXPLORES in analysed.summary
    frame = foundry.load(swept).findings
    assert len(frame) == len(json.loads(first)) > 3
    assert set(frame["standing"]) == {"describes these runs"} and (frame["difference"].abs() > 0).all()
    idle = frame[frame["measure"] == "idle_rate.chosen"].iloc[0]
    assert idle["sentence"].startswith("In these runs scripted/stay stays where it is more often than scripted/")
    assert idle["value"] == 1 and idle["low"] <= idle["difference"] <= idle["high"]
    calls = foundry.load(swept).calls
    for finding in frame.itertuples():
        assert bool(finding.moments) != bool(finding.no_moments)
        for moment in finding.moments:
            assert_is_recorded(moment, finding, calls)
    assert idle["moments"][0]["step"] == 1 and idle["moments"][0]["question"] == "action"
    assert_runs_part_where_their_calls_do(swept)
    assert_matrix_and_furthest_runs_are_written(swept, analysed)
    monkeypatch.setattr("analysis.findings.furthest.MOST", 12)
    assert len(far := analysed.furthest) > 5 and min(one.distance for one in far) > 0
    foundry.analyze(swept, plots=False)
    assert (swept / "analysis" / "findings.json").read_bytes() == first


def assert_runs_part_where_their_calls_do(swept: Path) -> None:
    events = foundry.load(swept).events
    partings = events[events["event"] == "first_parting"].set_index("run")
    runs = SweepFolder.open(swept).runs()
    assert set(partings.index) == {run.id for run in runs}
    for seed, first in enumerate(runs[:4]):
        stay, echo = runs[4 + seed], runs[8 + seed]
        steps = []
        for run, question in ((stay, ""), (echo, MESSAGE)):
            moment, row = first_moment(first, run, seed, question), partings.loc[run.id]
            assert (row["step"], row["agent"]) == (moment.step, moment.agent)
            asked = f"on {moment.question} after the same prompt"
            said = f"agent {moment.agent} decides differently from scripted/random {asked}"
            assert row["text"] == said
            steps.append(moment.step)
        assert partings.loc[first.id]["step"] == min(steps)


def assert_matrix_and_furthest_runs_are_written(swept: Path, analysed: foundry.Analysis) -> None:
    written = json.loads((swept / "analysis" / "overview.json").read_bytes())
    rows = written["matrix"]["rows"]
    assert [row["name"] for row in rows] == ["random", "stay", "echo"]
    assert [column["measure"] for column in written["matrix"]["columns"]] == list(
        dict.fromkeys(finding.measure for finding in analysed.findings)
    )[:5]
    far = written["furthest"]
    assert [written["labels"][one["measure"]] for one in far] == [one["label"] for one in far]
    assert len({one["run"] for one in far}) == len(far) == 5
    assert [one["distance"] for one in far] == sorted((one["distance"] for one in far), reverse=True)
    values = analysed.runs.set_index("run")[far[0]["measure"]]
    of_group = [run for run in values.index if run.rsplit("-s", 1)[0] == far[0]["run"].rsplit("-s", 1)[0]]
    away = (values[of_group] - values[of_group].mean()).abs()
    assert far[0]["run"] in away[away == away.max()].index


def assert_is_recorded(moment: dict[str, Any], finding: Any, calls: Any) -> None:
    asked = calls[
        (calls["step"] == moment["step"]) & (calls["agent"] == moment["agent"]) & (calls["kind"] == moment["question"])
    ]
    level, reference = (asked[asked["run"] == moment[f"{side}_run"]].iloc[0] for side in ("level", "reference"))
    assert (level["model"], reference["model"]) == (finding.level, finding.reference)
    assert level["seed"] == reference["seed"] == moment["seed"]
    assert (level["reply"], reference["reply"]) == (moment["level_reply"], moment["reference_reply"])
    assert (level["prompt_text"] == reference["prompt_text"]) == (moment["asked"] == PROMPT)


def test_a_moment_is_found_behind_the_own_words_of_an_agent_and_never_behind_those_of_others(tmp_path):
    path = foundry.sweep(
        "model=scripted/random,scripted/stay,scripted/echo", "seed=0", f"output.dir={tmp_path / 'sweep'}", *WORLD
    ).path
    random, stay, echo = SweepFolder.open(path).runs()
    assert (moment := first_moment(random, stay, 0, "")) is not None and moment.asked == PROMPT
    talks = first_moment(echo, stay, 0, MESSAGE)
    assert '"message": null' in talks.reference_reply
    for told, asked in (("This I said.", ALL_BUT_OWN_WORDS), ("Somebody else said this.", "")):
        say_and_tell(stay, "This I said.", told)
        behind = first_moment(random, stay, 0, "")
        assert behind == (msgspec.structs.replace(moment, asked=asked) if asked else None)


def say_and_tell(run: RunFolder, said: str, told: str) -> None:
    """Have all agents of a run say a text, and be told one at the end of every prompt for an action."""
    file = run.path / "steps.jsonl"
    lines = [json.loads(line) | {"message": said} for line in file.read_text().splitlines()]
    file.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    calls = [
        msgspec.structs.replace(call, messages=[{**call.messages[-1], "content": call.messages[-1]["content"] + told}])
        if call.kind != MESSAGE
        else call
        for call in run.calls()
    ]
    (run.path / "calls.jsonl.zst").write_bytes(calls_bytes(calls))


def test_only_what_was_declared_and_tested_stands_and_a_gap_says_whether_its_interval_includes_0():
    values = np.random.default_rng(1).normal(0.4, 0.05, 8)
    shifts = {"idle_rate.chosen": (values + 0.3).tolist(), "communication.rate": values[::-1].tolist()}
    made = table(
        [
            {"model": model, "seed": seed, **{name: own[seed] for name, own in by_measure.items()}}
            for model, by_measure in (("a", dict.fromkeys(shifts, values.tolist())), ("b", shifts))
            for seed in range(8)
        ]
    )
    columns = swept_columns(made)
    for claim in ("declared", "exploratory"):
        rows = contrasts(made, columns, family=list(shifts)).assign(claim=claim, look=1)
        sides = Sides.of(rows, compare(made, columns), {})
        idle, talk = findings(rows[rows["headline"]].to_dict("records"))
        assert (idle.measure, idle.stands, talk.stands) == ("idle_rate.chosen", claim == "declared", False)
        assert idle.plain(sides, {}).startswith("b stays where it is more often than a: 0.7")
        said = talk.plain(sides, {})
        if claim == "declared":
            assert re.fullmatch(
                r"No difference was found between [ab] and [ab] in communication\.rate: 0\.\d+ against 0\.\d+, "
                r"difference \S+ \[-\S+, \S+\], 8 seeds\.", said
            )  # fmt: skip
        else:
            assert said.startswith("In these runs ") and said.endswith("(the interval includes 0), 8 seeds.")
