"""Replies of many megabytes and of strange characters are read, or refused, and never reach a terminal raw."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from commands import SMALL, foundry, statuses
from foundry.commands.application import for_screen
from foundry.records import Outcome
from foundry.storing.store import SweepFolder
from foundry.texts import visible
from foundry.worlds.base import Answer
from foundry.worlds.camera.language.interpreter import JsonInterpreter, LastSentenceInterpreter, LatestInterpreter
from foundry.worlds.grid.parsing import read_action, read_message
from ollama_cases import ChatCase
from ollama_server import OllamaServer
from openai_server import ChatCase as OpenAICase
from openai_server import OpenAIServer

LARGE = 10_000_000
TEXTS = {
    "braces": "{" * LARGE,
    "objects": '{"action":' * (LARGE // 10),
    "quotes": "\"'" * (LARGE // 2),
    "escapes": '{"action": "' + "\\" * LARGE,
    "words": "move " * (LARGE // 5),
    "thinking": "<think>" * (LARGE // 7),
    "sentences": "I turn left. " * (LARGE // 13),
    "digits": "move " + "9" * LARGE,
}
READINGS = (Outcome.UNREADABLE, Outcome.REPAIRED, Outcome.EMPTY)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", TEXTS)
def test_ten_megabytes_are_read(name: str):
    answer = Answer(TEXTS[name])
    assert read_action(answer).outcome in READINGS
    assert read_message(answer).outcome in READINGS
    for interpreter in (LatestInterpreter(), LastSentenceInterpreter(), JsonInterpreter()):
        assert interpreter.read(TEXTS[name]).outcome in Outcome


@pytest.mark.slow
@pytest.mark.parametrize("name", TEXTS)
def test_half_a_million_characters_are_read_which_quadratic_time_would_not_allow(name: str):
    text = TEXTS[name][: LARGE // 20]
    assert read_action(Answer(text)).outcome in READINGS
    assert LatestInterpreter().read(text).outcome in Outcome


STRANGE = '{"action": "stay", "memory": "\x1b[2J\x1b]0;owned\x07\x00\u202e' + "x" * (LARGE // 2) + '"}'
ONE = ("world.agents=1", "world.steps=1", "analyze=false", "runner.workers=1", "output.dir=out")


def check_large_replies(folder: Path) -> None:
    assert statuses(folder) == ["complete"]
    (run,) = SweepFolder.open(folder).runs()
    assert max(len(call.text) for call in run.calls()) > LARGE // 2
    assert b"\x1b" not in run.steps_bytes() and b"\0" not in run.steps_bytes()


@pytest.mark.exhaustive
def test_replies_of_five_megabytes_of_ollama_are_kept_to_the_letter(tmp_path: Path):
    case = ChatCase(text=STRANGE, output_tokens=1, prompt_tokens=1)
    with OllamaServer(lambda body: case, keep_bodies=False) as server:
        done = foundry("model=qwen3:4b", *ONE, cwd=tmp_path, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stderr
    check_large_replies(tmp_path / "out")


@pytest.mark.exhaustive
def test_replies_of_five_megabytes_of_openai_are_kept_to_the_letter(tmp_path: Path):
    with OpenAIServer(lambda body: OpenAICase(text=STRANGE)) as server:
        done = foundry("model=openai/a", *ONE, cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
    assert done.returncode == 0, done.stderr
    check_large_replies(tmp_path / "out")


class Terminal(io.StringIO):
    """A terminal, as a command sees it."""

    def isatty(self) -> bool:
        return True


def test_what_a_terminal_is_shown_holds_no_commands(monkeypatch: pytest.MonkeyPatch):
    text = "a\x1b[2J\x1b]0;x\x07\r\x08\x9b31m\u202e\u2028b\n\té日"
    assert for_screen(text) == text
    monkeypatch.setattr(sys, "stdout", Terminal())
    assert for_screen(text) == r"a\x1b[2J\x1b]0;x\x07\r\x08\x9b31m\u202e\u2028b" + "\n\té日"
    assert visible("plain text") == "plain text"


def test_a_cause_from_a_server_is_shown_without_its_commands(tmp_path: Path):
    refusal = ChatCase(status=400, error="\x1b[31mred\x1b[0m [/red] \x07 two\nlines")
    with OllamaServer(lambda body: refusal) as server:
        arguments = ("model=qwen3:4b", *SMALL, "runner.workers=1", "output.dir=out")
        done = foundry(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url)
        shown = done.stdout + done.stderr + foundry("status", "out", cwd=tmp_path).stdout
    assert done.returncode == 3
    assert "\x1b" not in shown and "\x07" not in shown and r"\x1b[31mred" in shown and "[/red]" in shown
