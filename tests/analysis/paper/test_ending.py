"""How an analysis ends on a terminal."""

import math
import shlex

import numpy as np
import pytest

from analysis.findings.study_matrix import Matrix, MatrixCell, MatrixColumn, MatrixRow
from analysis.paper.ending import MOST_LINES, WIDEST, EndingContent, command_lines, ending, means_of
from analysis.paper.gaps import short_names
from analysis.paper.sentence import Sides
from analysis.paper.study import on_new_seeds, short_contexts, study
from analysis.prose import text_width
from analysis.stats.contrasts import contrasts
from analysis.tables.comparison import compare
from analysis.tables.groups import swept_columns
from commands import foundry
from signature_tables import runs, table

SAME = [0.31, 0.52, 0.33, 0.24, 0.45, 0.36, 0.27, 0.48]
MEASURES = ("idle_rate.chosen", "communication.rate", "stability.persistence", "place_choice.share_cafe")
NOTES = ("a note " * 30, "another note " * 30, "a last one")


def told_of(values: dict[str, dict[str, list[float]]], **fields) -> EndingContent:
    made = table(
        [
            {"model": model, "seed": seed, **{name: own[seed] for name, own in by_measure.items()}}
            for model, by_measure in values.items()
            for seed in range(len(next(iter(by_measure.values()))))
        ]
    )
    columns = swept_columns(made)
    usual = {"notes": (), "study": "a study", "folders": "out", "tables": "out/analysis"}
    family = list(next(iter(values.values())))
    rows, compared = contrasts(made, columns, family=family), compare(made, columns)
    return EndingContent(
        contrasts=rows,
        sides=Sides.of(rows, compared, {}),
        means=means_of(compared, family),
        again=lambda measures, pairs: f"foundry preregister {pairs} {' '.join(measures)}",
        **{**usual, **fields},
    )


def end(values: dict[str, dict[str, list[float]]], **told) -> list[str]:
    return ending(told_of(values, **told), 80, printed=1)


def noisy(model: int, measure: int, shift: float = 0.0, seeds: int = 8) -> list[float]:
    return (shift + np.random.default_rng([model, measure]).normal(0.4, 0.05, seeds)).tolist()


def many(models: int, seeds: int = 8) -> dict[str, dict[str, list[float]]]:
    """Return values of models that all differ in every measure."""
    return {
        f"served/{model}-a-long-name-of-a-model:70b": {
            name: noisy(model, place, 0.5 * model * (place + 1), seeds) for place, name in enumerate(MEASURES)
        }
        for model in range(models)
    }


@pytest.mark.parametrize(("models", "seeds"), [(1, 8), (2, 12), (3, 2), (7, 2), (7, 12)])
def test_an_ending_has_at_most_twenty_lines_and_fits_the_terminal(models: int, seeds: int):
    content = told_of(many(models, seeds), notes=NOTES[2:], study="served models x seeds, world cafe_library")
    for width in (80, 120):
        lines = ending(content, width, printed=1)
        assert len(lines) + 1 <= MOST_LINES
        texts = [line for line in lines if "out/analysis" not in line and "out   " not in line]
        assert max(map(text_width, texts)) <= min(width, WIDEST)


def test_thresholds_stand_above_the_findings_and_take_their_room():
    told = [f"naming.turned of model {name} prevails from world.committed = 0.15 [0.1, 0.2]." for name in range(5)]
    lines = end(many(7), notes=NOTES[2:], thresholds=told)
    assert lines[2:5] == told[:3] and lines[5] == "2 further thresholds: out/analysis/thresholds.csv"
    assert len(lines) + 1 <= MOST_LINES


def test_the_tests_of_all_factors_are_counted_and_no_difference_is_told_of_what_was_declared():
    rows = [
        run
        for place, (name, world) in enumerate([("a", "x"), ("b", "x"), ("a", "y"), ("b", "y")])
        for run in runs(name, noisy(place, 0, place, 12), MEASURES[0], world=world)
    ]
    assert plainly_told(rows)[2].startswith("Findings: 4 of 4 tests show a difference")
    rng = np.random.default_rng(3)
    rows = [run for name in "ab" for run in runs(name, rng.normal(0.4, 0.1, 8).tolist(), MEASURES[0])]
    lines = plainly_told(rows, claim="declared", look=1)
    assert lines[2] == "Findings: 0 of 1 test shows a difference"
    assert lines[3].startswith("  No difference was found between b and a in idle_rate.chosen: 0.0")


def plainly_told(rows: list[dict[str, object]], **changes: object) -> list[str]:
    made = table(rows)
    columns = swept_columns(made)
    frame = contrasts(made, columns, family=MEASURES[:1]).assign(**changes)
    sides = Sides.of(frame, compare(made, columns), {})
    return ending(EndingContent(frame, sides, (), "a study", "out", "out/analysis", lambda *_: ""), 100)


def test_several_worlds_are_a_row_each_with_their_own_score_between_blind_and_best():
    heads = (MatrixColumn("bar", "Nearness", "bar.score", "bar", 50.0, 100.0), MatrixColumn("maze", world="maze"))
    cells = [(MatrixCell(f"{score} [60, 90]"), MatrixCell("no score of its own")) for score in (71, 82)]
    rows = tuple(MatrixRow(name, (), own) for name, own in zip("ab", cells, strict=True))
    values = {name: {MEASURES[0]: [0.1, 0.2, 0.3]} for name in "ab"}
    lines = end(values, matrix=Matrix("", heads, rows))
    place = next(index for index, line in enumerate(lines) if "score in" in line)
    assert lines[place].split() == ["score", "in", "a", "b", "blind", "best"]
    assert lines[place + 1].split() == ["bar", "71", "82", "50", "100"]
    assert lines[place + 2].count("no score of its own") == 2
    assert not any("largest gap [" in line for line in lines)


def test_two_models_are_told_with_the_difference_and_its_interval():
    lines = end({"a": {MEASURES[0]: noisy(0, 0)}, "b": {MEASURES[0]: noisy(1, 0, 0.4)}})
    said = " ".join(line.strip() for line in lines[3:5])
    assert said.startswith("b stays where it is more often than a: 0.8") and said.endswith(
        "difference 0.39 [0.34, 0.44]"
    )


def test_where_nothing_can_be_claimed_the_largest_gaps_and_the_command_for_new_seeds_stand():
    values = {name: {MEASURES[0]: noisy(at, 0, 0.4 * at, 4), MEASURES[1]: SAME[:4]} for at, name in enumerate("abc")}
    lines = end(values)
    assert lines[2] == "No claim can be made: fewer than 6 seeds only describe these runs."
    head, first, second = lines[4:7]
    assert head.split() == ["a", "b", "c", "largest", "gap", "[95", "%]"]
    assert first.split()[:3] == ["Chose", "to", "stay"] and "c - a" in first and "0.8" in first
    assert second.startswith("  communication.rate")
    assert lines[7:9] == [
        "To test the largest differences, declare them and run new seeds:",
        "  foundry preregister 3 idle_rate.chosen",
    ]


def test_no_difference_is_not_told_as_the_same_and_without_a_seed_in_common_there_is_no_table():
    rng = np.random.default_rng(3)
    values = {name: {MEASURES[0]: rng.normal(0.4, 0.1, 8).tolist()} for name in "ab"}
    assert end(values)[2].startswith("1 test found no difference; this does not show that the models behave")
    lost = [math.nan] * 2
    values = {"a": [0.1, 0.2, *lost], "b": [*lost, 0.3, 0.4]}
    lines = end({model: dict.fromkeys(MEASURES, own) for model, own in values.items()})
    assert lines[2:4] == ["No claim can be made: no seed has a value for both.", ""] and lines[4].startswith("Look at")


def test_notes_without_room_are_counted_with_their_file():
    lines = end({"a": {MEASURES[0]: SAME}}, notes=NOTES)
    start = next(place for place, line in enumerate(lines) if line.startswith("Look out  a note a note"))
    assert "          2 further notes: out/analysis/summary.md" in lines[start:]
    assert lines[-2].startswith("Look at   foundry view out ")


def test_a_single_model_is_shown_with_its_means():
    lines = end({"a": {MEASURES[0]: SAME, MEASURES[1]: [math.nan] * 8}})
    assert lines[2] == "Nothing is compared. Means over seeds [95 %]:"
    assert lines[3].split()[:2] == ["idle_rate.chosen", "0.37"]


def test_names_are_short_and_stay_apart():
    assert short_names(["scripted/a", "scripted/b"]) == {"scripted/a": "a", "scripted/b": "b"}
    assert short_names(["scripted/a", "qwen3:4b"]) == {"scripted/a": "scripted/a", "qwen3:4b": "qwen3:4b"}
    long = {"x" * 20 + "1" + "y" * 20, "x" * 20 + "2" + "y" * 20}
    assert len(set(short_names(long).values())) == 2
    alike = ["world=office, prompt=office", "world=cafe, prompt=cafe"]
    assert list(short_contexts(alike).values()) == ["office", "cafe"]
    assert list(short_contexts(["world=a, prompt=p", "world=a, prompt=q"]).values()) == ["a, p", "a, q"]


def test_a_study_is_told_by_what_was_compared():
    made = table([run for world in "xy" for model in "ab" for run in runs(model, SAME, world=world)])
    compared = compare(made, swept_columns(made))
    worlds = [{"name": "x", "agents": 6}, {"name": "y", "agents": 8}]
    assert study(compared, worlds, ["exploratory"]) == "2 models x 2 worlds x 8 seeds, worlds x and y, exploratory"
    assert study(compared, [worlds[0]] * 2, ["declared"]).endswith("seeds, world x (6 agents), declared")
    assert study(compared, [worlds[0], {"name": "x", "agents": 9}], []).endswith("seeds, world x")


def test_the_command_for_new_seeds_asks_for_the_same_study_and_for_as_many_seeds_as_a_test_needs():
    first = ("-m", "model=a,b", "world.agents=6", "seed=0-3", "output.dir=out")
    asked = [first, ("model=c", "seed=0-3")]
    assert on_new_seeds(asked, range(4), ["x.y"], 3, 0.05) == (
        "foundry preregister -m model=a,b,c world.agents=6 seed=4-10 --family x.y"
    )


def test_a_long_command_breaks_between_its_arguments_and_a_shell_reads_it_as_one():
    command = "foundry preregister -m model=a,b,c 'world.fires=[{x: 1, y: 2}]' seed=4-10 --family x.y"
    lines = command_lines(command, 44)
    assert len(lines) > 2 and max(map(len, lines)) <= 44
    assert shlex.split("\n".join(lines).replace("\\\n", "")) == shlex.split(command)


@pytest.mark.slow
def test_a_study_of_the_shipped_world_ends_with_who_flees_who_stays_and_who_warns(tmp_path):
    models = "model=scripted/random,scripted/avoid,scripted/seek"
    done = foundry("-m", models, "seed=0-8", "world.steps=20", "output.dir=out", cwd=tmp_path)
    lines = done.stdout.splitlines()
    start = next(place for place, line in enumerate(lines) if line.startswith("27 of 27 runs complete in out, "))
    last = lines[start:]
    assert len(last) <= MOST_LINES and max(map(len, last)) <= WIDEST
    for said in (
        "avoid steps away from fires more than every other model",
        "seek stays where it is more",
        "avoid warns its",
    ):
        assert any(line.startswith(f"  {said}") for line in last), last
