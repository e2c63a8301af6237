"""What a shell is told when it completes the command; asked as the scripts for bash and zsh ask."""

from pathlib import Path

import pytest

from commands import foundry


def bash(*words: str, cwd: Path) -> list[str]:
    """Return what bash is told about the last of these words."""
    asked = {"COMP_WORDS": " ".join(["foundry", *words]), "COMP_CWORD": str(len(words))}
    done = foundry(cwd=cwd, _FOUNDRY_COMPLETE="complete_bash", **asked)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


@pytest.mark.parametrize(("words", "expected"), [(["status", "--js"], ["--json"]), (["statu"], ["status"])])
def test_bash_is_told_commands_and_options(words: list[str], expected: list[str], workspace: Path):
    assert bash(*words, cwd=workspace) == expected


def test_zsh_is_told_commands(workspace: Path):
    asked = {"_FOUNDRY_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": "foundry sta"}
    assert '"status"' in foundry(cwd=workspace, **asked).stdout
