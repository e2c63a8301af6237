"""`foundry play`: what people are shown, what becomes of their answers, and how it goes on another day."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from commands import SMALL, calls, foundry, succeeds
from foundry.errors import InputError
from foundry.models.human.human_model import HumanModel
from foundry.probing.sitting import how_far
from foundry.records import Outcome
from foundry.storing.store import SweepFolder
from sittings import default_reply, played

PILOT = ("world.agents=8", "world.steps=4", "analyze=false")
ASKED = ("model=human/ana", "moments=6", "analyze=false", "output.dir=asked")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded run with eight moments that can be drawn."""
    folder = tmp_path_factory.mktemp("recorded")
    succeeds("model=scripted/avoid", *PILOT, "output.dir=pilot", cwd=folder)
    return folder


@pytest.fixture
def pilot(recorded: Path, workspace: Path) -> Path:
    shutil.copytree(recorded, workspace, dirs_exist_ok=True)
    return workspace


def decisions(folder: Path) -> list[dict[str, Any]]:
    run = SweepFolder.open(folder).runs()[0]
    return [json.loads(line) for line in run.steps_bytes().splitlines()]


def test_a_person_is_shown_each_prompt_alone_and_answers_are_calls_with_the_seconds_they_took(
    pilot: Path, monkeypatch: pytest.MonkeyPatch
):
    def reply(question: dict[str, Any]) -> str:
        return ("I go: " if question["number"] % 2 else "") + default_reply(question)

    done, person = played(monkeypatch, pilot, "pilot", *ASKED, "determinism=5", reply=reply)
    assert done.returncode == 0, done.stderr
    assert "determinism" not in done.stdout + done.stderr, "people are no server that repeats itself"
    [recorded] = calls(pilot / "asked").values()
    prompts = {call["messages"][0]["content"] for call in recorded}
    assert {question["messages"][0]["content"] for question in person.seen} == prompts
    assert {key for question in person.seen for key in question} == {"number", "person", "messages", "schema"}
    assert len(person.seen) == len(recorded) == 6
    run = SweepFolder.open(pilot / "asked").runs()[0]
    found = list(run.calls())
    assert {call.model for call in found} == {"human/ana"}
    assert all(call.timings["latency"] > 0 for call in found)
    acted = [decision for decision in decisions(pilot / "asked") if decision["kind"] == "action"]
    outcomes = {("up", Outcome.CHOSEN), ("up", Outcome.REPAIRED)}
    assert {(one["action"], one["outcome"]) for one in acted} == outcomes, "other words are read as a model's would be"


@pytest.mark.slow
def test_a_sitting_goes_on_another_day_with_what_is_open_and_never_with_foreign_code(
    pilot: Path, monkeypatch: pytest.MonkeyPatch
):
    done, yesterday = played(monkeypatch, pilot, "pilot", *ASKED, most=2)
    assert done.returncode == 130
    assert "foundry play asked" in done.stderr
    done, today = played(monkeypatch, pilot, "asked")
    assert done.returncode == 0, done.stderr
    shown = [question["messages"] for question in [*yesterday.seen, *today.seen]]
    assert (len(yesterday.seen), len(today.seen)) == (2, 4)
    assert len({json.dumps(one) for one in shown}) == 6
    file = pilot / "asked" / "sweep.yaml"
    content = file.read_text(encoding="utf-8").replace(f"{HumanModel.__module__}.HumanModel", "subprocess.Popen")
    file.write_text(content, encoding="utf-8")
    done = foundry("play", "asked", cwd=pilot)
    assert (done.returncode, "--trust-targets" in done.stderr) == (2, True), done.stderr


@pytest.mark.slow
def test_without_a_page_one_line_says_how_to_get_one_and_what_is_answered_needs_none(
    pilot: Path, monkeypatch: pytest.MonkeyPatch
):
    done = foundry("probe", "pilot", *ASKED, "repeats=1", cwd=pilot)
    assert done.returncode == 3
    assert "can only answer on a page. Continue with: foundry play" in done.stderr
    assert "Traceback" not in done.stderr
    for told in (done, foundry("resume", "asked", cwd=pilot)):
        assert "try the failed runs again with: foundry play asked\n" in told.stdout
        assert "foundry resume" not in told.stdout + told.stderr
    played(monkeypatch, pilot, "asked")
    succeeds("probe", "pilot", *ASKED[:-1], "repeats=1", "output.dir=again", cwd=pilot)


@pytest.mark.slow
def test_the_moments_of_two_edits_come_in_an_order_that_does_not_tell_them_apart(
    pilot: Path, monkeypatch: pytest.MonkeyPatch
):
    done, person = played(monkeypatch, pilot, "pilot", *ASKED, "edit=no_persona", begins_at=12)
    assert done.returncode == 0, done.stderr
    assert len(person.seen) == 12
    keys = {call["messages"][0]["content"]: call["key"] for one in calls(pilot / "asked").values() for call in one}
    order = [keys[question["messages"][0]["content"]] for question in person.seen]
    assert order == sorted(order)


def test_a_person_among_models_answers_for_one_agent_in_the_order_of_the_steps(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
):
    mix = "model=mix/human/ana@1+scripted/avoid@0+scripted/avoid@2-3"
    done, person = played(monkeypatch, workspace, mix, *SMALL, "output.dir=mixed")
    assert done.returncode == 0, done.stderr
    [recorded] = calls(workspace / "mixed").values()
    hers = [call for call in recorded if call["model"] == "human/ana"]
    assert {call["agent"] for call in hers} == {1}
    assert [0 <= far < 1 for far in person.far] == [True] * len(hers)
    assert how_far(SweepFolder.open(workspace / "mixed"))() == 1.0
    assert [call["messages"][0]["content"] for call in hers] == [one["messages"][0]["content"] for one in person.seen]


@pytest.mark.parametrize(("begun", "model"), [((), "llama3.2"), (("pilot",), "scripted/stay")])
def test_nobody_to_ask_is_told_before_a_server_is_asked_or_anything_is_written(
    begun: tuple[str, ...], model: str, pilot: Path
):
    nowhere = {"OLLAMA_HOST": "http://127.0.0.1:9"}
    done = foundry("play", *begun, f"model={model}", *PILOT[-1:], "output.dir=none", cwd=pilot, **nowhere)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "model=human/<name>" in done.stderr
    assert not (pilot / "none").exists()


@pytest.mark.parametrize("name", ["ana@example.org", "a b", "x" * 41])
def test_a_name_is_a_word_and_no_address(name: str):
    with pytest.raises(InputError, match="not a valid name"):
        HumanModel(person=name, name="human/x")


def test_the_doctor_tries_no_person(workspace: Path):
    done = foundry("doctor", "model=human/ana", *SMALL, cwd=workspace)
    assert "a person is asked on the page of foundry play" in done.stdout
    assert "problem" not in done.stdout
