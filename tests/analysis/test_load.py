"""Reading recorded runs."""

from __future__ import annotations

import pytest

import analysis
from analysis.load import _of_run, read_records, read_run
from commands import foundry
from foundry.composing.preflight import scenario_of
from foundry.errors import InputError, RecordError
from foundry.records import Outcome
from foundry.storing.store import SweepFolder
from foundry.worlds.base import Answer
from foundry.worlds.grid.grid_world import GridScenario


def test_a_sweep_loads_as_tidy_tables_of_which_every_row_tells_its_model_world_prompt_and_seed(
    make_sweep, make_condition
):
    folder = make_sweep([make_condition("a", [0, 1]), make_condition("b", [0, 1])])
    loaded = analysis.load(folder.path)
    assert list(loaded.runs.columns) == ["run", "world", "model", "prompt", "seed", "status"]
    assert loaded.runs["model"].tolist() == ["a", "a", "b", "b"]
    assert len(loaded.steps) == 4 * 6 * 25
    assert {"run", "step", "message", "neighbours", "outcome"} <= set(loaded.steps.columns)
    assert set(loaded.messages["run"]) <= set(loaded.runs["run"])
    of_run = loaded.runs.set_index("run")[["world", "model", "prompt", "seed"]]
    for table in (loaded.steps, loaded.messages, loaded.agents, loaded.calls, *loaded.fixtures.values()):
        assert table.columns[:5].tolist() == ["run", *of_run.columns]
        expected = of_run.loc[table["run"]].reset_index()
        assert table[["run", *of_run.columns]].to_numpy().tolist() == expected.to_numpy().tolist()
    assert loaded.steps.groupby("model").size().to_dict() == {"a": 300, "b": 300}


def test_a_records_own_key_is_not_taken_for_the_seed_of_its_run(make_sweep, make_condition):
    folder = make_sweep([make_condition("a", [7])]).runs()[0]
    frame = _of_run(folder, {"step": [1], "seed": [3]})
    assert (frame["seed"].tolist(), frame["record.seed"].tolist()) == ([7], [3])


def test_fires_places_and_calls_are_tables(tmp_path):
    asked = ("model=scripted/stay", "world.agents=2", "world.steps=1", "analyze=false", "output.dir=out")
    assert foundry(*asked, cwd=tmp_path).returncode == 0
    loaded = analysis.load(tmp_path / "out")
    assert loaded.fixtures["fires"].iloc[:, 5:].to_numpy().tolist() == [
        ["fire1", 15, 10, 3, 15.0],
        ["fire2", -15, -10, 5, 8.0],
    ]
    assert loaded.fixtures["places"].iloc[0, 5:].tolist() == ["cafe", -15, 0, -20, -10, -5, 5, 12]
    (run,) = SweepFolder.open(tmp_path / "out").runs()
    for row, call in zip(loaded.calls.itertuples(), run.calls(), strict=True):
        assert (row.step, row.agent, row.kind, row.reply) == (call.step, call.agent, call.kind, call.text)
        assert row.prompt_text == call.messages[0]["content"] and (row.asked_model, row.seed) == ("scripted/stay", 0)
    assert loaded.calls["latency_s"].dtype == loaded.calls["prompt_tokens"].dtype == float


def test_the_personas_of_a_run_are_loaded_as_they_were_drawn(tmp_path):
    asked = ("model=scripted/stay", "seed=0-1", "world.agents=8", "world.steps=1", "analyze=false", "output.dir=out")
    assert foundry("-m", *asked, cwd=tmp_path).returncode == 0
    folder = SweepFolder.open(tmp_path / "out")
    agents = analysis.load(folder.path).agents
    assert list(agents.columns[5:]) == ["agent", "persona.gender"]
    for run in folder.runs():
        drawn = [persona["gender"] for persona in scenario_of(run.config()).personas(run.run.seed)]
        assert list(agents[agents["run"] == run.id]["persona.gender"]) == drawn and {"female", "male"} == set(drawn)
    for run in folder.runs():
        run.stream_path("agents").unlink()
    with pytest.raises(RecordError, match="agents.jsonl is not the file that the run wrote"):
        analysis.load(folder.path)


def test_a_folder_that_is_no_sweep_is_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        analysis.load(tmp_path / "none")


def test_a_torn_last_line_of_an_unfinished_run_is_left_out(make_sweep, make_condition, rewrite_run):
    folder = make_sweep([make_condition("a", [0])])
    run = folder.runs()[0]
    rewrite_run(run, "unfinished")
    content = (run.path / "steps.jsonl").read_bytes()
    (run.path / "steps.jsonl").write_bytes(content[:-10])
    loaded = analysis.load(folder.path)
    assert len(loaded.steps) == 6 * 25 - 1
    assert loaded.runs["status"].tolist() == ["unfinished"]


@pytest.mark.parametrize("name", ["steps.jsonl", "messages.jsonl"])
@pytest.mark.parametrize("status", ["complete", "failed"])
def test_a_file_that_the_run_did_not_write_is_named(make_sweep, make_condition, rewrite_run, name, status):
    folder = make_sweep([make_condition("a", [0])])
    run = folder.runs()[0]
    rewrite_run(run, status)
    content = (run.path / name).read_bytes()
    (run.path / name).write_bytes(content[:-10])
    with pytest.raises(RecordError, match=name):
        analysis.load(folder.path)


def test_a_missing_file_of_a_complete_run_is_named(make_sweep, make_condition):
    folder = make_sweep([make_condition("a", [0])])
    (folder.runs()[0].path / "messages.jsonl").unlink()
    with pytest.raises(RecordError, match=r"messages\.jsonl"):
        analysis.load(folder.path)


def test_a_broken_line_within_an_unfinished_run_is_an_error(make_sweep, make_condition, rewrite_run):
    folder = make_sweep([make_condition("a", [0])])
    run = folder.runs()[0]
    rewrite_run(run, "unfinished")
    (run.path / "steps.jsonl").write_bytes(b'{"step": 1\n' + (run.path / "steps.jsonl").read_bytes())
    with pytest.raises(RecordError, match=r"steps\.jsonl"):
        analysis.load(folder.path)


def test_a_run_that_never_started_has_no_rows(make_sweep, make_condition):
    folder = make_sweep([make_condition("a", [0])])
    for file in folder.runs()[0].path.iterdir():
        file.unlink()
    folder.runs()[0].path.rmdir()
    loaded = analysis.load(folder.path)
    assert loaded.runs["status"].tolist() == ["not started"]
    assert len(loaded.steps) == len(loaded.messages) == 0


def test_a_world_that_is_not_2d_is_refused_by_name(make_sweep, make_condition):
    folder = make_sweep([make_condition("a", [0])])
    world = {"name": "kibo", "scene": "kibo.usd", "agents": 1, "steps": 1, "half_size": "none"}
    folder.sweep.conditions[0].config["world"] = world
    with pytest.raises(InputError, match="'kibo'.*not a 2D world"):
        read_records(folder.runs()[0], None)


def test_steps_that_do_not_follow_on_one_another_are_refused(recorded):
    written = recorded()
    records = read_records(written.folder, written.folder.summary())
    with pytest.raises(RecordError, match="one line per step and agent"):
        read_run(written.folder, type(records)(records.steps[1:], records.messages))
    with pytest.raises(RecordError, match="one line per step and agent"):
        read_run(written.folder, type(records)([], []))


def test_the_arrays_hold_what_the_lines_say(recorded):
    written = recorded()
    run = written.run
    assert run.x.shape == (26, 6)
    assert run.fires.shape == (25, 6, 2)
    row = written.walk.steps[6 * 10 + 3]
    assert (run.x[10, 3], run.y[10, 3], run.x[11, 3]) == (row.x, row.y, row.x_next)
    assert run.said[10, 3] == row.message
    assert run.neighbours[10, 3] == len(row.neighbours)
    assert run.readable[10, 3] == (row.outcome in (Outcome.CHOSEN, Outcome.REPAIRED))
    assert len(run.deliveries) == len(written.walk.messages)


def test_the_records_of_the_real_world_fit_the_arrays(recorded, small_world, make_habits):
    layout = {"_target_": "foundry.worlds.grid.layouts.Uniform"}
    scenario = GridScenario(**small_world, layout=_uniform())
    world = scenario.start(3)
    made = type(recorded(habits=make_habits()).walk)()
    while not world.finished:
        answers = [Answer(_reply(one.kind, one.step, one.agent)) for one in world.pending()]
        for record in world.advance(answers):
            (made.steps if record.stream == "steps" else made.messages).append(record)
    written = recorded(records=made, seed=9, layout=layout)
    run = written.run
    assert run.steps == 25
    assert run.moved.any()
    assert (run.place >= 0).any()
    assert len(run.deliveries)


def _uniform():
    from foundry.worlds.grid.layouts import Uniform

    return Uniform()


def _reply(kind: str, step: int, agent: int) -> str:
    if kind == "message":
        return '{"message": "fire here", "reasoning": ""}'
    direction = ("up", "right", "down", "left")[(step // 4 + agent) % 4]
    return f'{{"action": "move", "direction": "{direction}", "memory": "", "reasoning": ""}}'
