"""The command as a process: from its first instruction on, and what it loads."""

import ast
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from foundry.cli import app

TOLD_AT_THE_END = """
import atexit, gc, sys
atexit.register(lambda: print(([*sys.modules], gc.get_threshold()[0], gc.get_freeze_count()), file=sys.stderr))
from foundry.__main__ import main
main()
"""
THREADS_WHEN_NUMPY_IS_LOADED = """
import os, sys
class Watch:
    def find_spec(self, name, *_):
        if name == "numpy":
            print(os.environ.get("OPENBLAS_NUM_THREADS"))
sys.meta_path.insert(0, Watch())
from foundry.cli import run
run(sys.argv[1:])
"""
HEAVY = {"analysis", "joblib", "json_repair", "matplotlib", "pandas", "pyarrow", "scipy"}


def test_an_interrupt_while_the_command_is_being_loaded_is_one_line(tmp_path: Path):
    command = [sys.executable, "-X", "importtime", "-m", "foundry", "model=scripted/stay", "world.steps=1"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=dict(os.environ), stderr=subprocess.PIPE, text=True,
        pipesize=4096,  # it cannot run ahead to its end before it is read that far
    ) as process:  # fmt: skip
        assert process.stderr is not None
        said = iter(process.stderr.readline, "")
        next(line for line in said if line.rstrip().endswith(" foundry.commands.application"))
        process.send_signal(signal.SIGINT)
        rest = [line for line in said if not line.startswith("import time:")]
    assert process.returncode == 130
    assert rest == ["foundry: interrupted\n"]
    assert list(tmp_path.iterdir()) == []


def test_help_lists_all_commands_by_group_and_seeks_garbage_seldom_and_loads_nothing_that_takes_long():
    command = [sys.executable, "-c", TOLD_AT_THE_END, "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    *_, run, look, trust, extend = re.split(r"^(?:Run|Look|Trust|Extend):$", done.stdout, flags=re.MULTILINE)
    listed = [re.findall(r"^  (\w+)  ", group, re.MULTILINE) for group in (run, look, trust, extend)]
    assert all(listed) and sorted(sum(listed, [])) == sorted(get_command(app).commands)  # type: ignore[attr-defined]
    modules, threshold, frozen = ast.literal_eval(done.stderr)
    assert (HEAVY | {"numpy", "hydra", "aiohttp", "httpx", "asyncio"}) & set(modules) == set()
    assert threshold > 700
    assert frozen > 10_000, "it takes nothing apart at its end"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "spared"), [("['plan']", {"filelock", "foundry.running.lane", "rich.progress"}), ("[]", {"pydantic"})]
)
def test_a_plan_and_a_single_run_load_nothing_that_they_have_no_use_for(asked: str, spared: set[str], tmp_path: Path):
    argv = f"[*{asked}, 'model=scripted/random', 'world.steps=1', 'output.dir=out', 'analyze=false']"
    code = f"import sys; from foundry.cli import run; run({argv}); print({HEAVY | spared} & sys.modules.keys())"
    said = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert said.splitlines()[-1] == "set()"


@pytest.mark.parametrize(
    ("command", "set_before", "threads"),
    [
        ("analyze", {}, "1"),
        pytest.param("analyze", {"OPENBLAS_NUM_THREADS": "3"}, "3", marks=pytest.mark.slow),
        pytest.param("report", {}, "1", marks=pytest.mark.slow),
    ],
)
def test_an_analysis_multiplies_in_one_thread_unless_the_environment_says_otherwise(
    command: str, set_before: dict[str, str], threads: str, tmp_path: Path
):
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"} | set_before
    argv = [sys.executable, "-c", THREADS_WHEN_NUMPY_IS_LOADED, command, str(tmp_path)]
    done = subprocess.run(argv, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == f"{threads}\n"
    assert "sweep" in done.stderr
