"""The command from its first instruction on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize("reached", ["typer.models", "foundry.commands.application"])
def test_an_interrupt_while_the_command_is_being_loaded_is_one_line(reached: str, tmp_path: Path):
    command = [sys.executable, "-X", "importtime", "-m", "foundry", "model=scripted/stay", "world.steps=1"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=dict(os.environ), stderr=subprocess.PIPE, text=True,
        pipesize=4096,  # it cannot run ahead to its end before it is read that far
    ) as process:  # fmt: skip
        assert process.stderr is not None
        said = iter(process.stderr.readline, "")
        next(line for line in said if line.rstrip().endswith(f" {reached}"))
        process.send_signal(signal.SIGINT)
        rest = [line for line in said if not line.startswith("import time:")]
    assert process.returncode == 130
    assert rest == ["foundry: interrupted\n"]
    assert list(tmp_path.iterdir()) == []
