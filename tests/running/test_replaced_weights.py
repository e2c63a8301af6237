"""Weights that are replaced while a sweep runs: none of their answers stays, and nothing confirmed is paid again."""

import contextlib
import re
import sqlite3
import subprocess
from functools import partial
from pathlib import Path

import pytest

import ollama_cases
from commands import cached_answers, calls, foundry, kill, records, started, statuses, succeeds, wait_until
from foundry.storing.store import SweepFolder
from ollama_cases import Body, grid_answer, refused
from ollama_server import OllamaServer
from openai_server import ChatCase, OpenAIServer, grid_reply
from replaced import MODEL, SECOND, Replaced

SHAPE = ("seed=0-3", "world.agents=2", "world.steps=3", "analyze=false")
SWEEP = (
    *("-m", f"model={MODEL}", *SHAPE, "runner.open_runs=1"),  # a run is over before the next one asks
    *("model.server.retry.wait_initial_s=0.01", "model.server.retry.wait_max_s=0.1"),
    "model.server.in_flight={min: 4, max: 4, initial: 4}",
)
CALLS_OF_A_RUN = 2 * 3 * 2
CALLS = 4 * CALLS_OF_A_RUN
MIDWAY = 26
"""A call at which two runs are complete and confirmed; the third, which makes it, is not over for ten more."""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("undisturbed")
    with OllamaServer() as server:
        succeeds(*SWEEP, "output.dir=sweep", cwd=folder, OLLAMA_HOST=server.url)
    return folder / "sweep"


def one_line(done: subprocess.CompletedProcess[str]) -> str:
    assert "Traceback" not in done.stderr
    (line,) = done.stderr.splitlines()
    return line


def errors(folder: Path) -> list[str]:
    summaries = [run.summary() for run in SweepFolder.open(folder).runs()]
    return [summary.error for summary in summaries if summary is not None and summary.error is not None]


def assert_mended(workspace: Path, replaced: Replaced, undisturbed: Path) -> None:
    """Put the weights back; the sweep, and another one over the same cache, are as if nothing had been."""
    replaced.put_back()
    succeeds("resume", "sweep", cwd=workspace)
    replaced.answered.clear()
    succeeds(*SWEEP, "output.dir=fresh", cwd=workspace, OLLAMA_HOST=replaced.server.url)
    assert not replaced.answered
    for name in ("sweep", "fresh"):
        assert records(workspace / name) == records(undisturbed)
        assert calls(workspace / name) == calls(undisturbed)
        assert "4 runs: 4 identical" in succeeds("verify", name, "--workers=1", cwd=workspace).stdout


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.exhaustive)])
def test_answers_of_replaced_weights_leave_the_cache_and_the_runs_that_used_them_fail(workers: int, tmp_path: Path):
    replaced = Replaced(at=MIDWAY)
    with replaced.serve() as server:
        stopped = foundry(*SWEEP, "output.dir=sweep", f"runner.workers={workers}", cwd=tmp_path, OLLAMA_HOST=server.url)
    line, said = one_line(stopped), errors(tmp_path / "sweep")
    failed = statuses(tmp_path / "sweep").count("failed")
    assert stopped.returncode == 3 and replaced.second
    assert f"Model '{MODEL}' changed during the sweep (digest d4d4d4d4d4d4 at" in line
    assert "Restore the first model and continue with foundry resume" in line
    kept = cached_answers(tmp_path / "outputs" / "answers.sqlite")
    given = sum(replaced.answered.values()) + len(replaced.second)
    counted = re.search(r"\((\d+) answers removed, (\d+) runs failed\)", line)
    assert counted and int(counted[2]) == failed
    assert 0 < int(counted[1]) <= given - kept  # some were not kept at all, since they came later
    assert failed == len(said) >= 1 and all("changed during the sweep" in one for one in said)
    assert statuses(tmp_path / "sweep").count("complete") >= 1 or workers > 1
    assert unconfirmed(tmp_path) == 0
    folder = SweepFolder.open(tmp_path / "sweep")
    complete = [run for run in folder.runs() if (one := run.summary()) and one.status == "complete"]
    with contextlib.closing(sqlite3.connect(tmp_path / "outputs" / "answers.sqlite")) as database:
        there = {key for (key,) in database.execute("SELECT key FROM answers")}
    assert {call.key for run in complete for call in run.calls()} == there


@pytest.mark.slow
def test_a_sweep_whose_weights_changed_is_told_of_everywhere_and_mended_when_they_are_put_back(
    tmp_path: Path, undisturbed: Path
):
    replaced, cache = Replaced(at=MIDWAY), tmp_path / "outputs" / "answers.sqlite"
    with replaced.serve() as server:
        foundry(*SWEEP, "output.dir=sweep", cwd=tmp_path, OLLAMA_HOST=server.url)
        asked, confirmed = len(server.bodies), cached_answers(cache)
        refused = foundry("resume", "sweep", cwd=tmp_path)
        assert refused.returncode == 2
        assert one_line(refused).endswith(
            "changed since this sweep began (digest d4d4d4d4d4d4 then, ffffffffffff now). Restore the first weights "
            "and try again, or start a new sweep in another output.dir."
        )
        examined = foundry(
            "doctor", *SWEEP, "output.dir=sweep", "--no-calls", "--json", cwd=tmp_path, OLLAMA_HOST=server.url
        )
        assert examined.returncode == 3
        assert "its digest is ffffffffffff, but the sweep in output.dir began with d4d4d4d4d4d4" in examined.stdout
        verified = foundry("verify", "sweep", "--workers=1", cwd=tmp_path)
        assert "steps: Model 'qwen3:4b' changed during the sweep" in verified.stdout
        assert "failed" in foundry("status", "sweep", cwd=tmp_path).stdout
        assert_mended(tmp_path, replaced, undisturbed)
        assert len(server.bodies) == asked + CALLS - confirmed
        replaced.put(SECOND)
        succeeds(*SWEEP, "output.dir=new", cwd=tmp_path, OLLAMA_HOST=server.url)
        assert statuses(tmp_path / "new") == ["complete"] * 4


@pytest.mark.slow
@pytest.mark.parametrize("written_anew", [True, pytest.param(False, marks=pytest.mark.exhaustive)])
def test_what_a_killed_worker_left_unconfirmed_is_asked_again_if_the_weights_were_written_anew(
    written_anew: bool, tmp_path: Path, undisturbed: Path
):
    replaced = Replaced(at=MIDWAY if written_anew else 10**9, written=written_anew, held_from=MIDWAY + 6)
    cache = tmp_path / "outputs" / "answers.sqlite"
    with replaced.serve() as server:
        arguments = (*SWEEP, "output.dir=sweep", "runner.workers=1")
        with started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
            wait_until(lambda: cached_answers(cache) == MIDWAY + 5, "every answer given is in the cache", process)
            kill(process.pid)
        replaced.held_from = None
        left, asked_of_others = unconfirmed(tmp_path), len(replaced.second)
        assert (asked_of_others == 6 and left >= 6) if written_anew else left > 0
        assert_mended(tmp_path, replaced, undisturbed)
        assert sum(server.answered.values()) == CALLS + (left if written_anew else 0)
        assert written_anew or unconfirmed(tmp_path) == 0


def test_what_a_run_that_failed_was_answered_is_confirmed_at_the_end_and_not_paid_again(tmp_path: Path):
    """The weights are written anew before it goes on: then an answer that waits for a confirmation is not used."""

    def answer(body: Body) -> str | ollama_cases.ChatCase:
        return refused(400, "no") if len(server.bodies) == 8 else grid_answer(body)

    one_by_one = ("model.server.in_flight={min: 1, max: 1, initial: 1}", "runner.workers=1")
    with OllamaServer(answer) as server:
        asked = (f"model={MODEL}", *SHAPE[1:], *one_by_one, "output.dir=sweep")
        assert foundry(*asked, cwd=tmp_path, OLLAMA_HOST=server.url).returncode == 3
        server.models[MODEL].modified_at = "2026-09-02T12:00:00Z"
        succeeds("resume", "sweep", cwd=tmp_path)
        assert len(server.bodies) == CALLS_OF_A_RUN + 1


def unconfirmed(workspace: Path) -> int:
    with contextlib.closing(sqlite3.connect(workspace / "outputs" / "answers.sqlite")) as database:
        return int(database.execute("SELECT count(*) FROM unconfirmed").fetchone()[0])


@pytest.mark.slow
def test_weights_that_are_back_when_the_server_is_asked_are_found_by_their_date(tmp_path: Path, undisturbed: Path):
    replaced = Replaced(at=MIDWAY, written=True)
    replaced.then = lambda call: replaced.put_back() if call == MIDWAY + 4 else None
    with replaced.serve() as server:
        stopped = foundry(*SWEEP, "output.dir=sweep", cwd=tmp_path, OLLAMA_HOST=server.url)
        assert (
            stopped.returncode == 3
            and "digest d4d4d4d4d4d4 as at the start, but the model was installed" in one_line(stopped)
        )
        assert_mended(tmp_path, replaced, undisturbed)


@pytest.mark.slow
def test_one_of_two_servers_that_changes_stops_the_sweep(tmp_path: Path, undisturbed: Path):
    replaced = Replaced(at=MIDWAY // 2)
    with OllamaServer() as steady, replaced.serve() as server:
        hosts = f"{steady.url},{server.url}"
        stopped = foundry(*SWEEP, "output.dir=sweep", cwd=tmp_path, OLLAMA_HOST=hosts)
        assert stopped.returncode == 3
        assert "changed during the sweep (Model 'qwen3:4b' differs between hosts" in one_line(stopped)
        replaced.put_back()
        succeeds("resume", "sweep", cwd=tmp_path)
        assert records(tmp_path / "sweep") == records(undisturbed)


@pytest.mark.slow
def test_a_sweep_that_takes_all_from_a_confirmed_cache_asks_nothing_more_nor_from_one_of_an_older_foundry(
    tmp_path: Path,
):
    with OllamaServer() as server:
        to = {"cwd": tmp_path, "OLLAMA_HOST": server.url}
        succeeds(*SWEEP, "output.dir=one", **to)
        asked = len(server.headers)
        succeeds(*SWEEP, "output.dir=two", **to)
        assert len(server.headers) - asked == 3  # its list, the model and its version, before the sweep begins
        assert unconfirmed(tmp_path) == 0
        with contextlib.closing(sqlite3.connect(tmp_path / "outputs" / "answers.sqlite")) as database:
            database.executescript("DROP TABLE unconfirmed; DROP TABLE removals")
        succeeds(*SWEEP, "output.dir=three", **to)
        assert len(server.bodies) == CALLS
    assert calls(tmp_path / "one") == calls(tmp_path / "two") == calls(tmp_path / "three")


OPENAI = ("-m", "model=openai/a", *SHAPE, "runner.open_runs=2", "model.server.retry.wait_initial_s=0.01")


def load_an_adapter_anew(server: OpenAIServer, body: Body) -> str:
    """Give the name another root, from the middle on, and answer otherwise."""
    if len(server.bodies) >= MIDWAY:
        server.models["a"] = {"root": "second"}
    return grid_reply(body if server.models["a"]["root"] == "first" else {**body, "seed": -1})


def say_another_fingerprint(server: OpenAIServer, body: Body) -> ChatCase:
    if len(server.bodies) < MIDWAY:
        return ChatCase(grid_reply(body))
    return ChatCase(grid_reply({**body, "seed": -1}), fingerprint="fp_other")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("models", "answer", "how"),
    [
        ({"a": {"root": "first"}}, load_an_adapter_anew, "digest listed-"),
        (
            None,
            say_another_fingerprint,
            "its replies first reported fingerprint 'fp_44709d6fcb', and now report 'fp_other'",
        ),
    ],
)
def test_a_server_that_lists_another_model_or_says_another_fingerprint_loses_its_unconfirmed_answers(
    models, answer, how, tmp_path: Path
):
    with OpenAIServer(models=models) as server:
        server.answer = partial(answer, server)
        stopped = foundry(*OPENAI, "output.dir=sweep", cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
        assert stopped.returncode == 3 and how in one_line(stopped) and "answers removed" in one_line(stopped)
        server.answer = grid_reply
        server.models["a"] = {"root": "first"} if models else {}
        succeeds("resume", "sweep", cwd=tmp_path)
        settings = (f"cache.path={tmp_path}/other.sqlite", "output.dir=undisturbed")
        succeeds(*OPENAI, *settings, cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
    assert records(tmp_path / "sweep") == records(tmp_path / "undisturbed")


def test_a_service_whose_fingerprints_alternate_can_be_swept_when_that_is_allowed(tmp_path: Path):
    with OpenAIServer() as server:
        server.answer = lambda body: ChatCase(grid_reply(body), fingerprint=f"fp_{len(server.bodies) % 2}")
        arguments = (*OPENAI, "output.dir=sweep", "model.server.one_fingerprint=false")
        succeeds(*arguments, cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
    versions = {call.server_version for run in SweepFolder.open(tmp_path / "sweep").runs() for call in run.calls()}
    assert versions == {"fp_0", "fp_1"}
