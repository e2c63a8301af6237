"""Servers that tell no digest: a sweep knows their weights by a few calls, and finds others behind the same name."""

import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import msgspec
import pytest

from analysis import analyze
from analysis.report.material import Material
from analysis.report.provenance import canary_grid
from commands import foundry, statuses, succeeds
from foundry.canary import PROMPTS, Canary, Verdict
from foundry.models.wrappers.confirmed import CONFIRM_EVERY_CALLS
from foundry.storing.store import SweepFolder
from ollama_cases import grid_answer
from ollama_server import OllamaServer
from openai_server import OpenAIServer
from replaced import MODEL
from weighted import Weighted

ALL = len(PROMPTS)
SETTINGS = ("world.agents=2", "world.steps=3", "analyze=false", "runner.workers=1", "runner.open_runs=1")
ONE_BY_ONE = "model.server.in_flight={min: 1, max: 1, initial: 1}"
SWEEP = ("-m", "model=openai/a", ONE_BY_ONE, *SETTINGS)
CALLS = 2 * 3 * 2


def swept(workspace: Path, server: OpenAIServer, *arguments: str) -> subprocess.CompletedProcess[str]:
    return foundry(*arguments, cwd=workspace, OPENAI_BASE_URL=server.base_url, FOUNDRY_CANARY="true")


def canaries(folder: Path) -> list[Canary]:
    summaries = [run.summary() for run in SweepFolder.open(folder).runs()]
    return [canary for summary in summaries if summary is not None for canary in summary.canaries]


def digest(folder: Path) -> str:
    return str(SweepFolder.open(folder).models[0]["digest"])


def test_a_sweep_asks_its_canary_at_its_start_and_end_and_a_rerun_from_the_cache_asks_nothing(tmp_path: Path):
    weights = Weighted()
    with OpenAIServer(weights) as server:
        assert swept(tmp_path, server, *SWEEP, "seed=0-1", "output.dir=first").returncode == 0
        assert len(weights.asked) == 2 * CALLS
        assert ALL < len(weights.canaries) <= ALL + 2 + 1  # the end of each run, and a call drawn at random
        assert all((body["temperature"], body["max_tokens"]) == (0, 16) for body in weights.canaries)
        asked = len(server.bodies)
        assert swept(tmp_path, server, *SWEEP, "seed=0-1", "output.dir=again").returncode == 0
        assert len(server.bodies) == asked
    begun, ended = canaries(tmp_path / "first")
    assert begun.signs == ended.signs and begun.verdict is ended.verdict is Verdict.SAME
    assert ended.calls == len(weights.canaries)
    from_cache = canaries(tmp_path / "again")
    assert [(canary.signs, canary.calls, canary.verdict) for canary in from_cache] == [(begun.signs, 0, None)] * 2
    succeeds("verify", "first", "--workers=1", cwd=tmp_path)


def test_other_weights_behind_the_same_name_stop_a_sweep_and_the_next_one_has_answers_of_its_own(tmp_path: Path):
    weights = Weighted()
    with OpenAIServer(weights) as server:
        swept(tmp_path, server, *SWEEP, "seed=0", "output.dir=first")
        weights.weights = "second"
        stopped = swept(tmp_path, server, *SWEEP, "seed=0-1", "output.dir=stopped")
        assert stopped.returncode == 3 and "canary belongs to other weights" in stopped.stderr
        resumed = swept(tmp_path, server, "resume", "first", "seed=1")
        assert resumed.returncode == 3 and "canary belongs to other weights" in resumed.stderr
        weights.asked.clear()
        assert swept(tmp_path, server, *SWEEP, "seed=0-1", "output.dir=second").returncode == 0
        assert weights.asked == ["second"] * 2 * CALLS
        weights.weights = "first"
        weights.asked.clear()
        assert swept(tmp_path, server, *SWEEP, "seed=0", "output.dir=back").returncode == 0
        assert not weights.asked
    assert digest(tmp_path / "back") == digest(tmp_path / "first")
    assert digest(tmp_path / "second").startswith(f"{digest(tmp_path / 'first')}~")
    assert statuses(tmp_path / "stopped").count("complete") == 1  # from the cache alone


@pytest.mark.slow
def test_another_cache_learns_from_a_sweep_which_weights_it_began_with(tmp_path: Path):
    weights = Weighted()
    with OpenAIServer(weights) as server:
        swept(tmp_path, server, *SWEEP, "seed=0", "output.dir=sweep")
        (tmp_path / "outputs" / "answers.sqlite").unlink()
        weights.weights = "second"
        grown = swept(tmp_path, server, "resume", "sweep", "seed=1")
    assert grown.returncode == 3 and "canary belongs to other weights" in grown.stderr


@pytest.mark.slow
def test_weights_that_come_and_go_between_two_confirmations_are_found_at_random(tmp_path: Path):
    """Behind a gateway, whose connections stay open; a hundred calls of other weights meet one canary at least."""
    weights = Weighted()

    def swap(number: int) -> None:
        weights.weights = "second" if CONFIRM_EVERY_CALLS < number <= 2 * CONFIRM_EVERY_CALLS else "first"

    weights.then = swap
    with OpenAIServer(weights) as server:
        stopped = swept(tmp_path, server, *SWEEP, "seed=0", "world.steps=80", "output.dir=sweep")
    assert stopped.returncode == 3 and "canary belongs to other weights" in stopped.stderr
    assert CONFIRM_EVERY_CALLS < len(weights.asked) <= 2 * CONFIRM_EVERY_CALLS


@pytest.mark.parametrize("tells", [False, None])
def test_a_server_that_tells_no_log_probabilities_is_judged_by_its_texts(tells: bool | None, tmp_path: Path):
    weights = Weighted(tells=tells)
    with OpenAIServer(weights) as server:
        swept(tmp_path, server, *SWEEP, "seed=0", "output.dir=first")
        (known,) = canaries(tmp_path / "first")
        assert known.verdict is Verdict.SAME and not any(sign.tokens for sign in known.signs)
        weights.weights = "second"
        stopped = swept(tmp_path, server, *SWEEP, "seed=1", "output.dir=stopped")
    assert stopped.returncode == 3 and "0% of the texts" in stopped.stderr


@pytest.mark.slow
def test_flags_that_move_log_probabilities_are_undecided_and_said_once(tmp_path: Path, caplog):
    weights = Weighted()
    with OpenAIServer(weights) as server:
        swept(tmp_path, server, *SWEEP, "seed=0", "output.dir=sweep")
        weights.noise = 0.2
        grown = swept(tmp_path, server, "resume", "sweep", "seed=1")
    assert grown.returncode == 0, grown.stderr
    assert caplog.text.count("differ slightly from those") == 1
    assert [canary.verdict for canary in canaries(tmp_path / "sweep")] == [Verdict.SAME, Verdict.UNDECIDED]
    (note,) = [note for note in analyze(tmp_path / "sweep", plots=False).notes if "canary" in note]
    version = "other weights, or another version of its server,"
    assert note.startswith(f"openai/a: {version} may have answered 1 of 2 runs (canary undecided: ")


def test_of_two_servers_one_with_other_weights_is_found_at_the_start(tmp_path: Path):
    with OpenAIServer(Weighted()) as one, OpenAIServer(Weighted("second")) as other:
        both = f"model.server.base_url=[{one.base_url},{other.base_url}]"
        stopped = swept(tmp_path, one, *SWEEP, both, "seed=0", "output.dir=sweep")
    assert stopped.returncode == 3 and "canary belongs to other weights" in stopped.stderr


def test_runs_that_other_weights_answered_are_found_when_they_are_verified_and_reported(tmp_path: Path):
    """Two machines, each with a cache of its own, whose runs were put into one folder."""
    with OpenAIServer(Weighted()) as server:
        swept(tmp_path, server, *SWEEP, "seed=0-1", "output.dir=sweep")
    with OpenAIServer(Weighted("second")) as server:
        swept(tmp_path, server, *SWEEP, "seed=0", "output.dir=other", "cache=other.sqlite")
    mine, foreign = (SweepFolder.open(tmp_path / name).runs()[-1].path / "run.json" for name in ("sweep", "other"))
    summary = msgspec.json.decode(mine.read_bytes())
    summary["canaries"] = msgspec.json.decode(foreign.read_bytes())["canaries"]
    mine.write_bytes(msgspec.json.encode(summary))
    verified = foundry("verify", "sweep", "--workers=1", cwd=tmp_path)
    assert verified.returncode == 3 and "'openai/a' answered with other weights than in" in verified.stdout
    runs = SweepFolder.open(tmp_path / "sweep").runs()
    members = [SimpleNamespace(folder=run, summary=run.summary()) for run in runs]
    table = canary_grid(cast(Material, SimpleNamespace(members=members)))
    assert [row[4].text.partition(":")[0] for row in table.rows] == ["same", "other"]


def test_ollamas_digest_decides_and_its_canary_is_kept_beside_it(tmp_path: Path, caplog):
    with OllamaServer(grid_answer) as server:
        arguments = ("-m", f"model={MODEL}", ONE_BY_ONE, *SETTINGS, "seed=0", "output.dir=sweep")
        succeeds(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url, FOUNDRY_CANARY="true")
        asked = [body for body in server.bodies if body["messages"][0]["content"] in PROMPTS]
        assert {body["options"]["num_ctx"] for body in asked} == {10240}  # any other would load the model again
        server.answer = lambda body: "otherwise" if body["messages"][0]["content"] in PROMPTS else grid_answer(body)
        grown = foundry("resume", "sweep", "seed=1", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert grown.returncode == 0 and caplog.text.count("canary other") == 1
    assert [canary.verdict for canary in canaries(tmp_path / "sweep")] == [Verdict.SAME, Verdict.OTHER]
    verified = foundry("verify", "sweep", "--workers=1", cwd=tmp_path)
    assert verified.returncode == 3 and "changed its weights during the run" in verified.stdout
