"""What a shell is told when it completes the command; asked as the scripts for bash and zsh ask."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from commands import environment, foundry
from foundry.composing import shown
from ollama_server import OllamaServer

NOBODY = "http://127.0.0.1:9"


def bash(*words: str, cwd: Path, host: str = NOBODY) -> list[str]:
    """Return what bash is told about the last of these words, which it has taken apart at `=` and `:`."""
    asked = {"COMP_WORDS": "\n".join(["foundry", *words]), "COMP_CWORD": str(len(words))}
    done = foundry(cwd=cwd, _FOUNDRY_COMPLETE="complete_bash", OLLAMA_HOST=host, **asked)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def zsh(line: str, cwd: Path) -> str:
    asked = {"_FOUNDRY_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": line, "OLLAMA_HOST": NOBODY}
    return foundry(cwd=cwd, **asked).stdout


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["-m", "model", "=", "scripted/rand"], ["scripted/random"]),
        (["-m", "model", "=", "a,scripted/rand"], ["a,scripted/random"]),
        (["plan", "-m", "world", "=", "cliff"], ["cliff_walking"]),
        (["+sweep", "=", "cross"], ["cross_model"]),
        (["world.half"], ["world.half_size=25"]),
        (["model.server.ho"], ["model.server.hosts="]),
        (["seed"], ["seed=0"]),
        (["runn"], ["runner=dask", "runner=local"]),
        (["prompt", "=", "paper", "world", "=", "gall"], ["gallery"]),
        (["status", "--js"], ["--json"]),
        (["statu"], ["status"]),
    ],
)
def test_bash_is_told_what_fits(words: list[str], expected: list[str], workspace: Path):
    assert bash(*words, cwd=workspace) == expected


def test_all_that_fits_is_told_to_bash_and_the_same_as_whole_words_to_zsh(workspace: Path):
    assert {"scripted/random", "openai", "ollama"} <= set(bash("-m", "model", "=", cwd=workspace))
    assert {"resume", "runner=local"} <= set(bash("r", cwd=workspace))
    assert zsh("foundry -m model=scripted/rand", workspace) == """_arguments '*: :(("model=scripted/random"))'\n"""
    assert '"status"' in zsh("foundry sta", workspace)


def test_models_of_the_server_are_told_with_their_tags(workspace: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(shown, "PATIENCE_S", None)
    with OllamaServer() as server:
        assert bash("-m", "model", "=", "qwen2.5vl", ":", "3", cwd=workspace, host=server.url) == ["3b"]
        assert "llama3.2" in bash("model", "=", "lla", cwd=workspace, host=server.url)


def test_sweeps_runs_and_parts_of_ones_own_are_told_where_a_command_takes_them(workspace: Path):
    for name in ("one", "two"):
        run = workspace / "outputs" / name / "runs" / "scripted-stay-s0-x"
        run.mkdir(parents=True)
        (workspace / "outputs" / name / "sweep.yaml").touch()
    assert bash("status", "", cwd=workspace) == ["outputs/one", "outputs/two"]
    assert bash("analyze", "outputs/one", "outputs/t", cwd=workspace) == ["outputs/two"]
    assert bash("replay", "outputs/two", cwd=workspace) == ["outputs/two/runs/scripted-stay-s0-x"]
    (workspace / "mine" / "world").mkdir(parents=True)
    (workspace / "mine" / "world" / "market.yaml").touch()
    assert bash("--config-dir", "mine", "world", "=", "mark", cwd=workspace) == ["market"]


def test_bash_itself_completes_with_the_script_that_is_installed(workspace: Path):
    shell = shutil.which("bash")
    if shell is None:
        pytest.skip("needs bash")
    named = workspace / "foundry"
    named.write_text(f'#!/bin/sh\nexec {sys.executable} -m foundry "$@"\n')
    named.chmod(0o755)
    script = (
        f'PATH="{workspace}:$PATH"; eval "$(_FOUNDRY_COMPLETE=source_bash foundry)"; '
        "COMP_WORDS=(foundry -m model = scripted/rand); COMP_CWORD=4; "
        "_foundry_completion foundry; echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(
        [shell, "-c", script], env=environment(PATH=os.environ["PATH"]), capture_output=True, text=True
    )
    assert done.stdout == "scripted/random\n", done.stderr


def test_completing_loads_nothing_that_takes_long(workspace: Path):
    loaded = "import sys; from foundry.cli import run; run([]); sys.stderr.write(' '.join(sys.modules))"
    asked = {"_FOUNDRY_COMPLETE": "complete_bash", "COMP_WORDS": "foundry\nmodel\n=\nscr", "COMP_CWORD": "3"}
    done = subprocess.run(
        [sys.executable, "-c", loaded], env=environment(OLLAMA_HOST=NOBODY, **asked), capture_output=True, text=True
    )
    assert "scripted/random" in done.stdout
    assert {"numpy", "hydra", "omegaconf", "aiohttp", "httpx", "pandas", "jinja2"} & set(done.stderr.split()) == set()
