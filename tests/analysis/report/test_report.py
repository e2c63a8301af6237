"""What the report says, and the command that writes it."""

import re
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from analysis.form import form_of
from analysis.paper.methods import methods
from analysis.report import overview, render
from analysis.report.cards import cards, marked
from analysis.report.definitions import definitions
from analysis.report.limits import limits
from analysis.report.material import Material, gather
from analysis.report.provenance import (
    cost_grid,
    determinism_grid,
    failures_grid,
    ledger_grid,
    link,
    models_grid,
    period,
    runs_grid,
    world_differences,
)
from analysis.report.sections import (
    energy_grid,
    run_grids,
    variance_grid,
)
from analysis.signatures import discover
from browser import browser_page
from commands import foundry, refusal, succeeds
from foundry.records import Counts
from foundry.viewer.server import serving
from walkers import WORLD, make_condition, rewrite_run


def with_analysis(material: Material, **values: Any) -> Material:
    return replace(material, analysis=replace(material.analysis, **values))


def texts(grid: Any) -> list[list[str]]:
    return [[cell.text for cell in row] for row in grid.rows]


def test_the_ledger_counts_every_run_and_the_unreadable_decisions(hostile):
    rows = texts(ledger_grid(hostile))
    assert [row[1:5] for row in rows] == [["6", "5", "1", "0"], ["6", "5", "0", "1"], ["6", "6", "0", "0"]]
    assert rows[0][5:] == ["900", "60", "6.67 %"]
    assert rows[2][0] == "scripted/stay"
    assert rows[2][5:] == ["0", "0", "-"]


def test_the_first_screen_says_what_was_run_what_weakens_it_and_that_nothing_can_be_claimed(hostile):
    assert overview.facts(hostile) == [
        "2 models x 6 seeds in small", "10 of 12 runs", "3,300 calls, 0 tokens, 11 s of runs", "exploratory",
    ]  # fmt: skip
    models = dict.fromkeys(
        member.folder.config()["model"]["name"] for member in hostile.members if not member.shown.baseline
    )
    assert overview.warnings(hostile) == [f"Unreadable decisions of {model}: 6.67 %" for model in models]
    claims = overview.claims(hostile)
    assert claims.sentence == "No claim can be made: fewer than 6 seeds only describe these runs."
    assert claims.command.startswith("foundry preregister") and "seed=6-11 --family" in claims.command
    assert claims.cost == "about 3,300 calls, 11 s of runs"


def test_the_matrix_of_one_world_has_the_measures_with_the_largest_gaps(hostile):
    made = overview.matrix(hostile)
    measures = list(dict.fromkeys(finding.measure for finding in hostile.analysis.findings))[:5]
    assert [column.measure for column in made.columns] == [*measures, "", "", "", ""]
    assert [row[2][:2] for row in made.rows] == [("93.3 %", "1,800"), ("93.3 %", "1,500")]


@pytest.mark.slow
def test_the_matrix_of_worlds_shows_scores_between_the_blind_and_the_best_baseline(tmp_path):
    asked = ("model=scripted/random,scripted/first", "world=public_goods,fishery", "seed=0-1", "output.dir=games")
    succeeds("-m", *asked, "analyze=baselines", cwd=tmp_path)
    material = gather([tmp_path / "games"])
    made = overview.matrix(material)
    assert [(column.title, column.measure) for column in made.columns[:2]] == [
        ("public_goods", "public_goods.score"), ("fishery", "fishery.months"),
    ]  # fmt: skip
    random, first = made.rows
    assert (random[0].name, first[0].name) == ("random", "first")
    assert [cell.reach for cell in first[1]] == [1.0, 1.0] and random[1][1].reach == 0
    shown = cards(material, material.sweeps[0].path)
    assert len({card.finding.context for card in shown}) == 2, "no world fills all cards"
    assert not any(card.compared for card in cards(material, tmp_path)), "no viewer shows runs of another folder"
    for card in shown:
        assert {row.mark.name for row in card.rows} == {"random", "first"}
        assert card.finding.standing == "describes these runs" and card.test.startswith("2 seeds, not tested")
        step, agent = re.match(r"seed \d+, step (\d+), agent (\d+), ", card.where).groups()
        assert len(card.replies) == 2 and card.compared.endswith(f"?step={step}&agent={agent}")
    page_file = tmp_path / "games" / "report.html"
    page_file.write_text(render(material, page_file.parent, material.analysis.path / "plots"), encoding="utf-8")
    with serving(tmp_path / "games") as server, browser_page() as page:
        page.goto(f"{server.url}files/games/report.html")
        page.locator("a.compared").first.click()
        page.wait_for_function(
            "(address) => location.hash.startsWith(address)", arg=f"#/compare/games/{shown[0].compared}"
        )
        page.goto(page_file.as_uri())
        assert page.locator("a.compared:visible").count() == 0, "a file has no viewer beside it"


def test_words_that_differ_are_marked_around_the_first_difference():
    assert marked("go left", "go right") == ((("go ", False), ("left", True)), (("go ", False), ("right", True)))
    words = (("stay", True), (" ", True), ("here", True), (" now", False))
    assert marked("stay here now", "move there now")[0] == words
    assert marked("", "said") == ((("(empty)", True),), (("said", True),))
    first, second = marked("a " * 300 + "here", "a " * 300 + "there")
    assert first[0][0].startswith("…") and first[-1] == ("here", True) and second[-1] == ("there", True)


def test_runs_are_listed_with_causes_first_unreadable_decisions_and_links_of_those_that_started(hostile, hostile_sweep):
    grid = failures_grid(hostile, hostile_sweep.path)
    assert grid is not None
    ((run, _, seed, records, kind, cause),) = texts(grid)
    assert (seed, records, kind) == ("1", "150", "TransientError")
    assert cause.startswith("the server said <img")
    assert grid.rows[0][0].href == f"runs/{run}/"
    rows = texts(runs_grid(hostile, hostile_sweep.path))
    assert len(rows) == 18
    doubts = {row[0]: row[7] for row in rows}
    run = next(run for run in hostile_sweep.runs() if hostile.examples.doubts.get(run.id))
    step, agent = hostile.examples.doubts[run.id]
    assert doubts[run.id] == f"step {step}, agent {agent}"
    missing, member = next(member for member in hostile.members if member.summary is None), hostile.members[0]
    assert link(missing, hostile_sweep.path).href == ""
    assert link(member, hostile_sweep.path.parent / "pages").href == f"../sweep/runs/{member.folder.id}/"


def test_costs_are_added_up_by_group_with_the_share_of_prompts_that_servers_who_say_so_reused(hostile):
    rows = texts(cost_grid(hostile))
    assert rows[0][1] == "1,800"
    assert [row[6:8] for row in rows] == [["", "9.0"], ["", "7.5"], ["", rows[2][7]]]
    said = [Counts(prompt_tokens=100, cached_tokens=30), Counts(prompt_tokens=100, cached_tokens=20)]
    counts = [*said, Counts(prompt_tokens=100)]
    summaries = [msgspec.structs.replace(hostile.members[0].summary, counts=count) for count in counts]
    told = [replace(hostile.members[0], summary=summary) for summary in summaries]
    assert texts(cost_grid(with_analysis(hostile, members=tuple(told))))[0][6] == "25%"


def test_servers_that_do_not_repeat_themselves_are_said_beside_models_and_first(hostile):
    assert [row[1:6] for row in texts(determinism_grid(hostile.sweeps))] == [
        ["10 of 10", "5 of 5", "8 of 10", "4 of 5", "18"],
        ["10 of 10", "5 of 5", "10 of 10", "5 of 5", "18"],
    ]
    assert any("Q4_K_M's server repeats 8 of 10 calls exactly" in limit for limit in limits(hostile))


def test_the_period_is_from_the_first_start_that_is_known_to_the_last_end(hostile):
    times = [("", "2026-01-03T00:00:00"), ("2026-01-02T03:04:05.6+00:00", "2026-01-05"), ("2026-01-04", "2026-01-04")]
    ended = [member for member in hostile.members if member.summary is not None][: len(times)]
    told = [
        replace(one, summary=msgspec.structs.replace(one.summary, started=started, ended=end))
        for one, (started, end) in zip(ended, times, strict=True)
    ]
    missing = [member for member in hostile.members if member.summary is None]
    assert period(with_analysis(hostile, members=(*missing, *told))) == "2026-01-02 03:04:05 to 2026-01-05 UTC"
    assert period(with_analysis(hostile, members=tuple(missing))) == "no run has ended"


def test_models_stand_with_their_digests_first_warnings_with_run_and_step_and_groups_as_a_whole(hostile, hostile_sweep):
    assert {row[1] for row in texts(models_grid(hostile))} == {"f00d" * 16, "none"}
    ((title, grid),) = run_grids(hostile, hostile_sweep.path)
    assert title == "First warnings, step by step"
    assert [[cell.text for cell in row] for row in grid.rows] == [list(row) for row in hostile.examples.tables[0].rows]
    assert len(grid.rows) > 0
    assert {cell[0].href.split("/")[0] for cell in grid.rows} <= {"runs", "baselines"}
    assert energy_grid(hostile) is not None
    shares = variance_grid(hostile)
    assert shares.columns[0] == "measure"
    assert {"model", "seed", "residual"} <= set(shares.columns)


def test_methods_and_limits_say_plainly_what_was_really_done(hostile):
    design, measuring, statistics, software = methods(hostile.basis)
    assert "6 seeds (0 to 5)" in design
    assert "(digest f00df00df00d)" in design
    assert "16 of 18 runs are complete" in design
    assert "baselines scripted/stay" in design
    assert "rule" in measuring
    assert "Holm" not in statistics or "sign-flip" in statistics
    assert "foundry 0 (Python 3" in software
    first, second, *_ = limits(hostile)
    assert first.startswith("<script>")
    assert first.endswith("6.7% of 900 replies are unreadable (60 contain no decision)")
    assert second.endswith("6.7% of 750 replies are unreadable (50 contain no decision)")
    said = " ".join(limits(hostile))
    assert "only 5 complete seeds" in said
    assert "nothing is tested" in said
    assert "16 of 18 runs are complete" in said
    assert "of the action replies were readable" in said
    assert "Baselines are scripted" in said
    assert "In these runs, no person labelled which messages are warnings. Labels of warnings by rule 4: " in said
    assert "precision 0.90 (38 of 42)" in said
    assert "these values are upper bounds, because one language model wrote and labelled these texts" in said
    own = tuple(one for one in hostile.shown if not one.baseline)
    alone = with_analysis(
        hostile, shown=own, members=tuple(member for member in hostile.members if member.shown in own)
    )
    assert any(line.startswith("The sweep has no baselines") for line in limits(alone))


def test_definitions_say_what_chance_gives():
    (hazard,) = (signature for signature in discover() if signature.name == "hazard")
    (of_grids,) = definitions(hazard, [form_of("grid")])
    nulls = {block.name: block.null for block in of_grids.blocks if block.name}
    assert nulls["away_beyond_blind"] == "0: draws each step independently, without regard to fires"
    assert nulls["exposure"] == ""


@pytest.mark.parametrize("form", ["grid", "camera", "any"])
def test_every_signature_says_how_it_is_measured(form: str):
    for signature in discover():
        found = definitions(signature, [form_of(form)])
        assert signature.is_label or all(
            definition.module.startswith((f"analysis.{form}.signatures.", "analysis.any.signatures."))
            for definition in found
        )
        assert not found or any(block.name for definition in found for block in definition.blocks), signature.name


def test_worlds_that_differ_are_told_apart_setting_by_setting_and_those_that_agree_by_nothing(make_sweep):
    larger = {**WORLD, "steps": 26, "fires": WORLD["fires"][:1]}
    one = make_sweep([make_condition("a", [0])], name="one")
    other = make_sweep([make_condition("a", [0], world=larger)], name="other")
    found = {row[0]: row[1:] for row in world_differences([one, other])}
    assert found["steps"] == ("25", "26")
    assert found["fires[1].name"] == ('"blaze2"', "none")
    assert "agents" not in found
    assert world_differences([one, make_sweep([make_condition("b", [0])], name="b")]) == []


def test_the_command_writes_a_page_of_a_sweep_without_any_complete_run_and_none_where_a_folder_is(make_sweep, tmp_path):
    sweep = make_sweep([make_condition("a", [0, 1])])
    rewrite_run(sweep.runs()[0], "failed")
    rewrite_run(sweep.runs()[1], "unfinished")
    said = succeeds("report", str(sweep.path), cwd=tmp_path).stdout
    assert said.startswith(f"report of 0 complete runs of 2 in {sweep.report_file}; ")
    assert said.endswith(f"; go on with: foundry resume {sweep.path}\n")
    page = sweep.report_file.read_text(encoding="utf-8")
    assert "the server went away" in page
    assert "is a folder" in refusal("report", str(sweep.path), "--out", str(tmp_path), cwd=tmp_path)
    assert foundry("report", str(tmp_path / "none"), cwd=tmp_path).returncode == 2
