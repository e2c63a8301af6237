"""`foundry doctor` against a real server: what is fine, what would fail, and what would silently mislead."""

import heapq
import json
import subprocess
from collections.abc import Callable
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from aiohttp import web
from msgspec import structs

from commands import foundry, succeeds
from foundry import paths
from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.doctor.hours import longest_prompt, remember_speed, speeds
from foundry.doctor.timing import Estimate, Use
from foundry.models.base import Reply, Request
from foundry.models.ollama.ollama_model import OllamaModel
from foundry.running.build import build
from foundry.running.load import BURST, LoadResult, busy_s
from local_server import LocalServer
from ollama_cases import EMPTY, Body, FakeModel, busy, grid_answer
from ollama_server import OllamaServer
from openai_server import OpenAIServer

FEWEST_CHARACTERS_A_TOKEN = 3.58
"""30,788 characters are 8,600 tokens with `prompt=japanese`, by the tokenizers of Qwen 3 and Llama 3."""
FEW = ("world.agents=3", "world.steps=4", "world.history={memory: 2, messages: 3}")


def found_by(done: subprocess.CompletedProcess[str]) -> dict[str, dict[str, Any]]:
    return {row["check"]: row for row in json.loads(done.stdout)["findings"]}


def findings(server: OllamaServer, cwd: Path, *arguments: str) -> tuple[int, dict[str, dict[str, Any]]]:
    done = foundry("doctor", "--json", *arguments, *FEW, cwd=cwd, OLLAMA_HOST=server.url)
    return done.returncode, found_by(done)


def config_of(*overrides: str) -> dict[str, Any]:
    composed = compose(overrides)
    return dict(composed.conditions[0].config)


def test_a_sweep_that_would_run_has_no_problems(tmp_path: Path):
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=llama3.2")
    assert code == 0
    assert all(set(row) == {"check", "subject", "status", "found", "advice"} for row in found.values())
    assert {row["status"] for check, row in found.items() if check != "parallel slots"} == {"ok"}
    assert set(found) == {"versions", "disk", "model", "context", "parallel slots", "seeds", "hours"}
    assert [file.name for file in tmp_path.rglob("*") if file.is_file()] == ["answers.speeds.json"]


def test_a_plan_tells_the_time_at_the_measured_speed_and_else_at_two_usual_ones(tmp_path: Path):
    asked = ("model=llama3.2", "seed=0-1", *FEW)
    with OllamaServer() as server:
        usual = foundry("plan", "-m", *asked, cwd=tmp_path, OLLAMA_HOST=server.url).stdout
        assert findings(server, tmp_path, *asked[:1])[0] == 0
        remember_speed(str(tmp_path / "outputs" / "answers.sqlite"), "llama3.2", 25.0)
        measured = foundry("plan", "-m", *asked, cwd=tmp_path, OLLAMA_HOST=server.url).stdout
    assert "at most 48 calls would be sent" in usual and "prompts: about " in usual
    assert "time: 48 s at 1 call a second, 2 s at 20; foundry plan --time measures the speed of your server" in usual
    assert "time: about 20 min at the speed measured before" in measured


def test_a_plan_times_a_few_calls_where_it_is_told_to_and_keeps_no_answer(tmp_path: Path):
    price, slow = "model.server.price={prompt: 1000000, reply: 2000000}", {"size_vram": 3_000_000_000}
    asked = ("-m", "model=llama3.2", "seed=0-1", price, *FEW)
    with OllamaServer(models=[FakeModel("llama3.2:latest", size=4_000_000_000, more=slow)]) as server:
        finished = foundry("plan", "--time", "--json", *asked, cwd=tmp_path, OLLAMA_HOST=server.url)
        asked_then = len(server.bodies)
        again = foundry("plan", *asked, cwd=tmp_path, OLLAMA_HOST=server.url).stdout
        assert len(server.bodies) == asked_then
    plan = json.loads(finished.stdout)
    (timed,) = plan["timed"]
    assert plan["to_send"] == timed["calls"] == 48
    assert len({json.dumps(body["messages"]) for body in server.bodies if body["messages"]}) == BURST
    assert timed["cost"] == pytest.approx(timed["prompt_tokens"] + 2 * timed["reply_tokens"])
    assert timed["note"].startswith("25% of the model") and timed["per_call_s"] > 0
    assert "at the speed measured before" in again
    assert [file.name for file in tmp_path.rglob("*") if file.is_file()] == ["answers.speeds.json"]


@pytest.mark.parametrize("runs", [1, 4])
def test_few_agents_in_few_runs_take_longer_than_a_burst_of_calls(runs: int):
    config = config_of("model=llama3.2", *FEW)
    scenario = scenario_of(config)
    use = Use(build(config["model"]), scenario, prompt_of(config), seed=0, key="", runs=runs)
    measured = LoadResult(None, True, 1.0, 1.2, 0.2, 10.0, 5.0, 21, 0, 0)
    estimate = Estimate.of(use, measured, 100)
    assert estimate.seconds == pytest.approx(100 * max(0.2, 1.2 / (3 * runs)))
    assert (estimate.prompt_tokens, estimate.reply_tokens, estimate.cost) == (1000, 500, None)


@pytest.mark.parametrize("slots", [1, 4, 8, 16])
def test_the_time_of_a_call_leaves_out_slots_that_are_free_at_the_end_of_a_burst(slots: int):
    work_s = np.random.default_rng(0).lognormal(sigma=0.5, size=BURST)
    free, ends = [0.0] * slots, []
    for seconds in work_s:
        ends.append(heapq.heappop(free) + seconds)
        heapq.heappush(free, ends[-1])
    assert busy_s(ends, slots) == pytest.approx(work_s.sum() / slots)


def test_the_canary_is_held_against_the_weights_that_gave_the_answers_in_the_cache(tmp_path: Path):
    def looked(server: OpenAIServer) -> str:
        done = foundry("doctor", "--json", "model=openai/a", *FEW, cwd=tmp_path, **to(server))
        return found_by(done)["canary"]["found"]

    def to(server: OpenAIServer) -> dict[str, str]:
        return {"OPENAI_BASE_URL": server.base_url, "FOUNDRY_CANARY": "true"}

    with OpenAIServer() as server:
        first = looked(server)
        succeeds("model=openai/a", "analyze=false", *FEW, cwd=tmp_path, **to(server))
        same = looked(server)
    assert first == "it answers; the cache of answers contains no canary to compare it with"
    assert same.startswith("weights compared with those that gave the cached answers: same (")


@pytest.mark.parametrize("damaged", ["", "{", "[1]", '{"a": "b"}'])
def test_a_damaged_file_of_speeds_counts_as_not_measured(damaged: str, tmp_path: Path):
    (tmp_path / "answers.speeds.json").write_text(damaged, encoding="utf-8")
    assert speeds(str(tmp_path / "answers.sqlite")) == {}


def test_a_sweep_with_too_few_seeds_is_warned_of_with_the_seeds_that_it_needs(tmp_path: Path):
    models = "model=scripted/random,scripted/avoid,scripted/herd"
    told = found_by(foundry("doctor", "--json", "-m", models, "seed=0-5", *FEW, cwd=tmp_path))["tests"]
    assert (told["status"], told["advice"]) == ("warning", "Ask for 7 seeds or more.")


@pytest.mark.slow
def test_a_sweep_that_is_run_with_too_few_seeds_names_the_command_that_adds_them(tmp_path: Path):
    asked = ("-m", "world=bar", "model=scripted/random,scripted/stay", "seed=0-1", "world.agents=2", "world.steps=2")
    ran = foundry(*asked, "output.dir=out", cwd=tmp_path)
    assert "with 2 seeds, no difference can be claimed; add seeds: foundry resume out seed=2-5" in ran.stdout
    added = foundry("resume", "out", "seed=2-5", cwd=tmp_path)
    assert added.returncode == 0 and "can be claimed; add seeds" not in added.stdout, "it counts the seeds of before"


def test_a_model_that_is_not_there_is_a_problem(tmp_path: Path):
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=lama3.2")
    assert code == 3
    assert found["model"]["status"] == "problem" and "Did you mean 'llama3.2:latest'?" in found["model"]["found"]
    assert found["model"]["advice"].endswith("ollama pull lama3.2")


def test_a_server_that_is_not_there_is_a_problem(tmp_path: Path):
    asked = ("-m", "model=llama3.2,qwen3:4b", *FEW)
    done = foundry("doctor", "--json", *asked, cwd=tmp_path, OLLAMA_HOST="http://127.0.0.1:9")
    failed = [row for row in json.loads(done.stdout)["findings"] if row["status"] not in ("ok", "warning")]
    assert done.returncode == 3
    assert [(row["check"], row["subject"]) for row in failed] == [("server", "http://127.0.0.1:9")]
    assert failed[0]["found"].startswith("no connection (")
    assert failed[0]["found"].endswith("Not checked: llama3.2, qwen3:4b")
    assert failed[0]["advice"].startswith("Start Ollama (")


class OutOfMemory(LocalServer):
    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        return web.Response(status=500, text='{"error": {"message": "CUDA out of memory"}}')


@pytest.mark.parametrize("model", ["a", "openai/a"])
def test_a_server_that_refuses_every_call_is_a_problem_with_a_cure(model: str, tmp_path: Path):
    with OutOfMemory() as server:
        where = {"OLLAMA_HOST": server.url, "OPENAI_BASE_URL": f"{server.url}/v1"}
        found = found_by(foundry("doctor", "--json", f"model={model}", *FEW, cwd=tmp_path, **where))
    assert found["server"]["found"] == f"500 CUDA out of memory. Not checked: {model}"
    assert "log of the server" in found["server"]["advice"] and "models" not in found
    with OpenAIServer(key="sk-of-the-tests") as locked:
        done = foundry("doctor", "--json", "model=openai/a", *FEW, cwd=tmp_path, OPENAI_BASE_URL=locked.base_url)
    assert found_by(done)["server"]["advice"].startswith("Put the key into OPENAI_API_KEY")


@pytest.fixture
def timed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Set a clock that only answers move on, by a second each; each slot of the server works on one at a time."""

    def begin(slots: int, timings: dict[str, float], worked_s: float = 0.0) -> None:
        now, slot_free, ask = 0.0, [0.0] * slots, OllamaModel.ask

        async def answer(model: OllamaModel, request: Request) -> Reply:
            nonlocal now
            sent, reply = now, await ask(model, request)
            now = max(sent, heapq.heappop(slot_free)) + 1
            heapq.heappush(slot_free, now)
            return structs.replace(reply, timings=timings)

        monkeypatch.setattr(OllamaModel, "ask", answer)
        clocks = SimpleNamespace(perf_counter=lambda: now, process_time=lambda: now * worked_s)
        monkeypatch.setattr("foundry.running.load.time", clocks)

    return begin


@pytest.mark.parametrize(("slots", "timings"), [(1, {"output": 1.0}), (4, {})])
def test_the_slots_that_the_server_really_has_are_counted(slots, timings, timed, tmp_path: Path):
    timed(slots, timings)
    with OllamaServer() as server:
        _, found = findings(server, tmp_path, "model=llama3.2")
    assert found["parallel slots"]["found"].startswith(f"{slots} at once")


@pytest.mark.parametrize(("timings", "worked_s"), [({"latency": 3.0, "total": 1.0}, 0.0), ({}, 0.9)])
def test_a_machine_that_is_too_slow_to_tell_claims_no_slots(timings, worked_s, timed, tmp_path: Path):
    timed(1, timings, worked_s)
    with OllamaServer() as server:
        code, found = findings(server, tmp_path, "model=llama3.2")
    assert code == 0 and found["parallel slots"]["status"] == "skipped"
    assert "too slow to separate" in found["parallel slots"]["found"]


def test_a_model_that_is_not_whole_on_the_gpu_is_a_warning(tmp_path: Path):
    loaded = FakeModel("llama3.2:latest", size=4_000_000_000, more={"size_vram": 3_000_000_000})
    with OllamaServer(models=[loaded]) as server:
        code, found = findings(server, tmp_path, "model=llama3.2")
    assert code == 0 and found["memory"]["status"] == "warning"
    assert "25% of the model is outside the GPU's memory and runs on the CPU" in found["memory"]["found"]


def test_slots_and_context_are_those_that_llama_cpp_tells(tmp_path: Path):
    props = {"total_slots": 4, "default_generation_settings": {"n_ctx": 512}}
    with OpenAIServer(models={"a": {"meta": {"n_ctx": 2048}}}, props=props) as server:
        asked = ("doctor", "--json", "model=openai/a", *FEW)
        done = foundry(*asked, cwd=tmp_path, OPENAI_BASE_URL=server.base_url)
    found = found_by(done)
    assert found["parallel slots"]["found"].startswith("4 at once, according to the server")
    assert "; context: 512 tokens" in found["context"]["found"]


def test_a_context_is_held_against_the_longest_prompt_and_the_reply_behind_it(tmp_path: Path):
    with OllamaServer() as server:
        _, whole = findings(server, tmp_path, "model=llama3.2")
        tokens = int(whole["context"]["found"].split()[2].replace(",", ""))
        for num_ctx, exit_code, said in (
            (512, 3, "is refused"),
            (1500, 0, "with shorter replies, the longest prompt ("),
            (tokens + 100, 0, "would be cut"),
        ):
            code, found = findings(server, tmp_path, "model=llama3.2", f"model.options.num_ctx={num_ctx}")
            assert code == exit_code and said in json.dumps(list(found.values()))
            assert found["context"]["status"] == ("problem" if exit_code else "warning")


def test_a_server_that_ignores_seeds_is_a_warning(tmp_path: Path):
    numbers = count()
    with OllamaServer(lambda body: f"{next(numbers)} {grid_answer(body)}") as server:
        code, found = findings(server, tmp_path, "model=llama3.2")
    assert code == 0
    assert found["seeds"]["status"] == "warning"
    assert "under load, 0% of the answers stay the same" in found["seeds"]["found"]


QUICK = ("model.server.retry.wait_initial_s=0.001", "model.server.retry.wait_max_s=0.001")


@pytest.mark.parametrize(
    ("replies", "exit_code", "check", "found"),
    [
        (lambda body, number: EMPTY, 0, "replies", "21 of 21 replies contain no text to read"),
        (
            lambda body, number: busy() if number == 1 else grid_answer(body),
            0,
            "tries",
            "1 of 21 calls were answered only after they were repeated",
        ),
        (lambda body, number: busy(), 3, "calls", "Given up after 6 tries"),
    ],
)
def test_replies_that_a_sweep_would_repeat_or_record_as_outcomes_are_told(
    replies: Callable[[Body, int], Any], exit_code: int, check: str, found: str, tmp_path: Path
):
    numbers = count()
    with OllamaServer(lambda body: replies(body, next(numbers))) as server:
        code, rows = findings(server, tmp_path, "model=llama3.2", *QUICK)
    assert code == exit_code, rows
    assert rows[check]["status"] == ("problem" if exit_code else "warning") and found in rows[check]["found"]


OWN_BACKEND = """
from foundry.models.base import Model, ModelInfo

class Broken(Model):
    costs = True
    def __init__(self, name, fails):
        self.name, self.fails = name, fails
    def parameters(self):
        return {}
    async def inspect(self):
        if self.fails == "inspect":
            raise KeyError("weights of mine")
        return ModelInfo(self.name, digest="d")
    async def ask(self, request):
        raise ZeroDivisionError("of mine")
"""


@pytest.mark.parametrize(
    ("fails", "check", "found"),
    [
        ("inspect", "model", "its class raises KeyError: 'weights"),
        ("ask", "calls", "its class raises ZeroDivisionError: of mine"),
    ],
)
def test_a_backend_of_ones_own_that_raises_is_a_problem_in_one_line(
    fails: str, check: str, found: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "brokenbackend.py").write_text(OWN_BACKEND, encoding="utf-8")
    (tmp_path / "model").mkdir()
    settings = f"_target_: brokenbackend.Broken\nname: mine\nfails: {fails}\n"
    (tmp_path / "model" / "mine.yaml").write_text(settings, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    done = foundry("doctor", "--json", "--config-dir", str(tmp_path), "model=mine", *FEW, cwd=tmp_path)
    row = found_by(done)[check]
    assert done.returncode == 3
    assert row["status"] == "problem" and row["found"].startswith(found)


@pytest.mark.exhaustive
def test_a_blind_model_in_a_world_of_images_is_a_problem(tmp_path: Path):
    with OllamaServer() as server:
        done = foundry(
            "doctor", "--json", "--no-calls", "world=kibo", "model=llama3.2", cwd=tmp_path, OLLAMA_HOST=server.url
        )
    found = found_by(done)
    assert done.returncode == 3
    assert found["vision"]["status"] == "problem" and found["drawing"]["status"] == "ok"
    assert found["drawing"]["found"].startswith("by ") and "EGL lists" in found["drawing"]["found"]
    assert found["calls"]["status"] == "skipped" and server.bodies == []


def test_the_documents_say_how_long_the_prompts_of_the_default_world_get_and_all_fit():
    config = config_of("model=llama3.2")
    scenario, prompt, options = scenario_of(config), prompt_of(config), config["model"]["options"]
    table = (paths.PACKAGE.parent / "docs" / "models.md").read_text(encoding="utf-8")
    assert f"fits into {options['num_ctx']:,}" in table
    for reply_tokens in (128, 512):
        longest = longest_prompt(scenario, prompt, seed=0, reply_tokens=reply_tokens)
        assert f"| {reply_tokens} tokens" in table and f"| {longest.characters:,} characters" in table
        assert longest.characters / FEWEST_CHARACTERS_A_TOKEN + options["num_predict"] <= options["num_ctx"]
