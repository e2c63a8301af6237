"""A real server of llama.cpp, with tiny models of random weights: `python tasks.py servers`."""

import contextlib
import os
import re
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pandas as pd
import pytest

from analysis.pipeline import analyze
from analysis.probes import analyze_probe
from commands import answers, foundry, wait_until
from foundry import paths
from foundry.canary import Verdict
from foundry.storing.store import SweepFolder

PYTHON = os.environ.get("FOUNDRY_LLAMA_PYTHON", sys.executable)
"""A Python with xllamacpp, which is llama.cpp's server, and with what makes models."""
ROOT = paths.PACKAGE.parent
SMALL = ("model=openai/tiny", "world.agents=2", "world.steps=2", "analyze=false", "runner.workers=1")
Serve = Callable[..., AbstractContextManager[str]]

pytestmark = pytest.mark.real_server


@pytest.fixture
def serve(tmp_path: Path) -> Serve:
    """Serve weights by their seed, always at one address, with these flags; yields the base URL.

    With `words` a reply is one of them.
    """
    if subprocess.run([PYTHON, "-c", "import gguf, tokenizers, xllamacpp"], stderr=subprocess.DEVNULL).returncode:
        pytest.skip("needs xllamacpp, gguf and tokenizers: python tasks.py servers")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    url = f"http://127.0.0.1:{port}"

    @contextlib.contextmanager
    def serving(seed: int = 0, *flags: str, words: str = "") -> Iterator[str]:
        model = tmp_path / f"{seed}{words}.gguf"
        if not model.exists():
            maker = ROOT / "benchmarks" / "tiny_gguf.py"
            subprocess.run([PYTHON, str(maker), str(model), "--seed", str(seed), "--words", words], check=True)
        program = [PYTHON, str(ROOT / "tests" / "servers" / "llama_server.py"), str(model), port, *flags]
        with subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                wait_until(lambda: answers(f"{url}/health"), "the server is ready")
                yield url
            finally:
                process.kill()

    return serving


def swept(workspace: Path, url: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    settings = {"OPENAI_BASE_URL": f"{url}/v1", "OPENAI_API_KEY": "none", "FOUNDRY_CANARY": "true"}
    return foundry(*arguments, cwd=workspace, **settings)


def computed_tokens(url: str) -> int:
    with urllib.request.urlopen(f"{url}/metrics") as answer:
        found = re.search(r"^llamacpp:prompt_tokens_total (\d+)", answer.read().decode(), re.MULTILINE)
    assert found
    return int(found[1])


def test_what_is_recorded_as_cached_is_what_the_server_did_not_work_out(serve: Serve, workspace: Path):
    shares = {}
    with serve() as url:
        for prompt in ("paper", "paper_prefix"):
            before = computed_tokens(url)
            settings = ("world.agents=8", "model.options.max_tokens=8", "model.server.canary=false")
            done = swept(workspace, url, *SMALL, *settings, f"prompt={prompt}", f"output.dir={prompt}")
            assert done.returncode == 0, done.stderr
            summary = SweepFolder.open(workspace / prompt).runs()[0].summary()
            assert summary.counts.cached_tokens is not None
            computed = summary.counts.prompt_tokens - summary.counts.cached_tokens
            assert computed == computed_tokens(url) - before
            shares[prompt] = computed / summary.counts.prompt_tokens
    assert shares["paper_prefix"] < 0.8 * shares["paper"]


def test_other_flags_are_the_same_weights_and_other_weights_behind_the_name_are_found(serve: Serve, workspace: Path):
    sweep = (*SMALL, "model.options.max_tokens=30", "output.dir=sweep")
    with serve() as url:
        assert swept(workspace, url, *sweep, "seed=0").returncode == 0
    with serve(0, "--slots", "1", "--context", "8192") as url:
        assert swept(workspace, url, "resume", "sweep", "seed=1").returncode == 0
    with serve(1) as url:
        stopped = swept(workspace, url, "resume", "sweep", "seed=2")
    assert stopped.returncode == 3 and "canary belongs to other weights" in stopped.stderr
    summaries = [run.summary() for run in SweepFolder.open(workspace / "sweep").runs()]
    verdicts = [canary.verdict for summary in summaries if summary is not None for canary in summary.canaries]
    assert verdicts[:2] == [Verdict.SAME] * 2


def test_log_probabilities_are_kept_with_each_call(serve: Serve, workspace: Path):
    with serve() as url:
        done = swept(workspace, url, *SMALL, "model.logprobs=3", "model.options.max_tokens=20", "output.dir=sweep")
        assert done.returncode == 0, done.stderr
    (run,) = SweepFolder.open(workspace / "sweep").runs()
    assert all(len(place.top) <= 3 for call in run.calls() for place in call.logprobs or ())
    assert any(call.logprobs for call in run.calls())
    analyze(workspace / "sweep", plots=False)
    assert "probability" in pd.read_parquet(workspace / "sweep" / "analysis" / "steps.parquet")


def test_a_probe_asks_once_by_probabilities_that_samples_agree_with(serve: Serve, workspace: Path):
    bar = ("world=bar", "world.agents=2", "world.steps=3", "seed=0,1", "analyze=false")
    openly = ("model.options.temperature=1", "model.options.top_p=1", "+model.extra={top_k: 0, min_p: 0}")
    asked = ("probe", "pilot", "model=openai/tiny", "window=0", "repeats=40", *openly, "analyze=false")
    tables = []
    with serve(2, words="go,stay") as url:
        assert swept(workspace, url, "-m", "model=scripted/random", *bar, "output.dir=pilot").returncode == 0
        for name, logprobs in (("told", "5"), ("sampled", "null")):
            done = swept(workspace, url, *asked, f"model.logprobs={logprobs}", f"output.dir={name}")
            assert done.returncode == 0, done.stderr
            analyze_probe(SweepFolder.open(workspace / name), plots=False)
            tables.append(pd.read_csv(workspace / name / "analysis" / "moments.csv"))
    frame, sampled = tables
    assert set(frame["by"]) == {"probabilities"} and (frame["count"].sum(), sampled["count"].sum()) == (12, 480)
    share = frame[frame["choice"] == "go"]["share"]
    went = sampled[sampled["choice"] == "go"]["count"].sum()
    assert abs(went - 40 * share.sum()) < 4 * (40 * (share * (1 - share)).sum()) ** 0.5 + 480 * 0.05
