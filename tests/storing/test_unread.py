"""Unreadable replies of a model are reported by every view of a sweep."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from commands import foundry, succeeds
from foundry.storing.standing import unread
from foundry.storing.store import SweepFolder
from foundry.viewer.catalog import Catalog
from ollama_cases import ABORTED, Body, ChatCase
from ollama_server import OllamaServer

QUIET = ("analyze=false", "runner.workers=1", "output.dir=out")
SWEEP = ("model=qwen3:4b", "world.agents=4", "world.steps=3", *QUIET)
DECIDED = '{"message": null, "action": "stay", "reasoning": "r"}'
HINT = "try model.format=schema to force valid JSON"


def at_times(body: Body) -> str:
    """Say nothing that can be read in about a third of the replies, at length and with commands for a terminal."""
    seed = body["options"]["seed"]
    return f"\x1b[2J <b>I</b> am\nnumber {seed}, {'really ' * 100}" if seed % 3 == 0 else DECIDED


def hardly(body: Body) -> str:
    """Say nothing that can be read in one of 24 replies."""
    return "What?" if "You are Agent 2 " in str(body["messages"]) and "Step: 3" in str(body["messages"]) else DECIDED


def played(folder: Path, answer: object, *overrides: str) -> str:
    with OllamaServer(answer) as server:  # type: ignore[arg-type]
        done = foundry(*SWEEP, *overrides, cwd=folder, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check(shown: str, sweep: Path) -> None:
    (one,) = unread(SweepFolder.open(sweep).runs())
    lost, share = one.outcomes.total(), one.share
    (row,) = Catalog(sweep).sweeps()[0].rows(0, None)
    assert (row["undecided"], row["replies"]) == (lost, 24)
    assert 0.02 < share < 1
    assert f"qwen3:4b: {share:.1%} of 24 replies are unreadable ({lost} contain no decision). Examples:" in shown
    examples = re.findall(r"step \d, agent \d, \w+: .*", shown)
    assert len(examples) == 3 and all(r"\x1b[2J" in example and example.endswith("…") for example in examples)
    assert "\x1b" not in shown and max(map(len, examples)) < 220


def test_the_end_of_a_sweep_and_status_show_what_could_not_be_read_without_examples_where_files_are_damaged(
    tmp_path: Path,
):
    shown = played(tmp_path, at_times)
    check(shown, tmp_path / "out")
    status = foundry("status", "out", cwd=tmp_path).stdout
    check(status, tmp_path / "out")
    assert HINT in shown and HINT in status
    (run,) = SweepFolder.open(tmp_path / "out").runs()
    (run.path / "steps.jsonl").write_bytes(b'{"step": 1, "outcome": ["unreadable"]}\n{')
    done = succeeds("status", "out", cwd=tmp_path)
    assert "of 24 replies are unreadable" in done.stdout, done.stderr


def test_few_such_replies_are_not_worth_a_word(tmp_path: Path):
    assert " could not be read" not in played(tmp_path, hardly, "world.agents=20")


def test_a_schema_is_not_advised_where_there_is_one(tmp_path: Path):
    shown = played(tmp_path, hardly, "model.format=schema")
    assert "qwen3:4b: 8.3% of 24 replies are unreadable" in shown and HINT not in shown


def test_a_reply_that_was_read_is_no_example_where_an_agent_is_asked_twice_in_a_step(tmp_path: Path):
    def half(body: Body) -> str:
        return "no idea" if body["options"]["seed"] % 2 else '{"action": "bafu", "reasoning": "r"}'

    naming = ("model=qwen3:4b", "world=naming", "world.agents=4", "world.steps=8", *QUIET)
    with OllamaServer(half) as server:
        done = foundry(*naming, cwd=tmp_path, OLLAMA_HOST=server.url)
    (lost,) = unread(SweepFolder.open(tmp_path / "out").runs())
    assert [example.partition("say: ")[2] for example in lost.examples] == ["no idea"], done.stdout + done.stderr


@pytest.mark.parametrize(
    ("reply", "said"),
    [
        (replace(ABORTED, output_tokens=4), "24 aborted by the server"),
        (ChatCase(text="", done_reason="length"), "24 truncated"),
        (ChatCase(text=" "), "24 empty"),
    ],
)
def test_replies_that_never_came_are_said_as_well(reply: ChatCase, said: str, tmp_path: Path):
    retry = "model.server.retry={attempts: 2, unusable_attempts: 1, wait_initial_s: 0.001, wait_max_s: 0.001}"
    shown = played(tmp_path, lambda body: reply, retry)
    assert f"qwen3:4b: 100.0% of 24 replies are unreadable ({said}). Examples:" in shown
    assert HINT not in shown or "empty" in said
