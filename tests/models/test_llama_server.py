"""Against a real server of llama.cpp: FOUNDRY_LLAMA_SERVER names the program `llama-server`."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import foundry, wait_until
from foundry import paths
from foundry.storing.store import SweepFolder

PROGRAM = os.environ.get("FOUNDRY_LLAMA_SERVER", "")
pytestmark = [
    pytest.mark.real_server,
    pytest.mark.skipif(not PROGRAM, reason="FOUNDRY_LLAMA_SERVER names no llama-server"),
]


@pytest.fixture(scope="module")
def llama(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Serve a tiny model with four slots; yields the base URL."""
    model = tmp_path_factory.mktemp("model") / "tiny.gguf"
    maker = paths.PACKAGE.parent / "benchmarks" / "tiny_gguf.py"
    subprocess.run([sys.executable, str(maker), str(model)], check=True)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = ["--alias", "tiny", "-np", "4", "-c", "16384", "-t", "1", "--metrics", "--port", str(port)]
    silent = subprocess.DEVNULL
    with subprocess.Popen([PROGRAM, "-m", str(model), *settings], stdout=silent, stderr=silent) as process:
        url = f"http://127.0.0.1:{port}"
        wait_until(lambda: is_ready(url), "the server is ready")
        yield url
        process.terminate()


def is_ready(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/health") as answer:
            return bool(answer.status == 200)
    except OSError:
        return False


def computed_tokens(url: str) -> int:
    with urllib.request.urlopen(f"{url}/metrics") as answer:
        found = re.search(r"^llamacpp:prompt_tokens_total (\d+)", answer.read().decode(), re.MULTILINE)
    assert found
    return int(found[1])


def test_what_is_recorded_as_cached_is_what_the_server_did_not_work_out(llama: str, workspace: Path):
    shares = {}
    for prompt in ("paper", "paper_prefix"):
        before = computed_tokens(llama)
        done = foundry(
            *("model=openai/tiny", f"prompt={prompt}", "world.agents=8", "world.steps=2", "analyze=false"),
            *("model.options.max_tokens=8", f"output.dir={prompt}", "runner.workers=1"),
            cwd=workspace,
            OPENAI_BASE_URL=f"{llama}/v1",
            OPENAI_API_KEY="none",
        )
        assert done.returncode == 0, done.stderr
        summary = SweepFolder.open(workspace / prompt).runs()[0].summary()
        assert summary is not None and summary.counts.cached_tokens is not None
        computed = summary.counts.prompt_tokens - summary.counts.cached_tokens
        assert computed == computed_tokens(llama) - before
        shares[prompt] = computed / summary.counts.prompt_tokens
    assert shares["paper_prefix"] < 0.8 * shares["paper"]
