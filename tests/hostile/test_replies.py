"""Replies of many megabytes and of strange characters are read, or refused, and never reach a terminal raw."""

import io
import sys
from pathlib import Path

import pytest

from commands import SMALL, foundry
from foundry.commands.printing import for_screen
from foundry.texts import visible
from ollama_cases import ChatCase
from ollama_server import OllamaServer


class Terminal(io.StringIO):
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
