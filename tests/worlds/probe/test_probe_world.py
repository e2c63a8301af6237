"""Recorded moments are made again by playing their world, and asked in rounds."""

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zstandard

from foundry.errors import InputError, RecordError
from foundry.records import Outcome
from foundry.worlds.base import Answer, Question, Scenario
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.probe.editing import UNEDITED, Edit
from foundry.worlds.probe.moments import LoggedAnswer, Moment, Moments, Source, digest_of, questions_at
from foundry.worlds.probe.probe_world import APART, ROUND, ProbeScenario
from small_worlds import GRID, HELLO, greeted, grid, naming


def world() -> GridScenario:
    return grid(agents=3)


def played(scenario: Scenario) -> tuple[list[Question], list[LoggedAnswer]]:
    pairs = greeted(scenario)
    past = [
        LoggedAnswer(step=one.step, agent=one.agent, kind=one.kind, text=text, ending="stop") for one, text in pairs
    ]
    return [one for one, _ in pairs], past


def kept_in(
    folder: Path, moments: list[Moment], past: list[LoggedAnswer], runs: dict[str, Source] | None = None
) -> dict[str, Any]:
    """Write down moments of a run `run`, or of several, and return the settings of a probe of them."""
    runs = runs or {"run": Source(seed=4, sha256=digest_of(past))}
    content = msgspec.json.encode(Moments(runs=runs, moments=tuple(moments)))
    (folder / "moments.json").write_bytes(content)
    lines = b"".join(msgspec.json.encode(said) + b"\n" for said in past)
    for run in runs:
        (folder / f"{run}.zst").write_bytes(zstandard.compress(lines))
    kept = {"moments": str(folder / "moments.json"), "past": str(folder / "{run}.zst")}
    return {"name": "probe", "edit": {"name": "none"}, "moments": hashlib.sha256(content).hexdigest(), "kept": kept}


def as_moments(asked: list[Question], run: str = "run") -> list[Moment]:
    return [Moment(run, question.step, question.agent, question.kind, question.again) for question in asked]


@pytest.mark.parametrize(("scenario", "most"), [(world(), 0), (naming(), 2)], ids=["grid", "naming"])
def test_every_question_of_an_episode_comes_out_as_it_was_asked(scenario: Scenario, most: int):
    asked, past = played(scenario)
    assert max(question.again for question in asked) == most
    assert questions_at(scenario, 4, past, as_moments(asked)) == asked
    for question in asked:
        assert questions_at(scenario, 4, past, as_moments([question])) == [question]


def test_a_world_that_asks_otherwise_by_now_is_refused():
    asked, past = played(world())
    with pytest.raises(RecordError, match="recorded: the message of agent 0 at step 1"):
        questions_at(world(), 4, [past[0], *past], as_moments(asked[-1:]))
    with pytest.raises(RecordError, match="recorded: nothing"):
        questions_at(world(), 4, past[:4], as_moments(asked[-1:]))
    with pytest.raises(RecordError, match="the run now ends earlier"):
        questions_at(world(), 4, past, [Moment("run", 9, 0, "action")])


def test_moments_are_asked_in_rounds_each_time_with_a_seed_of_its_own_and_read_by_their_world(tmp_path: Path):
    asked, past = played(world())
    probe = ProbeScenario(source=world(), repeats=10, **kept_in(tmp_path, as_moments(asked), past))
    assert probe.count_calls() == 10 * len(asked) == 180
    running, questions, records = probe.start(4), list[Question](), []
    while not running.finished:
        pending = running.pending()
        questions += pending
        records += running.advance([Answer(HELLO if question.kind == "message" else "no idea") for question in pending])
    assert running.step == 3 and running.pending() == [] and len(questions) == 180 > 2 * ROUND
    assert {question.again for question in questions} == {repeat * APART for repeat in range(10)}
    assert len({question.sampling_seed(4) for question in questions}) == 180
    assert {(record.message, record.outcome) for record in records if record.kind == "message"} == {
        ("Hello.", Outcome.CHOSEN)
    }
    assert {(record.action, record.outcome) for record in records if record.kind == "action"} == {
        (None, Outcome.UNREADABLE)
    }
    assert [record.repeat for record in records[:10]] == list(range(10)) and not probe.start(5).pending()


def test_an_edit_that_looks_around_is_given_the_moments_of_its_seed_and_of_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def counted(question: Question, others: list[Question]) -> Question:
        assert question not in others
        return replace(question, observation={"others": len(others)})

    monkeypatch.setattr("foundry.worlds.probe.probe_world.find_edit", lambda *_: Edit("counted", "cause", counted))
    asked, past = played(world())
    counts = {4: 2, 6: 1, 9: 3}
    sources = {f"run{seed}": Source(seed=seed, sha256=digest_of(past)) for seed in counts}
    moments = [moment for seed, count in counts.items() for moment in as_moments(asked[:count], f"run{seed}")]
    probe = ProbeScenario(source=world(), repeats=1, **kept_in(tmp_path, moments, past, sources))
    for seed, others in {4: 1 + 1, 6: 0 + 3, 9: 2 + 2}.items():
        assert {question.observation["others"] for question in probe.start(seed).pending()} == {others}
    assert probe.start(5).pending() == []


def test_a_probe_has_no_moments_before_it_has_a_folder_and_is_no_source_of_moments(tmp_path: Path):
    asked, past = played(world())
    settings = kept_in(tmp_path, as_moments(asked), past)
    with pytest.raises(InputError, match="foundry probe"):
        ProbeScenario(source=world(), repeats=1, **{**settings, "kept": None}).start(4)
    with pytest.raises(InputError, match="is itself a probe"):
        ProbeScenario(source=ProbeScenario(source=world(), repeats=1, **settings), repeats=1, **settings)


class Mute(GridScenario):
    """A world without a method `read`."""

    read = Scenario.read


def test_a_world_that_reads_no_reply_alone_is_refused(tmp_path: Path):
    asked, past = played(world())
    with pytest.raises(InputError, match="has no method `read`"):
        ProbeScenario(source=Mute(**GRID), repeats=1, **kept_in(tmp_path, as_moments(asked), past))
    assert UNEDITED.described(world())["expected"] == {}
