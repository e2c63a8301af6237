"""Recorded sweeps that the tests export; the server that answered them is gone."""

import math
from pathlib import Path

import pytest

from commands import foundry, succeeds
from foundry.exporting.writing import Mean, Measured, Scores
from foundry.storing.store import SweepFolder
from ollama_cases import Body, ChatCase, grid_answer, refused
from ollama_server import OllamaServer

MADE_UP = Scores(
    (Measured("made.up", "Made up", -math.inf, math.inf, "", "low"),),
    {},
    {0: {"made.up": Mean(n=1, mean=2.0, sd=0.5, low=1.0, high=4.0, interval="t")}},
)
"""A measure without bounds that one of two runs has."""
THOUGHT = "Is there a fire?"
REFUSAL = "no more for today"


def answer(body: Body) -> ChatCase:
    """Return a reply with its thinking, of so many tokens; one model is refused."""
    if body["model"] == "llama3.2":
        return refused(400, REFUSAL)
    text = grid_answer(body)
    assert isinstance(text, str)
    return ChatCase(text=text, thinking=THOUGHT, prompt_tokens=300, output_tokens=20)


def exported(*arguments: str, cwd: Path, code: int = 0) -> str:
    done = foundry("export", *arguments, cwd=cwd)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="session")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """A served model that thinks, one whose calls are refused, and a scripted one; two seeds each."""
    folder = tmp_path_factory.mktemp("exported")
    small = ("world.agents=2", "world.steps=2", "analyze=false", "runner.workers=1", "output.dir=out")
    models = "model=qwen3:4b,llama3.2,scripted/random"
    with OllamaServer(answer) as server:
        cache = str(folder / "answers.sqlite")
        done = foundry("-m", models, "seed=0-1", *small, cwd=folder, OLLAMA_HOST=server.url, FOUNDRY_CACHE=cache)
    assert "4 of 6 runs complete" in done.stdout, done.stdout + done.stderr
    return SweepFolder.open(folder / "out")


@pytest.fixture(scope="session")
def seen(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """A walk in a 3D world, whose images are kept."""
    folder = tmp_path_factory.mktemp("seen")
    succeeds("world=gallery", "model=scripted/wander", "world.steps=2", "analyze=false", "output.dir=out", cwd=folder)
    return SweepFolder.open(folder / "out")
