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


def test_a_command_seeks_garbage_seldom_and_takes_nothing_apart_at_its_end():
    told = "atexit.register(lambda: print(gc.get_threshold()[0] > 700, gc.get_freeze_count() > 10_000))"
    code = f"import atexit, gc; {told}; from foundry.__main__ import main; main()"
    command = [sys.executable, "-c", code, "--version"]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert said.splitlines()[1:] == ["True True"]


HEAVY = {"analysis", "joblib", "json_repair", "matplotlib", "pandas", "pyarrow", "scipy"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "spared"), [("['plan']", {"filelock", "foundry.running.lane", "rich.progress"}), ("[]", {"pydantic"})]
)
def test_a_plan_and_a_single_run_load_nothing_that_they_have_no_use_for(asked: str, spared: set[str], tmp_path: Path):
    argv = f"[*{asked}, 'model=scripted/random', 'world.steps=1', 'output.dir=out', 'analyze=false']"
    code = f"import sys; from foundry.cli import run; run({argv}); print({HEAVY | spared} & sys.modules.keys())"
    said = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert said.splitlines()[-1] == "set()"
