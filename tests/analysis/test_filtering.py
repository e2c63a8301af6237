"""A part of the runs: what is taken, and that whoever reads the tables is told."""

import json
from pathlib import Path

import pandas as pd
import pytest

from analysis import analyze
from analysis.report.limits import limits
from analysis.report.material import gather
from analysis.report.provenance import commands_of
from commands import foundry
from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from walkers import WORLD, make_condition, write_sweep

MODELS, PROMPTS, SEEDS, BASELINES = ("good", "bad"), ("paper", "japanese"), (0, 1, 2), ("random", "stay")
SMALL = {**WORLD, "agents": 3, "steps": 4}


@pytest.fixture(scope="module")
def swept(tmp_path_factory) -> Path:
    """Two models, two prompts, three seeds, and baselines beside them."""
    path = tmp_path_factory.mktemp("filtered") / "sweep"
    own = [
        make_condition(one, SEEDS, ("model", "prompt"), prompt=prompt, world=SMALL)
        for one in MODELS
        for prompt in PROMPTS
    ]
    write_sweep(path, own)
    write_sweep(path / "baselines", [make_condition(f"scripted/{one}", SEEDS, world=SMALL) for one in BASELINES])
    return path


def taken(path: Path, *, only: tuple[str, ...] = (), without: tuple[str, ...] = ()) -> set[tuple[str, str, int]]:
    runs = analyze(path, plots=False, only=only, without=without).runs
    own = runs[~runs["baseline"]] if "baseline" in runs else runs
    return {(str(row.model), str(row.prompt), int(row.seed)) for row in own.itertuples()}


def baselines(path: Path) -> set[str]:
    runs = pd.read_csv(path / "analysis" / "signatures.csv")
    return set(runs.loc[runs["baseline"], "model"])


def test_runs_are_taken_by_what_they_are(swept):
    found = taken(swept, only=("seed=1-2", "prompt=paper", "prompt=japanese"), without=("model=bad",))
    assert found == {("good", prompt, seed) for prompt in PROMPTS for seed in (1, 2)}
    assert taken(swept, only=("model=good,bad", "prompt=paper", "seed=0")) == {(model, "paper", 0) for model in MODELS}
    assert baselines(swept) == {"scripted/random", "scripted/stay"}


@pytest.mark.slow
def test_null_is_asked_for_like_any_other_value_of_a_setting(tmp_path):
    conditions = [
        make_condition(f"of_{limit}", (0,), ("model.limit",), values={"model.limit": limit}, world=SMALL)
        for limit in (None, 2)
    ]
    write_sweep(tmp_path / "limited", conditions)
    assert {model for model, *_ in taken(tmp_path / "limited", only=("model.limit=null",))} == {"of_None"}
    assert {model for model, *_ in taken(tmp_path / "limited", without=("model.limit=null",))} == {"of_2"}


@pytest.mark.slow
def test_baselines_are_left_out_by_name_and_by_seed_alone(swept):
    taken(swept, only=("prompt=japanese", "seed=0"), without=("model=scripted/stay",))
    runs = pd.read_csv(swept / "analysis" / "signatures.csv")
    assert runs.loc[runs["baseline"], ["model", "seed"]].values.tolist() == [["scripted/random", 0]]


@pytest.mark.slow
def test_a_report_and_every_table_say_which_runs_they_are_of_until_all_are_taken_again(swept):
    folder, said = swept / "analysis", "without prompt=japanese: 12 of 18 runs"
    material = gather(swept, without=["prompt=japanese"])
    assert limits(material)[0].endswith(f"a part of the runs: {said}.")
    assert {member.folder.config()["prompt"]["name"] for member in material.members} == {"paper"}
    analysis = material.analysis
    assert analysis.filtered == said and said in analysis.notes[0]
    assert json.loads((folder / "filter.json").read_text())["without"] == {"prompt": ["japanese"]}
    assert len(pd.read_parquet(folder / "steps.parquet")["run"].unique()) == 12
    for name in ("signatures", "comparison", "contrasts"):
        for frame in (pd.read_csv(folder / f"{name}.csv"), pd.read_parquet(folder / f"{name}.parquet")):
            assert set(frame["filter"]) == {said}
    assert said in (folder / "comparison.md").read_text() and said in (folder / "contrasts.md").read_text()
    whole = analyze(swept, plots=False)
    assert whole.filtered == "" and not (folder / "filter.json").exists()
    for name in ("signatures", "comparison", "contrasts"):
        assert "filter" not in pd.read_csv(folder / f"{name}.csv").columns
        assert "of 18 runs" not in (folder / f"{name}.csv").read_text()
    assert "Only a part of the runs" not in (folder / "comparison.md").read_text()


@pytest.mark.slow
def test_a_filtered_analysis_is_that_of_a_sweep_without_the_rest(swept, tmp_path):
    rest = [make_condition(one, SEEDS, ("model", "prompt"), prompt="paper", world=SMALL) for one in MODELS]
    write_sweep(tmp_path / "alone", rest)
    alone = analyze(tmp_path / "alone", plots=False)
    part = analyze(swept, plots=False, only=["prompt=paper"], without=["model=scripted/random,scripted/stay"])
    pd.testing.assert_frame_equal(part.comparison, alone.comparison)
    pd.testing.assert_frame_equal(part.contrasts.drop(columns="look"), alone.contrasts.drop(columns="look"))


@pytest.mark.parametrize(
    ("only", "without", "said"),
    [
        (("modle=good",), (), "Setting 'modle' not found. Did you mean 'model'"),
        (("model=goood",), (), "Model 'goood' not found. Did you mean 'good'"),
        ((), ("seed=7",), "Seed '7' not found. Available: 0, 1, 2"),
        ((), ("world.step=3",), "Setting 'world.step' not found"),
        (("model",), (), "--only model does not have the form KEY=VALUE"),
        (("model=good",), ("model=good",), "leaves none of 18 runs"),
    ],
)
def test_what_no_run_is_by_is_told_in_one_line(only: tuple[str, ...], without: tuple[str, ...], said: str, swept):
    with pytest.raises(InputError) as raised:
        analyze(swept, plots=False, only=only, without=without)
    assert said in str(raised.value) and "\n" not in str(raised.value)


def test_power_is_judged_by_a_part_and_says_so(swept):
    done = foundry(
        "plan", "--pilot", str(swept), "--without", "prompt=japanese", "--measure", "idle_rate.chosen", cwd=swept
    )
    assert "based on a part of the pilot's runs, chosen by: without prompt=japanese" in done.stdout, done.stderr
    assert "japanese" not in done.stdout.partition("prompt=japanese")[2]


@pytest.mark.slow
def test_a_report_of_a_sweep_that_has_grown_tells_each_command_and_what_it_added(tmp_path):
    write_sweep(tmp_path / "s", [make_condition("good", (0,), world=SMALL)])
    assert commands_of(gather(tmp_path / "s").sweeps) == [("s", "foundry asked", "")]
    write_sweep(tmp_path / "s", [make_condition("good", (1, 2), world=SMALL)])
    days = [str(asked.when)[:10] for asked in SweepFolder.open(tmp_path / "s").sweep.history]
    added = [f"1 runs, {days[0]}", f"2 runs, {days[1]}"]
    assert commands_of(gather(tmp_path / "s").sweeps) == [("s", "foundry asked", one) for one in added]
