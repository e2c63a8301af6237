import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]
import pytest
import yaml

from analysis.measuring.events import Event, EventsFile
from foundry.errors import InputError, RecordError
from foundry.storing.store import SweepFolder
from foundry.viewer.resources import Resources, addresses_of_run, resources_of_agents
from made_up_runs import AGENTS, STEPS, Playing, step, sweep, whole_run


@pytest.fixture
def resources(made_up: SweepFolder) -> Iterator[Resources]:
    opened = Resources(made_up.path)
    yield opened
    opened.close()


def ask(resources: Resources, address: str) -> Any:
    return msgspec.json.decode(resources.get(address).content)


def run(made_up: SweepFolder, index: int = 0) -> str:
    return f"run/made-up/{made_up.runs()[index].id}"


def test_a_folder_lists_its_sweeps_newest_first_linked_ones_too_and_says_which_cannot_be_read(tmp_path: Path):
    root = tmp_path / "sweeps"
    for name in ("a b", "a-b", "newer", "newer/baselines"):
        sweep(root / name)
    (root / "linked").symlink_to(sweep(tmp_path / "elsewhere").path)
    (root / "bad").mkdir()
    (root / "bad" / "sweep.yaml").write_text("asked: [", encoding="utf-8")
    found = ask(Resources(root), "sweeps")
    assert [one["name"] for one in found["sweeps"]] == ["linked", "newer", "newer/baselines", "a-b", "a b"]
    assert {one["id"] for one in found["sweeps"] if one["name"] in ("a b", "a-b")} == {"a-b", "a-b-2"}
    assert len(found["unreadable"]) == 1 and "bad" in found["unreadable"][0]
    with pytest.raises(RecordError):
        Resources(root / "bad")


@pytest.mark.parametrize("half_size, fires", [(5, [{"name": "fire"}]), ("wide", [])])
def test_a_world_of_odd_settings_is_refused_before_anything_of_it_is_shown(
    half_size: object, fires: object, tmp_path: Path
):
    folder = sweep(tmp_path / "odd")
    content = yaml.safe_load((folder.path / "sweep.yaml").read_text(encoding="utf-8"))
    for one in content["conditions"]:
        one["config"]["world"] |= {"half_size": half_size, "fires": fires}
    (folder.path / "sweep.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    opened = Resources(tmp_path / "odd")
    run = folder.runs()[0].id
    with pytest.raises(RecordError, match=f"The world of run '{run}' cannot be shown"):
        opened.get(f"run/odd/{run}/info")
    opened.close()


def test_rows_say_how_every_run_stands_and_missing_signatures_are_null(resources: Resources):
    head, rows = ask(resources, "sweep/made-up"), ask(resources, "sweep/made-up/rows/0")["rows"]
    assert head["counts"] == {"complete": 3, "failed": 1}
    assert [row["status"] for row in rows] == ["complete", "complete", "complete", "failed"]
    assert rows[3]["error"] == "the server is gone <b>for good</b>"
    assert rows[0]["undecided"] == 1
    assert {"label": "report", "kind": "html", "path": "report.html"} in head["links"]
    assert ask(resources, "sweep/made-up")["measures"] == ["idle_rate.share"]
    assert ask(resources, "sweep/made-up/measure/0")["values"] == [0.25, 0.001, None, None]


def test_the_tables_of_a_sweep_alone_and_those_with_other_sweeps_are_linked_by_different_names(tmp_path: Path):
    made = sweep(tmp_path / "one")
    for others in ([], [sweep(tmp_path / "bar")]):
        made.analysis_dir_with(others).mkdir()
        (made.analysis_dir_with(others) / "contrasts.csv").write_text("measure\n", encoding="utf-8")
    assert [(one["label"], one["path"]) for one in ask(Resources(made.path), "sweep/one")["links"]] == [
        ("contrasts", "analysis/contrasts.csv"),
        ("contrasts with bar", "analysis_with_bar/contrasts.csv"),
    ]


def test_each_joint_analysis_has_a_folder_of_its_own_also_with_many_sweeps(tmp_path: Path):
    first, *others = (
        sweep(tmp_path / name) for name in ("one", "bar", "naming", *(f"a-long-name-{n}" for n in range(9)))
    )
    joint = [first.analysis_dir_with(others[:1]), first.analysis_dir_with(others[1:2]), first.analysis_dir_with(others)]
    assert [folder.name[:20] for folder in joint] == [
        "analysis_with_bar",
        "analysis_with_naming",
        "analysis_with_11_oth",
    ]
    assert first.analysis_dir_with(others[1:]) not in joint and first.analysis_dir_with([]) == first.analysis_dir


def test_a_run_has_its_events_its_score_and_its_neighbours_once_it_is_analysed(tmp_path: Path):
    made = sweep(tmp_path / "found")
    runs, opened = [run.id for run in made.runs()], Resources(made.path)
    address = f"run/found/{runs[1]}"
    assert ask(opened, f"{address}/about")["beside"] == {"seeds": runs[:2], "models": [runs[1], runs[3]]}
    found = ask(opened, f"{address}/analysis")
    assert found == {"events": [], "why": f"not analysed: foundry analyze {made.path}", "score": None}
    made.analysis_dir.mkdir()
    made.signatures_path.write_text("\n".join(["run,own.score", f"{runs[0]},0.5", f"{runs[1]},1"]), encoding="utf-8")
    known = pa.table(
        {"world": [str(made.runs()[0].config()["world"]["name"])], "measure": ["own.score"], "closed_forms": ["best 2"]}
    )
    pq.write_table(known, made.analysis_dir / "validation.parquet")
    overview = {"matrix": None, "furthest": [], "labels": {"own.score": "Own score (points)"}}
    (made.analysis_dir / "overview.json").write_text(json.dumps(overview), encoding="utf-8")
    events = EventsFile()
    events.add("found", runs[0], [Event(1, 3, "fled", "agent 3 steps away")])
    events.add("found", runs[1], [Event(4, None, "crowded", "cafe is crowded"), Event(2, 0, "fled", "away")])
    events.write(made.analysis_dir)
    score = {"measure": "own.score", "value": 1.0, "mean": 0.75, "runs": 2, "known": "best 2"}
    assert ask(opened, f"{address}/analysis") == {
        "events": [[2, 0, "fled", "away"], [4, None, "crowded", "cafe is crowded"]],
        "why": "",
        "score": {"label": "Own score (points)", **score},
    }
    assert ask(opened, f"run/found/{runs[2]}/analysis")["why"].startswith("not in the last analysis")
    opened.close()


def test_frames_tracks_and_marks_hold_what_the_records_say(resources: Resources, made_up: SweepFolder):
    about, frames = ask(resources, f"{run(made_up)}/about"), ask(resources, f"{run(made_up)}/frames/0")
    assert (frames["first"], frames["last"]) == (1, STEPS)
    assert len(frames["x"]) == (STEPS + 1) * AGENTS
    assert frames["x"][:AGENTS] == [-4] * AGENTS
    assert frames["x"][-AGENTS:] == [2] * AGENTS
    agents = ask(resources, f"{run(made_up)}/agents")["agents"]
    assert agents[0]["persona"]["gender"] == "female" and len(agents) == AGENTS
    assert sum(agent["counts"]["messages"] for agent in agents) == sum(
        ask(resources, f"{run(made_up)}/marks/0")["marks"]["said"]
    )
    assert about["outcomes"][frames["outcome"][3 * AGENTS]] == "unreadable"
    assert frames["links"][0] == [1, 2]
    assert frames["deliveries"][:2] == [[], [1, 2]]
    assert frames["place"][:AGENTS] == [0, 0, -1, -1]
    marks = ask(resources, f"{run(made_up)}/marks/0")["marks"]
    assert marks["undecided"] == [0, 0, 0, 1, 0, 0]
    assert marks["repaired"] == [0, 0, 1, 0, 0, 0]
    assert marks["said"] == [0, 1, 0, 1, 0, 1]
    track = ask(resources, f"{run(made_up)}/track/1")
    assert track["x"] == [-4, -3, -2, -1, 0, 1, 2]
    assert track["persona"] == {"gender": "male"}
    assert ask(resources, f"{run(made_up)}/track/2")["persona"] == {"gender": "female"}


def test_a_decision_comes_with_its_prompts_replies_and_what_was_heard(resources: Resources, made_up: SweepFolder):
    finished = ask(resources, f"{run(made_up)}/decisions/0/2")
    assert [one["step"] for one in finished["steps"]] == list(range(1, STEPS + 1))
    assert [(one["step"], one["kind"]) for one in finished["calls"][:3]] == [
        (1, "message"),
        (1, "action"),
        (2, "message"),
    ]
    assert "You are Agent 2" in finished["calls"][0]["messages"][0]["content"]
    assert finished["received"] == [[step, 1, f"hello from step {step}"] for step in (2, 4, 6)]


def test_a_run_that_recorded_no_personas_has_none(made_up: SweepFolder, tmp_path: Path):
    shutil.copytree(made_up.path, tmp_path / "older")
    older = SweepFolder.open(tmp_path / "older")
    older.runs()[0].stream_path("agents").unlink()
    assert ask(Resources(older.path), f"run/older/{older.runs()[0].id}/track/1")["persona"] == {}


def test_a_run_that_never_began_has_nothing_to_show(tmp_path: Path):
    made = sweep(tmp_path / "waits")
    address = f"run/waits/{made.runs()[0].id}"
    resources = Resources(made.path)
    assert ask(resources, f"{address}/progress")["status"] == "waiting"
    assert ask(resources, f"{address}/frames/0")["x"] == []
    assert ask(resources, f"{address}/marks/0")["marks"]["said"] == []
    assert ask(resources, f"{address}/track/0")["x"] == []


def test_only_whole_steps_are_shown_while_a_run_is_written(tmp_path: Path):
    made = sweep(tmp_path / "grows")
    playing, resources = Playing(made.runs()[0]), Resources(made.path)
    address = f"run/grows/{made.runs()[0].id}"
    playing.play(1, 2)
    playing.writer.append([step(3, 0)])
    assert ask(resources, f"{address}/progress")["done"] == 2
    assert ask(resources, f"{address}/frames/0")["last"] == 2
    playing.writer.close()


def test_steps_that_lack_an_agent_are_a_record_error(tmp_path: Path):
    made = sweep(tmp_path / "lacks")
    folder = made.runs()[0]
    whole_run(folder)
    lines = folder.steps_bytes().splitlines(keepends=True)
    folder.stream_path("steps").write_bytes(b"".join(lines[:5] + lines[6:]))
    with pytest.raises(RecordError, match="must have one line per step and agent"):
        Resources(made.path).get(f"run/lacks/{folder.id}/frames/0")


@pytest.mark.parametrize(
    "address",
    [
        "",
        "nothing",
        "sweeps/x",
        "sweep/other",
        "sweep/made-up/rows/x",
        "sweep/made-up/measure/7",
        "run/made-up/x/about",
    ],
)
def test_what_is_not_there_is_said_so(resources: Resources, address: str):
    with pytest.raises(InputError):
        resources.get(address)


@pytest.mark.parametrize(
    "part", ["frames", "frames/-1", "frames/1/2", "frames/..", "decisions/0", "secret", "frames/9" + "9" * 20]
)
def test_a_run_is_asked_by_known_names_and_numbers_only(resources: Resources, made_up: SweepFolder, part: str):
    with pytest.raises(InputError):
        resources.get(f"{run(made_up)}/{part}")


def test_every_address_of_a_run_answers(resources: Resources, made_up: SweepFolder):
    view = resources.view("made-up", made_up.runs()[0].id)
    addresses = list(addresses_of_run(view))
    assert {address.partition("/")[0] for address in addresses} == {
        "about", "progress", "analysis", "agents", "frames", "texts", "marks", "by_step",
    }  # fmt: skip
    for address in addresses:
        assert resources.get(f"{run(made_up)}/{address}").content


def test_what_is_read_for_all_agents_at_once_is_what_is_read_for_each(resources: Resources, made_up: SweepFolder):
    together = dict(resources_of_agents(resources.view("made-up", made_up.runs()[0].id)))
    assert len(together) == 2 * AGENTS
    for address, resource in together.items():
        assert resource.content == resources.get(f"{run(made_up)}/{address}").content, address


def test_a_run_that_was_started_anew_is_shown_anew(tmp_path: Path):
    made = sweep(tmp_path / "again", models=("first",), seeds=(0,))
    (folder,) = made.runs()
    opened, seen, beginnings = Resources(made.path), [], set()
    for last, reply in ((4, "as it was"), (2, "anew")):
        playing = Playing(folder, change=lambda number, agent, last=last: {"x": last}, reply=reply)
        playing.play(1, last)
        playing.writer.close()
        asked = ("progress", "frames/0", "decisions/0/0")
        progress, frames, decisions = (ask(opened, f"run/again/{folder.id}/{what}") for what in asked)
        beginnings.add(progress["beginning"])
        seen.append((progress["done"], frames["x"][0], decisions["calls"][-1]["step"], decisions["calls"][0]["text"]))
    opened.close()
    assert seen == [(4, 4, 4, "message: as it was"), (2, 2, 2, "message: anew")]
    assert len(beginnings) == 2
