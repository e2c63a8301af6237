"""What a server told of itself with a reply stands in the record of every call; older records lack it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
import zstandard

from commands import foundry, statuses
from foundry.storing.store import SweepFolder
from ollama_server import OllamaServer

SWEEP = ("model=qwen3:4b", "world.agents=3", "world.steps=2", "analyze=false", "runner.workers=1")
NEW = ("server_version", "served_model")


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
