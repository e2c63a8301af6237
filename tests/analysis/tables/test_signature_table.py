"""The table of signatures and the whole analysis."""

import hashlib
import math
from pathlib import Path

import joblib
import msgspec
import pandas as pd
import pytest

import analysis
from analysis import signatures
from analysis.any.any_run import AnyRun
from analysis.figures.members import shown_groups
from analysis.grid.grid_run import GridRun
from analysis.load import read_records, read_run
from analysis.measuring import runs
from analysis.measuring.runs import measure_run, sources_of
from analysis.pipeline import Analysis
from analysis.tables.comparison import Comparison, compare
from analysis.tables.groups import group_columns
from analysis.tables.signature_table import SignatureTable, build_table
from analysis.tables.texts import comparison_table
from commands import succeeds
from foundry.errors import InputError, RecordError
from foundry.own_code import use
from foundry.storing.store import SweepFolder
from walkers import WORLD, Habits, make_condition, rewrite_run, write_sweep


def analyze(folders: list[Path]) -> Analysis:
    return analysis.analyze(folders, plots=False)


def measured(*folders: SweepFolder) -> tuple[SignatureTable, Comparison]:
    """Return the runs of sweeps and of the baselines beside them, and the groups that an analysis would compare."""
    sources = sources_of(folders, [folder.path.name for folder in folders], labelled_by_model=False)
    results = [measure_run(run, source) for source in sources for run in source.folder.runs()]
    table = build_table(results)
    return table, compare(table, group_columns(results, table))


def compared(*folders: SweepFolder) -> Comparison:
    return measured(*folders)[1]


def test_a_row_per_run_and_steps_without_their_texts_are_written_in_the_order_of_the_sweep(make_sweep):
    folder = make_sweep(
        [make_condition(model, range(2)) for model in ("still", "lively")],
        {"still": Habits(move=0.2, unreadable=0), "lively": Habits(move=0.95, unreadable=0.3)},
    )
    two_models = analyze([folder.path])
    table = pd.read_csv(two_models.path / "signatures.csv")
    assert list(table.columns[:6]) == ["run", "world", "model", "prompt", "seed", "status"]
    assert table["model"].tolist() == ["still"] * 2 + ["lively"] * 2
    assert table["seed"].tolist() == [0, 1] * 2
    assert (table["failure.rate"] == 0).all()
    pd.testing.assert_frame_equal(pd.read_parquet(two_models.path / "signatures.parquet"), two_models.runs)
    pd.testing.assert_frame_equal(table, two_models.runs)
    names = [column.partition(".")[0] for column in two_models.runs.columns if "." in column]
    assert names == sorted(names, key=list(dict.fromkeys(names)).index)
    expected = {
        signature.name for signature in signatures.discover() if signature.part(GridRun) and not signature.is_label
    }
    elsewhere = {
        "utility",
        "evacuation",
        "survival",
        "certainty",
    }  # of other worlds, and of servers that tell probabilities
    assert set(names) == {"failure", *expected} - elsewhere
    steps = pd.read_parquet(two_models.path / "steps.parquet")
    assert not {"message", "memory", "reasoning", "message_reasoning"} & set(steps.columns)
    assert len(steps) == 4 * 25 * 6
    assert steps["outcome"].isin(["chosen", "repaired", "unreadable", "empty", "failed"]).all()
    assert any(note.startswith("lively: only") for note in two_models.notes)


def test_failed_and_unfinished_runs_have_a_row_and_no_values(make_sweep):
    folder = make_sweep([make_condition("a", [0, 1, 2])])
    rewrite_run(folder.runs()[0], "failed")
    rewrite_run(folder.runs()[1], "unfinished")
    analysis = analyze([folder.path])
    assert analysis.runs["status"].tolist() == ["failed", "unfinished", "complete"]
    assert analysis.runs["failure.rate"].tolist()[0] == 1
    assert math.isnan(analysis.runs["failure.rate"][1])
    assert analysis.runs["idle_rate.chosen"].isna().tolist() == [True, True, False]
    assert any("1 of 3 runs are complete; missing: 1 failed, 1 unfinished" in note for note in analysis.notes)
    rates = analysis.comparison.set_index("measure").loc["failure.rate"]
    assert (rates["n"], rates["mean"]) == (2, 0.5)
    rewrite_run(folder.runs()[2], "failed")
    assert analyze([folder.path]).declared == (), "nothing is complete"


def of_agents(world, agents, seeds):
    values, world = {"world.agents": agents}, {**world, "agents": agents}
    return make_condition("a", seeds, factors=("world.agents",), values=values, world=world)


def limited(world, limit, seeds=range(6)):
    values, world = {"world.limit": limit}, {**world, "limit": limit}
    return make_condition("a", seeds, factors=("world.limit",), values=values, world=world)


@pytest.mark.slow
def test_null_is_a_value_of_a_swept_setting_like_any_other(make_sweep):
    conditions = [limited({**WORLD, "steps": 3}, limit) for limit in (None, 2)]
    analysis = analyze([make_sweep(conditions).path])
    assert analysis.compared.groups == [("a", "none"), ("a", "2")]
    rates = analysis.comparison.set_index("measure").loc["failure.rate"]
    assert rates["world.limit"].tolist() == ["none", "2"]
    assert (rates["n"].tolist(), rates["runs"].tolist()) == ([6, 6], [6, 6])
    pairs = analysis.contrasts[["factor", "level", "reference"]].drop_duplicates()
    assert pairs.values.tolist() == [["world.limit", "2", "none"]]
    assert pd.read_csv(analysis.path / "comparison.csv")["world.limit"].unique().tolist() == ["none", "2"]


def test_a_setting_that_one_world_has_and_another_lacks_tells_groups_apart(make_sweep):
    world = {**WORLD, "steps": 3}
    conditions = [limited(world, limit, range(1)) for limit in ("few", "many")]
    other = make_condition("a", range(1), world={**world, "name": "other"})
    comparison = compared(make_sweep([*conditions, other]))
    assert comparison.groups == [("a", "small", "few"), ("a", "small", "many"), ("a", "other", "none")]


@pytest.mark.slow
def test_several_sweeps_are_taken_together_and_a_setting_swept_in_one_is_looked_up_in_the_other(make_sweep):
    first = make_sweep([of_agents(WORLD, n, [0]) for n in (2, 6)], name="first")
    second = make_sweep([make_condition("b", [0])], name="second")
    analysis = analyze([first.path, second.path])
    assert analysis.path == first.path / "analysis_with_second" and not second.analysis_dir.exists()
    assert [file.name for file in first.analysis_dir.iterdir()] == ["measured.sqlite"]
    assert analysis.runs["sweep"].tolist() == ["first", "first", "second"]
    assert analysis.runs["world.agents"].tolist() == [2, 6, 6]
    assert analysis.compared.group_columns == ("model", "world.agents")
    assert analysis.compared.groups == [("a", "2"), ("a", "6"), ("b", "6")]
    assert "world.agents" not in set(analysis.comparison["measure"])
    steps = pd.read_parquet(analysis.path / "steps.parquet")
    assert steps["sweep"].value_counts().to_dict() == {"first": 25 * 8, "second": 25 * 6}


def test_worlds_of_one_name_that_differ_are_told_apart(make_sweep):
    first = make_sweep([make_condition("a", [0])], name="first")
    other = make_condition("a", [0], world={**WORLD, "communication_distance": 4})
    second = make_sweep([other], name="second")
    assert compared(first, second).groups == [
        ("a", "small [communication_distance=2.5]"),
        ("a", "small [communication_distance=4]"),
    ]


def test_models_of_one_name_with_many_other_settings_are_told_apart_by_a_hash_and_not_by_their_server(make_sweep):
    settings = ({"options": {"temperature": 0.1, "top_k": 40, "top_p": 0.9}}, {"think": True}, {"think": True})
    folders = [
        make_sweep([make_condition("a", [0], model_settings={**one, "server": {"hosts": [f"host{n}"]}})], name=f"s{n}")
        for n, one in enumerate(settings)
    ]
    groups = compared(*folders).groups
    assert len(groups) == 2
    assert all(group[0].startswith("a #") for group in groups)


def schemas(most: int) -> dict[str, object]:
    return {"schemas": {"action": {"type": "object", "properties": {"reasoning": {"maxLength": most}}}}}


def test_baselines_of_several_worlds_are_told_apart_by_their_world_and_by_no_prompt(make_sweep):
    def of(model: str) -> list[object]:
        return [
            make_condition(
                model,
                [0],
                world={**WORLD, "name": name},
                prompt=name,
                prompt_settings={"templates": {"action": f"You are in the {name}. Where do you go?"}},
            )
            for name in ("hall", "room")
        ]

    folder = make_sweep(of("a"))
    write_sweep(folder.baselines_dir, of("b"))
    comparison = compared(folder)
    assert comparison.groups == [
        ("a", "hall", "hall"),
        ("a", "room", "room"),
        ("b", "hall", "any"),
        ("b", "room", "any"),
    ]
    assert comparison_table(comparison).columns[3:] == ("b / hall (baseline)", "b / room (baseline)")


def test_a_model_is_one_in_worlds_that_bring_schemas_of_their_own_and_two_by_schemas_within_one_world(make_sweep):
    comparison = compared(
        make_sweep(
            [
                make_condition(model, [0], world={**WORLD, "name": world}, model_settings=schemas(most))
                for world, most in (("hall", 100), ("room", 200))
                for model in "ab"
            ]
        )
    )
    assert comparison.groups == [("a", "hall"), ("a", "room"), ("b", "hall"), ("b", "room")]
    assert len({shown_group.colour for shown_group in shown_groups(comparison)}) == 2
    folders = [make_sweep([make_condition("a", [0], model_settings=schemas(most))], name=f"s{most}") for most in (1, 2)]
    first, second = (group[0] for group in compared(*folders).groups)
    assert first != second and first.startswith("a #") and second.startswith("a #")


@pytest.mark.slow
def test_many_runs_are_measured_in_processes_with_the_same_result(monkeypatch, make_sweep, tmp_path: Path):
    monkeypatch.setattr(runs, "PARALLEL_FROM", 18)
    broken = tmp_path / "earlier" / "signatures" / "broken.py"
    broken.parent.mkdir(parents=True)
    broken.write_text("1 / 0\n", encoding="utf-8")
    joblib.Parallel(n_jobs=-1)(joblib.delayed(use)([tmp_path / "earlier"]) for _ in range(8))
    folder = make_sweep([make_condition("a", range(18), world={**WORLD, "steps": 2, "agents": 2})])
    frame = analyze([folder.path]).runs
    one = folder.runs()[17]
    values = signatures.measure(read_run(one, read_records(one, one.summary())))
    assert frame["seed"].tolist() == list(range(18))
    assert frame.iloc[17][list(values)].to_dict() == pytest.approx(values, nan_ok=True)


def test_no_folder_one_that_is_given_twice_and_a_damaged_run_are_refused(make_sweep):
    folder = make_sweep([make_condition("a", [0])])
    with pytest.raises(InputError, match="at least one"):
        analyze([])
    with pytest.raises(InputError, match="more than once"):
        analyze([folder.path, folder.path])
    (folder.runs()[0].path / "steps.jsonl").write_bytes(b"")
    with pytest.raises(RecordError, match=r"steps\.jsonl"):
        analyze([folder.path])


def test_runs_whose_world_nobody_knows_are_measured_by_what_all_forms_have(make_sweep):
    folder = make_sweep([make_condition("a", [0], declared=None)])
    table, _ = measured(folder)
    names = {name.partition(".")[0] for name in table.measures}
    general = {
        signature.name for signature in signatures.discover() if any(part.run is AnyRun for part in signature.parts)
    }
    assert "outcome" in names and names <= {"failure", *general}
    assert table.frame["outcome.readable"].notna().all()


def test_runs_that_hold_no_decisions_are_listed_without_signatures(make_sweep):
    folder = make_sweep([make_condition("a", [0], declared=None)])
    (run,) = folder.runs()
    said = msgspec.json.decode((run.path / "run.json").read_bytes())
    lines = b'{"turn": 1, "who": 0}\n'
    said["records_sha256"]["steps.jsonl"] = hashlib.sha256(lines).hexdigest()
    (run.path / "steps.jsonl").write_bytes(lines)
    (run.path / "run.json").write_bytes(msgspec.json.encode(said))
    analysis = analyze([folder.path])
    assert analysis.runs["failure.rate"].tolist() == [0] and analysis.declared == ()
    assert any("world small recorded no decisions" in note for note in analysis.notes)


@pytest.mark.parametrize(("sampling", "noted"), [("1,2", True), ("null", False)])
def test_a_note_names_models_whose_seeds_are_copies_of_one_run(tmp_path, sampling, noted):
    succeeds(
        "-m", "world=bar", "world.agents=3", "world.steps=4", "model=scripted/random", "seed=0-2",
        f"sampling_seed={sampling}", "analyze=false", "runner.workers=1", "output.dir=sweep", cwd=tmp_path,
    )  # fmt: skip
    said = [note for note in analyze([tmp_path / "sweep"]).notes if "no more than one run" in note]
    assert [note.partition(":")[0] for note in said] == ["scripted/random"] * noted
