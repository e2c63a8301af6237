"""`foundry doctor` against a real server: what is fine, what would fail, and what would silently mislead."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from commands import foundry
from foundry.doctor.longest import longest_prompt
from foundry.preflight import prompt_of, scenario_of
from ollama_cases import Body, ChatCase, grid_answer
from ollama_server import OllamaServer

FEW = ("world.agents=3", "world.steps=4", "world.history={memory: 2, messages: 3}")


def findings(server: OllamaServer, cwd: Path, *arguments: str) -> tuple[int, dict[str, dict[str, Any]]]:
    done = foundry("doctor", "--json", *arguments, *FEW, cwd=cwd, OLLAMA_HOST=server.url)
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    return done.returncode, {row["check"]: row for row in rows}


def test_a_sweep_that_would_run_has_no_problems(tmp_path: Path):
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=llama3.2")
    assert code == 0
    assert {row["status"] for row in found.values()} == {"ok"}
    assert set(found) == {"versions", "disk", "model", "context", "parallel slots", "seeds"}
    assert list(tmp_path.iterdir()) == []


def test_the_table_says_the_same_for_people(tmp_path: Path):
    with OllamaServer() as server:
        done = foundry("doctor", "model=llama3.2", *FEW, cwd=tmp_path, OLLAMA_HOST=server.url)
    assert done.returncode == 0
    assert "parallel slots" in done.stdout and "digest b2b2b2b2b2b2" in done.stdout


def test_a_model_that_is_not_there_is_a_problem(tmp_path: Path):
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=lama3.2")
    assert code == 3
    assert found["model"]["status"] == "problem" and "Did you mean 'llama3.2:latest'?" in found["model"]["found"]


def test_a_server_that_is_not_there_is_a_problem(tmp_path: Path):
    done = foundry("doctor", "--json", "model=llama3.2", *FEW, cwd=tmp_path, OLLAMA_HOST="http://127.0.0.1:9")
    assert done.returncode == 3
    assert "no connection (" in done.stdout


@pytest.mark.parametrize("slots", [1, 4])
def test_the_slots_that_the_server_really_has_are_counted(slots: int, tmp_path: Path):
    with OllamaServer(slots=slots, latency_s=0.02) as server:
        _, found = findings(server, tmp_path, "model=llama3.2")
    assert found["parallel slots"]["found"].startswith(f"{slots} at once")


def test_a_context_too_short_for_the_longest_prompt_is_a_problem(tmp_path: Path):
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=llama3.2", "model.options.num_ctx=512")
    assert code == 3
    assert "is refused" in json.dumps(list(found.values()))


def test_a_context_that_only_very_long_replies_would_fill_is_a_warning(tmp_path: Path):
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=llama3.2", "model.options.num_ctx=2000")
    assert code == 0
    assert (
        found["context"]["status"] == "warning"
        and "characters fit, as common replies give" in found["context"]["found"]
    )


def test_a_reply_that_would_not_fit_behind_the_longest_prompt_is_a_warning(tmp_path: Path):
    with OllamaServer() as server:
        _, whole = findings(server, tmp_path, "model=llama3.2")
        tokens = int(whole["context"]["found"].split()[2].replace(",", ""))
        code, found = findings(server, tmp_path, "model=llama3.2", f"model.options.num_ctx={tokens + 100}")
    assert code == 0
    assert found["context"]["status"] == "warning" and "would be cut" in found["context"]["advice"]


def drifting() -> Callable[[Body], str | ChatCase]:
    numbers = count()
    return lambda body: f"{next(numbers)} {grid_answer(body)}"


def test_a_server_that_ignores_seeds_is_a_warning(tmp_path: Path):
    with OllamaServer(drifting()) as server:
        code, found = findings(server, tmp_path, "model=llama3.2")
    assert code == 0
    assert found["seeds"]["status"] == "warning" and "0% equal under load" in found["seeds"]["found"]


@pytest.mark.slow
def test_a_blind_model_in_a_world_of_images_is_a_problem(tmp_path: Path):
    with OllamaServer() as server:
        done = foundry(
            "doctor", "--json", "--no-calls", "world=kibo", "model=llama3.2", cwd=tmp_path, OLLAMA_HOST=server.url
        )
    found = {row["check"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert done.returncode == 3
    assert found["vision"]["status"] == "problem" and found["drawing"]["status"] == "ok"
    assert found["calls"]["status"] == "skipped" and server.bodies == []


def test_the_longest_prompt_holds_a_full_history_of_the_longest_replies(grid_config: dict[str, Any]):
    scenario, prompt = scenario_of(grid_config), prompt_of(grid_config)
    short = longest_prompt(scenario, prompt, seed=0, reply_tokens=30)
    long = longest_prompt(scenario, prompt, seed=0, reply_tokens=300)
    assert long.characters > short.characters + 5 * 270 * 4
