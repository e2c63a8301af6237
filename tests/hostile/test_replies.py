"""Replies of many megabytes and of strange characters are read, or refused, and never reach a terminal raw."""

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

TEXTS = {
    "braces": ("", "{"),
    "objects": ("", '{"action":'),
    "quotes": ("", "\"'"),
    "escapes": ('{"action": "', "\\"),
    "words": ("", "move "),
    "thinking": ("", "<think>"),
    "sentences": ("", "I turn left. "),
    "digits": ("move ", "9"),
}
"""How a text begins, and what is repeated then."""
READINGS = (Outcome.UNREADABLE, Outcome.REPAIRED, Outcome.EMPTY)


@pytest.mark.parametrize(
    "length", [pytest.param(200_000, marks=pytest.mark.slow), pytest.param(10_000_000, marks=pytest.mark.exhaustive)]
)
@pytest.mark.parametrize("name", TEXTS)
def test_replies_are_read_that_are_too_long_for_quadratic_time(name: str, length: int):
    start, repeated = TEXTS[name]
    text = start + repeated * (length // len(repeated))
    assert read_action(Answer(text)).outcome in READINGS
    assert read_message(Answer(text)).outcome in READINGS
    for interpreter in (LatestInterpreter(), LastSentenceInterpreter(), JsonInterpreter()):
        assert interpreter.read(text).outcome in Outcome


@pytest.mark.exhaustive
@pytest.mark.parametrize("model", ["ollama/qwen3:4b", "openai/a"])
def test_replies_of_five_megabytes_are_recorded_without_what_commands_a_terminal(model: str, tmp_path: Path):
    text = '{"action": "stay", "memory": "\x1b[2J\x1b]0;owned\x07\x00\u202e' + "x" * 5_000_000 + '"}'
    one = ("world.agents=1", "world.steps=1", "analyze=false", "runner.workers=1", "output.dir=out")
    ollama = OllamaServer(lambda body: ChatCase(text=text, output_tokens=1, prompt_tokens=1), keep_bodies=False)
    with ollama, OpenAIServer(lambda body: OpenAICase(text=text)) as openai:
        servers = {"OLLAMA_HOST": ollama.url, "OPENAI_BASE_URL": openai.base_url}
        done = foundry(f"model={model}", *one, cwd=tmp_path, **servers)
    assert done.returncode == 0 and statuses(tmp_path / "out") == ["complete"], done.stderr
    (run,) = SweepFolder.open(tmp_path / "out").runs()
    assert max(len(call.text) for call in run.calls()) > 5_000_000
    assert b"\x1b" not in run.steps_bytes() and b"\0" not in run.steps_bytes()


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
