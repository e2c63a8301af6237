"""What a server does to a number: recorded calls that are made again at the end of a sweep, against a real server."""

from collections import Counter
from pathlib import Path
from subprocess import CompletedProcess

import msgspec
import pytest

from commands import cached_answers, calls, foundry, records, refusal, sessions, succeeds
from foundry.composing import preparing
from foundry.storing.determinism import AUTO, Budget, Repeats, repeats_of
from foundry.storing.store import SweepFolder
from ollama_cases import Body, ChatCase, body_key, grid_answer, held, refused
from ollama_server import OllamaServer

SMALL = ("world.agents=3", "world.steps=3", "analyze=false")
SWEEP = ("-m", "model=llama3.2", "seed=0-2", *SMALL, "output.dir=sweep")
CALLS = 3 * 3 * 3 * 2
FOUR = "determinism=4"
REPLY = msgspec.json.Decoder(dict[str, str])


class Again:
    """Answers a call that it answered so often before with what is given, every other one as `grid_answer` does."""

    def __init__(self, times: int, answer: object) -> None:
        self.seen: Counter[bytes] = Counter()
        self._times = times
        self._answer = answer

    def __call__(self, body: Body) -> str | ChatCase:
        self.seen[body_key(body)] += 1
        if self.seen[body_key(body)] <= self._times:
            return grid_answer(body)
        return self._answer(body)  # type: ignore[operator,no-any-return]


def in_other_words(body: Body) -> str:
    """Return a reply that decides the same where it stays, and to stay where it goes."""
    return msgspec.json.encode({**REPLY.decode(grid_answer(body)), "action": "stay", "reasoning": "Why not?"}).decode()


def swept(server: OllamaServer, cwd: Path, *arguments: str) -> CompletedProcess[str]:
    return succeeds(*SWEEP, *arguments, cwd=cwd, OLLAMA_HOST=server.url)


def measured(cwd: Path) -> tuple[Repeats, ...]:
    return repeats_of(SweepFolder.open(cwd / "sweep"))


def test_a_server_that_repeats_itself_is_said_to_after_the_sweep_and_by_status(tmp_path: Path):
    busy: list[int] = []

    def under_load(body: Body) -> ChatCase:
        busy.append(server.counts.in_flight)
        if len(busy) == 4:
            server.free()
        return held(body)

    with OllamaServer(Again(2, under_load)) as server:
        done = swept(server, tmp_path, FOUR)
    (repeats,) = measured(tmp_path)
    assert repeats.exact and repeats.alone == repeats.loaded and str(repeats.loaded.texts) == "4 of 4"
    said = f"llama3.2: same text in 4 of 4 calls sent alone, and in 4 of 4 calls sent {repeats.at_once} at once; "
    assert said + "same decision in 2 of 2 calls sent alone, and in 2 of 2 sent at once\n" in done.stdout
    assert said in foundry("status", "sweep", cwd=tmp_path).stdout
    succeeds("bundle", "sweep", "sweep.tar.zst", cwd=tmp_path)
    succeeds("unbundle", "sweep.tar.zst", "theirs", cwd=tmp_path)
    assert repeats_of(SweepFolder.open(tmp_path / "theirs")) == (repeats,)
    assert server.counts.chats == CALLS + 4 + repeats.at_once
    assert len(busy) == 4 <= max(busy)


@pytest.mark.slow
def test_a_sweep_makes_at_most_two_percent_of_its_calls_again_and_its_plan_says_so(tmp_path: Path):
    longer = ("determinism=auto", "world.agents=4", "world.steps=9")
    calls_of_sweep = 3 * 4 * 9 * 2
    further = calls_of_sweep // 50
    with OllamaServer() as server:
        planned = foundry("plan", *SWEEP, *longer, cwd=tmp_path, OLLAMA_HOST=server.url).stdout
        off = foundry("plan", *SWEEP, *longer, "determinism=0", cwd=tmp_path, OLLAMA_HOST=server.url).stdout
        swept(server, tmp_path, *longer)
        there = foundry("plan", *SWEEP, *longer, cwd=tmp_path, OLLAMA_HOST=server.url).stdout
    assert f"determinism check: at most {further} calls would be repeated at the end" in planned
    # How many stand beside the repeated calls depends on how many the limiter lets be in flight.
    assert calls_of_sweep + 4 <= server.counts.chats <= calls_of_sweep + further
    assert "determinism" not in off + there


@pytest.mark.parametrize(("calls", "further"), [(54, 4), (960, 19), (9600, 10 + 138), (3, 4), (1, 2)])
def test_the_calls_that_are_made_again_follow_from_the_calls_of_the_model(calls: int, further: int):
    budget = Budget.of(AUTO, calls, in_flight=128)
    assert 2 * budget.again + budget.beside == further


@pytest.mark.slow
def test_calls_that_are_made_again_are_in_no_record_and_no_cache_and_resume_makes_none_once_more(tmp_path: Path):
    with OllamaServer(Again(1, in_other_words)) as server:
        swept(server, tmp_path, "determinism=6")
        chats = server.counts.chats
        resumed = foundry("resume", "sweep", cwd=tmp_path, OLLAMA_HOST=server.url)
        assert "of 6 calls sent alone" in resumed.stdout and server.counts.chats == chats
        before = records(tmp_path / "sweep"), calls(tmp_path / "sweep")
        assert sum(map(len, before[1].values())) == CALLS == cached_answers(tmp_path / "outputs" / "answers.sqlite")
        (first,) = measured(tmp_path)
        (tmp_path / "sweep" / "determinism.json").unlink()
        succeeds("resume", "sweep", cwd=tmp_path, OLLAMA_HOST=server.url)
        swept(server, tmp_path, "determinism=6", "output.dir=again")
    assert (records(tmp_path / "again"), calls(tmp_path / "again")) == before
    assert Counter(Counter(call.run for call in first.calls).values()) == {2: 3}
    assert Counter(call.kind for call in first.calls) == {"message": 3, "action": 3}
    drawn = [[(call.run, call.step, call.agent, call.kind) for call in of.calls] for of in (first, *measured(tmp_path))]
    assert drawn[0] == drawn[1], "the same ones each time"


def test_texts_and_decisions_that_load_changes_are_counted_apart(tmp_path: Path):
    with OllamaServer(Again(2, in_other_words)) as server:
        swept(server, tmp_path, "determinism=20")
        going = {body_key(body): "direction" in grid_answer(body) for body in server.bodies}
    (repeats,) = measured(tmp_path)
    assert repeats.alone.texts.equal == repeats.alone.texts.of == 20
    assert repeats.loaded.texts.equal == 0 and not repeats.exact
    deciding = [call for call in repeats.calls if call.kind == "action"]
    assert [call.loaded.alike for call in repeats.calls if call.kind == "message"] == [None] * (20 - len(deciding))
    for call in deciding:
        text = msgspec.json.decode(call.loaded.text or "")
        assert call.loaded.alike == ("direction" not in text), "who stayed stays"
    assert {call.loaded.alike for call in deciding} == {True, False} and True in going.values()


@pytest.mark.slow
def test_decisions_of_a_probe_are_held_against_those_of_the_same_repeat(tmp_path: Path):
    succeeds("-m", "model=scripted/random", "seed=0-2", *SMALL, "output.dir=pilot", cwd=tmp_path)
    asked = ("pilot", "model=llama3.2", "moments=12", "repeats=4", "determinism=20", "output.dir=sweep")
    with OllamaServer(Again(2, in_other_words)) as server:
        done = foundry("probe", *asked, cwd=tmp_path, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stderr
    (repeats,) = measured(tmp_path)
    deciding = [call for call in repeats.calls if call.kind == "action"]
    assert repeats.alone.decisions.equal == repeats.alone.decisions.of == len(deciding) > 0
    for call in deciding:
        assert call.loaded.alike == ("direction" not in msgspec.json.decode(call.loaded.text or "")), "who stayed stays"
    assert {call.loaded.alike for call in deciding} == {True, False}


def test_a_sweep_that_is_answered_from_the_cache_makes_none_and_says_so(tmp_path: Path):
    with OllamaServer() as server:
        assert "determinism" not in swept(server, tmp_path, "determinism=0").stdout
        done = swept(server, tmp_path, FOUR, "output.dir=again")
        assert server.counts.chats == CALLS
    assert "llama3.2: determinism not measured: every answer came from the cache\n" in done.stdout
    assert not (tmp_path / "again" / "determinism.json").exists()


@pytest.mark.slow
def test_answers_of_the_cache_are_not_held_against_the_server(tmp_path: Path):
    with OllamaServer() as server:
        swept(server, tmp_path, "world.steps=2", "determinism=0", "output.dir=shorter")
        swept(server, tmp_path, "determinism=20")
    assert {call.step for call in measured(tmp_path)[0].calls} == {3}


def test_as_many_are_put_beside_as_were_allowed_in_flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    told: list[int] = []
    monkeypatch.setattr(
        preparing, "repeat_calls", lambda folder, setting, model, in_flight, stopping: told.append(in_flight)
    )
    with OllamaServer() as server:
        swept(server, tmp_path, FOUR, "model.server.in_flight={min: 3, initial: 3, max: 3}", "runner.workers=1")
    assert told == [3]


def test_what_is_turned_off_or_has_no_server_is_not_mentioned(tmp_path: Path):
    done = succeeds("-m", "model=scripted/random,scripted/stay", *SMALL, FOUR, cwd=tmp_path)
    assert "determinism" not in done.stdout + done.stderr


def test_a_server_that_fails_is_told_in_one_line_and_asked_again_by_resume(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
):
    with OllamaServer(Again(1, lambda body: refused(400, "not now"))) as server:
        done = swept(server, tmp_path, FOUR)
        assert (
            len(
                [
                    message
                    for message in caplog.messages
                    if "determinism not measured" in message and "not now" in message
                ]
            )
            == 1
        )
        assert "llama3.2: determinism not measured: its calls were not repeated\n" in done.stdout
        server.answer = grid_answer
        assert "4 of 4 calls" in foundry("resume", "sweep", cwd=tmp_path, OLLAMA_HOST=server.url).stdout


def test_a_sweep_that_is_stopped_meanwhile_ends_in_order_and_resume_measures(tmp_path: Path):
    def stopping(body: Body) -> ChatCase:
        folder = SweepFolder.open(tmp_path / "sweep")
        for session in sessions(folder.path):
            folder.stop_file(session).touch()  # as the first Ctrl-C does
        return ChatCase(hang=True)

    with OllamaServer(Again(1, stopping)) as server:
        done = foundry(*SWEEP, FOUR, cwd=tmp_path, OLLAMA_HOST=server.url)
        assert done.returncode == 130 and "go on with: foundry resume" in done.stdout + done.stderr
        assert "3 of 3 runs complete" in done.stdout and measured(tmp_path) == ()
        server.answer = grid_answer
        assert "4 of 4 calls" in foundry("resume", "sweep", cwd=tmp_path, OLLAMA_HOST=server.url).stdout


@pytest.mark.slow
def test_a_model_in_worlds_with_schemas_of_their_own_is_loaded_once_and_measured_over_all_of_them(tmp_path: Path):
    with OllamaServer() as server:
        swept(server, tmp_path, FOUR, "model=llama3.2,qwen3:4b", "world=bar,public_goods", "world.steps=1", "seed=0")
        assert (server.counts.loads, server.counts.unloads) == (2, 1)
    assert [repeats.model for repeats in measured(tmp_path)] == ["llama3.2", "qwen3:4b"]
    assert all({call.kind for call in repeats.calls} == {"evening", "contribution"} for repeats in measured(tmp_path))


def test_a_damaged_file_is_refused_in_one_line(tmp_path: Path):
    foundry("model=scripted/stay", *SMALL, "output.dir=sweep", cwd=tmp_path)
    (tmp_path / "sweep" / "determinism.json").write_text('{"models": [{"model": 3}]}')
    assert "determinism.json cannot be read" in refusal("status", "sweep", cwd=tmp_path)
