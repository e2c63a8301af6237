"""What is told of a run whose form nobody knows more of than all forms share."""

import shutil
from pathlib import Path
from typing import Any

import msgspec
import pytest
from PIL import Image

import made_up_rounds as rounds
from foundry.declared import Declared, Id, keys_of
from foundry.errors import InputError, RecordError
from foundry.expansion import Condition, expand
from foundry.records import Record
from foundry.storing.store import RunFolder, SweepFolder, frame_name
from foundry.viewer.any import drawing
from foundry.viewer.any.streams import OwnStream, curves_of
from foundry.viewer.lines import StepLines
from foundry.viewer.resources import Resources, resources_of_agents
from made_up_rounds import AGENTS, STEPS, Playing

KINDS = 3
TRUSTED = ("made_up_rounds",)


@pytest.fixture(scope="module")
def bar(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    made = rounds.sweep(tmp_path_factory.mktemp("bar") / "bar", models=("first",))
    rounds.whole_run(made.runs()[0])
    return made


def ask(made: SweepFolder, part: str, trusted: tuple[str, ...] = (), run: RunFolder | None = None) -> Any:
    resources = Resources(made.path, trusted=trusted)
    resource = resources.get(f"run/{made.path.name}/{(run or made.runs()[0]).id}/{part}")
    resources.close()
    return msgspec.json.decode(resource.content) if resource.media_type == "application/json" else resource.content


def test_a_page_is_told_the_form_what_the_world_declared_and_its_numbers_as_curves(bar: SweepFolder):
    about = ask(bar, "about")
    assert (about["form"], about["agents"]) == ("rounds", AGENTS)
    assert about["page"] == [{"form": "any", "script": "any/page.js"}]
    assert about["actions"]["go"]["labels"] == ["stay at home", "go", "go late"]
    assert about["keys"]["crowd"] == "integer"
    assert [(one["name"], one["by_step"]) for one in about["streams"]] == [
        ("messages", True),
        ("evenings", True),
        ("house", False),
    ]
    assert ask(bar, "about")["curves"] == [
        {"name": "evenings", "keys": ["crowd"]},
        {"name": "crowd", "keys": ["crowd"]},
    ], "not who sent a message, nor what was decided, nor a file without steps"
    found = ask(bar, "curves/0")
    assert (found["first"], found["last"]) == (1, STEPS)
    crowd = [step % 4 for step in range(1, STEPS + 1)]
    assert found["values"] == [[{"low": crowd, "mean": crowd, "high": crowd}]] * 2


def test_what_names_something_is_no_curve(tmp_path: Path):
    class Visit(Record, frozen=True, kw_only=True):
        stream = "visits"
        step: int
        host: Id
        guest: Id | None
        cups: int

    declared = Declared(form="rounds", streams=keys_of((Visit,)))
    assert declared.streams["visits"] == {"step": "integer", "host": "id", "guest": "id?", "cups": "integer"}
    lines = StepLines(tmp_path / "visits.jsonl")
    (curves,) = curves_of(declared, lines, [OwnStream("visits", (), True, lines)])
    assert curves.keys == ("cups",)


def test_a_step_without_a_value_has_none_and_several_have_their_mean(bar: SweepFolder, tmp_path: Path):
    shutil.copytree(bar.path, tmp_path / "bar")
    made = SweepFolder.open(tmp_path / "bar")
    made.runs()[0].stream_path("evenings").write_text(
        '{"step":1,"crowd":2,"weather":"sun"}\n{"step":1,"crowd":5,"weather":"sun"}\n'
        '{"step":3,"crowd":null,"weather":"sun"}\n{"step":4,"crowd":1,"weather":"sun"}\n'
    )
    ((crowd,), _) = ask(made, "curves/0")["values"]
    assert (crowd["low"][:4], crowd["mean"][:4], crowd["high"][:4]) == (
        [2, None, None, 1], [3.5, None, None, 1], [5, None, None, 1],
    )  # fmt: skip


def test_lanes_marks_texts_and_tracks_hold_every_decision_of_all_kinds_once(bar: SweepFolder):
    lanes = ask(bar, "lanes/0")
    assert {len(lanes[key]) for key in ("step", "agent", "kind", "action", "outcome", "utility")} == {
        KINDS * AGENTS * STEPS
    }
    at = list(zip(lanes["step"], lanes["agent"], lanes["kind"], strict=True)).index((5, 3, "go"))
    outcomes = ask(bar, "about")["outcomes"]
    assert (lanes["action"][at], outcomes[lanes["outcome"][at]], lanes["utility"][at]) == (None, "unreadable", 0.0)
    assert lanes["action"][at + AGENTS] == 4.4, "a number is handed on as a number"
    marks = ask(bar, "marks/0")["marks"]
    assert marks["undecided"] == [0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]
    assert (sum(marks["repaired"]), sum(marks["said"])) == (1, STEPS // 2)
    assert ask(bar, "texts/0")["texts"][0] == [2, 1, "hello from step 2"]
    track = ask(bar, "track/3")
    assert (track["persona"], sum(track["marks"]["undecided"])) == ({"gender": "male"}, 1)


def test_a_decision_comes_with_every_line_of_its_agent_and_streams_by_step(bar: SweepFolder):
    found = ask(bar, "decisions/0/0")
    assert [(one["step"], one["kind"]) for one in found["steps"][:4]] == [
        (1, "talk"),
        (1, "go"),
        (1, "pay"),
        (2, "talk"),
    ]
    assert found["received"][0] == [2, 1, "hello from step 2"]
    assert len(found["calls"]) == KINDS * 10
    assert ask(bar, "stream/1/0")["rows"][2] == {"step": 3, "crowd": 3, "weather": "sun"}
    assert ask(bar, "stream/2/0")["rows"] == [{"seats": 3, "name": "El <b>Farol</b>"}]
    assert ask(bar, "stream/9/0")["rows"] == []


def test_what_is_read_for_all_agents_at_once_is_what_is_read_for_each(bar: SweepFolder):
    resources = Resources(bar.path)
    run = bar.runs()[0].id
    for address, resource in resources_of_agents(resources.view("bar", run)):
        assert resource.content == resources.get(f"run/bar/{run}/{address}").content, address
    resources.close()


def test_a_step_in_writing_is_shown_once_it_is_as_long_as_the_first(tmp_path: Path):
    made = rounds.sweep(tmp_path / "grows", models=("first",))
    playing = Playing(made.runs()[0])
    resources, address = Resources(made.path), f"run/grows/{made.runs()[0].id}"
    playing.play(1, 2)
    playing.writer.append([rounds.line(3, agent, "talk") for agent in range(AGENTS)])

    def progress() -> Any:
        return msgspec.json.decode(resources.get(f"{address}/progress").content)

    assert progress()["done"] == 2
    playing.end("the server is gone")
    assert (progress()["done"], progress()["status"]) == (3, "failed"), "what a failed run did last is seen too"
    resources.close()


def test_a_page_learns_of_agents_that_come_later(tmp_path: Path):
    made = rounds.sweep(tmp_path / "turns", models=("first",))
    (folder,) = made.runs()
    resources, address = Resources(made.path), f"run/turns/{folder.id}"
    playing = Playing(folder)
    playing.writer.append([rounds.line(1, 0, "go")])

    def asked(part: str) -> Any:
        return msgspec.json.decode(resources.get(f"{address}/{part}").content)

    before = asked("progress")["beginning"]
    assert asked("about")["agents"] == 1
    playing.writer.append([rounds.line(2, 6, "go")])
    assert asked("progress")["beginning"] != before
    assert asked("about")["agents"] == 7
    playing.writer.close()
    resources.close()


def test_a_run_that_never_began_has_nothing_to_show(tmp_path: Path):
    made = rounds.sweep(tmp_path / "waits", models=("first",))
    assert (ask(made, "about")["agents"], ask(made, "progress")["done"]) == (0, 0)
    assert ask(made, "lanes/0")["step"] == ask(made, "frames/0")["rows"] == []
    assert "has not been started yet" in ask(made, "pictures")["why"]


def test_records_of_an_unknown_class_are_read_by_the_keys_that_all_share(tmp_path: Path):
    config = {"world": {"_target_": "elsewhere.World", "name": "w"}, "model": {"name": "m"}, "prompt": {"name": "p"}}
    conditions = [Condition({}, {**config, "sampling_seed": None}, (0,))]
    made = SweepFolder.create(tmp_path / "older", expand([], conditions), {}, [])
    (folder,) = made.runs()
    folder.path.mkdir(parents=True)
    line = b'{"step":%d,"agent":0,"action":{"turn":30},"reply":"x"}\n'
    folder.stream_path("steps").write_bytes(line % 1 + line % 2)
    (folder.path / "episode.jsonl").write_bytes(b'{"scene":"hall"}\n')
    about = ask(made, "about")
    assert (about["form"], about["actions"], [one["name"] for one in about["streams"]]) == ("any", {}, ["episode"])
    assert ask(made, "lanes/0")["action"] == ['{"turn":30}', '{"turn":30}']
    assert ask(made, "stream/0/0")["rows"] == [{"scene": "hall"}]


@pytest.mark.parametrize("line", [b'{"step":1,"kind":"go","agent":0}\n', b'{"agent":0,"step":1}\n', b"nonsense\n"])
def test_a_line_without_its_step_and_agent_is_a_record_error(bar: SweepFolder, tmp_path: Path, line: bytes):
    shutil.copytree(bar.path, tmp_path / "damaged")
    damaged = SweepFolder.open(tmp_path / "damaged")
    damaged.runs()[0].stream_path("steps").write_bytes(line)
    with pytest.raises(RecordError, match="does not begin with its step and its agent"):
        ask(damaged, "progress")


def test_pictures_are_drawn_by_a_world_that_is_trusted_and_by_no_other(bar: SweepFolder):
    assert ask(bar, "pictures", TRUSTED) == {"kept": [], "why": "", "lanes": False}
    assert ask(bar, "picture/12", TRUSTED).startswith(b"\x89PNG")
    assert "allow it with --trust-targets made_up_rounds" in ask(bar, "pictures")["why"]
    with pytest.raises(InputError, match="no complete step 13 to draw. The last one is 12"):
        ask(bar, "picture/13", TRUSTED)


def test_kept_pictures_need_no_world(bar: SweepFolder, tmp_path: Path):
    shutil.copytree(bar.path, tmp_path / "kept")
    made = SweepFolder.open(tmp_path / "kept")
    (made.runs()[0].path / "frames").mkdir()
    for step in (0, 4):
        Image.new("RGB", (30, 20), "white").save(made.runs()[0].path / frame_name(step))
    assert ask(made, "pictures")["kept"] == [0, 4]
    assert ask(made, "picture/4") == (made.runs()[0].path / "frames" / "step_0004.png").read_bytes()


@pytest.mark.parametrize(
    ("world", "said"),
    [
        ("Undrawn", "World 'bar' cannot redraw its runs: add a method `redraw` to its Scenario."),
        ("Spoilt", r"World 'bar' cannot redraw run '.*' \(KeyError: 'seat'\)."),
    ],
)
def test_a_world_that_draws_nothing_is_told_in_one_line(tmp_path: Path, world: str, said: str):
    made = rounds.sweep(tmp_path / "undrawn", models=("first",), world={"_target_": f"made_up_rounds.{world}"}, steps=1)
    rounds.whole_run(made.runs()[0])
    with pytest.raises(InputError, match=said):
        ask(made, "picture/0", TRUSTED)
    assert ask(made, "pictures", TRUSTED)["why"].count("\n") == 0


def test_an_export_draws_what_is_quickly_drawn_and_says_what_it_left(bar: SweepFolder, monkeypatch: pytest.MonkeyPatch):
    def exported() -> dict[str, Any]:
        view = Resources(bar.path, trusted=TRUSTED).view("bar", bar.runs()[0].id)
        view.steps.grow()
        return {address: resource.content for address, resource in view.exports()}

    whole = exported()
    assert [name for name in whole if name.startswith("picture/")] == [f"picture/{step}" for step in range(STEPS + 1)]
    assert {"lanes/0", "curves/0", "stream/0/0", "stream/1/0", "stream/2/0"} <= set(whole)
    monkeypatch.setattr(drawing, "EXPORTED_S", -1.0)
    part = exported()
    assert [name for name in part if name.startswith("picture/")] == []
    assert "to draw 13 pictures takes about" in msgspec.json.decode(part["pictures"])["why"]


def test_numbers_by_step_are_means_of_utilities_and_of_what_the_world_writes(bar: SweepFolder):
    frames, values = ask(bar, "frames/0"), ask(bar, "by_step/0")["values"]
    of_third = [row["utility"] for row in frames["rows"] if row["step"] == 3 and row.get("utility") is not None]
    assert values["utility (mean)"][2] == pytest.approx(sum(of_third) / len(of_third))
    assert all(len(value) == STEPS for value in values.values())
    assert {"crowd", "utility (mean)"} < set(values)
