"""What a server told of itself with a reply stands in the record of every call; older records lack it."""

from pathlib import Path

import msgspec
import pytest
import zstandard

from commands import foundry, succeeds
from foundry.storing.store import RunFolder, SweepFolder
from ollama_cases import ChatCase, FakeModel
from ollama_server import OllamaServer

SWEEP = ("model=qwen3:4b", "world.agents=3", "world.steps=2", "analyze=false", "runner.workers=1")
NEW = ("server_version", "served_model", "remote")
REMOTE = {"remote_model": "gpt-oss:120b", "remote_host": "https://ollama.com:443"}


def told(folder: Path) -> set[tuple[str | None, str | None, bool]]:
    calls = [call for run in SweepFolder.open(folder).runs() for call in run.calls()]
    return {(call.server_version, call.served_model, call.cached) for call in calls}


def replay_and_fork(home: Path, run: RunFolder, name: str) -> None:
    """Answer a run again from its record, and fork it, into folders that end in this name."""
    replay = (f"model=replay/{home}/sweep", *SWEEP[1:], f"output.dir=replayed-{name}")
    fork = ("fork", str(run.path), "--at", "2", "model=scripted/stay", f"output.dir=forked-{name}", *SWEEP[-2:])
    for command in (replay, fork):
        succeeds(*command, cwd=home)


@pytest.mark.slow
def test_every_call_names_the_servers_version_and_its_model_and_records_from_before_are_as_good(tmp_path: Path):
    with OllamaServer(version="0.32.15") as server:
        for name in ("sweep", "cached"):
            succeeds(*SWEEP, f"output.dir={name}", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert told(tmp_path / "sweep") == {("0.32.15", "qwen3:4b", False)}
    assert told(tmp_path / "cached") == {("0.32.15", "qwen3:4b", True)}
    (run,) = SweepFolder.open(tmp_path / "sweep").runs()
    replay_and_fork(tmp_path, run, "now")
    assert told(tmp_path / "replayed-now") == {("0.32.15", "qwen3:4b", True)}
    assert ("0.32.15", "qwen3:4b", True) in told(tmp_path / "forked-now")
    lines = [msgspec.to_builtins(call) for call in run.calls()]
    older = [{key: value for key, value in line.items() if key not in NEW} for line in lines]
    content = b"".join(msgspec.json.encode(line) + b"\n" for line in older)
    run.stream_path("calls").write_bytes(zstandard.compress(content))
    assert told(tmp_path / "sweep") == {(None, None, False)}
    assert "1 identical" in succeeds("verify", "sweep", "--workers=1", cwd=tmp_path).stdout
    replay_and_fork(tmp_path, run, "before")


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
