"""What a server told of itself with a reply stands in the record of every call; older records lack it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
import zstandard

from commands import foundry, statuses
from foundry.storing.store import SweepFolder
from ollama_cases import ChatCase, FakeModel
from ollama_server import OllamaServer

SWEEP = ("model=qwen3:4b", "world.agents=3", "world.steps=2", "analyze=false", "runner.workers=1")
NEW = ("server_version", "served_model", "remote")
REMOTE = {"remote_model": "gpt-oss:120b", "remote_host": "https://ollama.com:443"}


@pytest.fixture
def played(tmp_path: Path) -> Path:
    with OllamaServer(version="0.32.15") as server:
        for name in ("sweep", "cached"):
            assert foundry(*SWEEP, f"output.dir={name}", cwd=tmp_path, OLLAMA_HOST=server.url).returncode == 0
    return tmp_path


def told(folder: Path) -> set[tuple[str | None, str | None, bool]]:
    calls = [call for run in SweepFolder.open(folder).runs() for call in run.calls()]
    return {(call.server_version, call.served_model, call.cached) for call in calls}


@pytest.mark.slow
def test_every_call_names_the_servers_version_and_the_model_as_it_told_them_replayed_and_forked_too(played: Path):
    assert told(played / "sweep") == {("0.32.15", "qwen3:4b", False)}
    assert told(played / "cached") == {("0.32.15", "qwen3:4b", True)}
    (run,) = SweepFolder.open(played / "sweep").runs()
    assert foundry(f"model=replay/{played}/sweep", *SWEEP[1:], "output.dir=replayed", cwd=played).returncode == 0
    forked = ("fork", str(run.path), "--at", "2", "model=scripted/stay", "output.dir=forked")
    done = foundry(*forked, "runner.workers=1", "analyze=false", cwd=played)
    assert done.returncode == 0, done.stderr
    assert told(played / "replayed") == {("0.32.15", "qwen3:4b", True)}
    assert ("0.32.15", "qwen3:4b", True) in told(played / "forked")


@pytest.mark.slow
def test_records_from_before_they_were_kept_are_read_verified_replayed_and_forked(played: Path):
    (run,) = SweepFolder.open(played / "sweep").runs()
    lines = []
    for call in run.calls():
        line = msgspec.to_builtins(call)
        lines.append(msgspec.json.encode({key: value for key, value in line.items() if key not in NEW}) + b"\n")
    run.stream_path("calls").write_bytes(zstandard.compress(b"".join(lines)))
    assert told(played / "sweep") == {(None, None, False)}
    verified = foundry("verify", "sweep", "--workers=1", cwd=played)
    assert verified.returncode == 0 and "1 identical" in verified.stdout
    assert foundry(f"model=replay/{played}/sweep", *SWEEP[1:], "output.dir=replayed", cwd=played).returncode == 0
    forked = ("fork", str(run.path), "--at", "2", "model=scripted/stay", "output.dir=forked")
    assert foundry(*forked, "runner.workers=1", "analyze=false", cwd=played).returncode == 0
    assert statuses(played / "replayed") == statuses(played / "forked") == ["complete"]


def test_a_model_that_runs_elsewhere_is_refused_unless_that_is_allowed_and_then_recorded(tmp_path: Path):
    body = {
        "message": {"role": "assistant", "content": '{"action": "stay"}'},
        "done": True,
        "done_reason": "stop",
        **REMOTE,
    }
    reply = ChatCase(raw=msgspec.json.encode(body))
    with OllamaServer(lambda _: reply, models=[FakeModel("qwen3:4b", more=REMOTE)]) as server:
        refused = foundry(*SWEEP, "output.dir=refused", cwd=tmp_path, OLLAMA_HOST=server.url)
        allowed = foundry(*SWEEP, "model.server.remote=true", "output.dir=out", cwd=tmp_path, OLLAMA_HOST=server.url)
        doctor = foundry("doctor", "--json", *SWEEP, "model.server.remote=true", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert refused.returncode == 2 and not (tmp_path / "refused").exists()
    (line,) = refused.stderr.splitlines()
    assert "calls go to gpt-oss:120b at https://ollama.com:443" in line and "model.server.remote=true" in line
    assert allowed.returncode == 0, allowed.stderr
    sweep = SweepFolder.open(tmp_path / "out")
    assert {call.remote for run in sweep.runs() for call in run.calls()} == {"gpt-oss:120b at https://ollama.com:443"}
    assert [model["remote"] for model in sweep.models] == ["gpt-oss:120b at https://ollama.com:443"]
    assert "passes calls on to gpt-oss:120b" in doctor.stdout


def test_a_reply_from_elsewhere_ends_the_sweep_and_the_setting_is_in_no_identity(tmp_path: Path):
    body = {"message": {"role": "assistant", "content": "hello"}, "done": True, **REMOTE}
    with OllamaServer(lambda _: ChatCase(raw=msgspec.json.encode(body))) as server:
        done = foundry(*SWEEP, "output.dir=out", cwd=tmp_path, OLLAMA_HOST=server.url)
        planned = [
            foundry("plan", *SWEEP, f"model.server.remote={remote}", "--json", cwd=tmp_path, OLLAMA_HOST=server.url)
            for remote in ("true", "false")
        ]
    assert done.returncode == 3 and "calls go to gpt-oss:120b" in done.stdout + done.stderr
    first, second = (msgspec.json.decode(plan.stdout)["runs"] for plan in planned)
    assert first == second
