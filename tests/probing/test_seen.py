"""The moments of a probe as the viewer hands them out."""

import json
import shutil
import urllib.request
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from foundry.errors import InputError
from foundry.probing.seen import SeenProbe
from foundry.storing.run_files import calls_bytes
from foundry.storing.store import SweepFolder
from foundry.viewer.resources import Resources
from foundry.viewer.server import ViewServer, serving
from probing.conftest import MOMENTS, lines, note, noted, runs


@pytest.fixture(scope="module")
def server(probed: Path) -> Iterator[ViewServer]:
    with serving(probed) as view_server:
        yield view_server


def asked(server: ViewServer, address: str) -> Any:
    with urllib.request.urlopen(f"{server.url}data/{address}") as response:
        return msgspec.json.decode(response.read())


def test_a_probe_is_told_apart_from_other_sweeps(server: ViewServer, pilot: Path):
    assert asked(server, "sweeps")["sweeps"][0]["probe"] is True
    with serving(pilot) as other:
        assert asked(other, "sweeps")["sweeps"][0]["probe"] is False
        with pytest.raises(InputError, match="'pilot' is not a probe"):
            other.resources.get("probe/pilot/moments")


def test_every_moment_has_the_choices_that_were_recorded_and_its_strata(server: ViewServer, probed: Path):
    found = asked(server, "probe/probed/moments")
    assert [one["name"] for one in found["edits"]] == ["none", "no_fire", "mirror"]
    assert found["models"] == SweepFolder.open(probed).sweep.model_names()
    assert found["missing"] == 0
    counted: Counter[tuple[Any, ...]] = Counter()
    for run in runs(probed):
        config = run.config()
        for line in lines(run):
            if line["kind"] == "action":
                where = (line["run"], line["step"], line["agent"], line["again"])
                counted[*where, config["model"]["name"], config["world"]["edit"]["name"], line["action"]] += 1
    told = {
        (one["run"], one["step"], one["agent"], one["again"], found["models"][answer["model"]],
         found["edits"][answer["edit"]]["name"], choice): count
        for one in found["moments"] if one["kind"] == "action"
        for answer in one["answered"]
        for choice, count in answer["counts"].items()
    }  # fmt: skip
    assert told == counted
    assert {frozenset(one["strata"]) for one in found["moments"]} == {frozenset({"fire", "message", "wall"})}


def test_replies_and_what_was_perceived_stand_by_moment_edit_and_prompt(server: ViewServer):
    number = next(
        place
        for place, one in enumerate(asked(server, "probe/probed/moments")["moments"])
        if one["kind"] == "action" and one["strata"]["fire"]
    )
    seen = asked(server, f"probe/probed/moment/{number}")
    perceived = {one["edit"]: one["observation"] for one in seen["perceived"]}
    assert (len(perceived[0]["fires"]), len(perceived[1]["fires"])) == (1, 0)
    assert perceived[2]["x"] == -perceived[0]["x"]
    assert (seen["form"], seen["script"], seen["why"]) == ("grid", "grid/probe.js", "")
    seen = asked(server, "probe/probed/moment/0")
    moment = asked(server, "probe/probed/moments")["moments"][0]
    assert len(seen["answers"]) == len(moment["answered"]) >= 10
    for answer, counted in zip(seen["answers"], moment["answered"], strict=True):
        assert Counter(one["choice"] for one in answer["replies"]) == counted["counts"]
        [prompt] = seen["prompts"][answer["prompt"]]
        assert prompt["content"].startswith(f"You are Agent {moment['agent']} ")
        if moment["kind"] == "action":
            assert all((one["choice"] in one["text"]) for one in answer["replies"])


def test_a_state_of_the_world_is_drawn_and_what_is_not_there_is_told(server: ViewServer):
    resources = server.resources
    assert resources.get("probe/probed/picture/0/0/0").content.startswith(b"\x89PNG")
    for address, told in (
        ("moment/18", "no moment 18: give a number from 0 to 17"),
        ("picture/0/9/0", "Edit '9' not found"),
        ("moments/1", "A probe has no data at an address with 'moments' and 1 number."),
        ("moment/x", "'x' of the address must consist of whole numbers"),
    ):
        with pytest.raises(InputError, match=told):
            resources.get(f"probe/probed/{address}")


def test_worlds_that_may_not_be_built_leave_the_replies(probed: Path, monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: Any) -> None:
        raise InputError("world is refused: --trust-targets")

    monkeypatch.setattr("foundry.probing.seen.check_targets", refuse)
    seen = SeenProbe(SweepFolder.open(probed)).seen(0)
    assert (seen.perceived, seen.form, seen.why) == ([], "", "world is refused: --trust-targets")
    assert seen.answers


def test_a_moment_as_it_was_alone_has_the_answers_without_edits_and_formats(probed: Path):
    seen_probe = SeenProbe(SweepFolder.open(probed))
    whole, plain = seen_probe.seen(0), seen_probe.seen(0, plain=True)
    assert [answer.replies for answer in plain.answers] == [
        answer.replies for answer in whole.answers if (answer.edit, answer.format) == (0, 0)
    ]
    assert 0 < len(plain.answers) < len(whole.answers)
    assert plain.perceived == whole.perceived[:1]


def test_runs_that_are_not_complete_are_told_and_not_counted(probed: Path, tmp_path: Path):
    copied = tmp_path / "probed"
    shutil.copytree(probed, copied)
    first, *_ = runs(copied)
    (first.path / "run.json").unlink()
    before, after = (SeenProbe(SweepFolder.open(path)).overview() for path in (probed, copied))
    lost = len({(line["run"], line["step"], line["agent"], line["kind"], line["again"]) for line in lines(first)})
    assert (before.missing, after.missing) == (0, 1)
    assert (
        sum(len(moment.answered) for moment in before.moments) - sum(len(moment.answered) for moment in after.moments)
        == lost
    )


def test_replies_are_told_to_be_lost_where_the_log_has_fewer_calls_than_decisions(probed: Path, tmp_path: Path):
    copied = tmp_path / "probed"
    shutil.copytree(probed, copied)
    for run in runs(copied):
        (run.path / "calls.jsonl.zst").write_bytes(calls_bytes([*run.calls()][1:]))
    seen_probe = SeenProbe(SweepFolder.open(copied))
    texts = [
        reply.text for place in range(MOMENTS) for answer in seen_probe.seen(place).answers for reply in answer.replies
    ]
    assert 0 < texts.count(None) < len(texts)


@pytest.fixture
def resources(probed: Path, tmp_path: Path) -> Iterator[Resources]:
    """What can be asked of a copy of the probe."""
    resources = Resources(Path(shutil.copytree(probed, tmp_path / "probed")))
    yield resources
    resources.close()


@pytest.mark.slow
def test_a_run_of_a_probe_has_no_events_and_says_so(resources: Resources, tmp_path: Path):
    run = SweepFolder.open(tmp_path / "probed").runs()[0].id
    found = json.loads(resources.get(f"run/probed/{run}/analysis").content)
    assert found == {"events": [], "why": "A probe has no events.", "score": None}


@pytest.mark.slow
def test_a_note_on_no_moment_of_the_probe_is_refused(resources: Resources, tmp_path: Path):
    for moment, message in (
        (18, "There is no moment 18: give a number from 0 to 17."),
        (8, "A note on moment 8 must name run '"),
        (-1, "The note cannot be read: "),
        (None, "Run '"),
    ):
        with pytest.raises(InputError) as raised:
            resources.take_note("probed", note(tmp_path / "probed", 7, "Here", moment=moment))
        assert str(raised.value).startswith(message)
    assert noted(tmp_path / "probed") == []
