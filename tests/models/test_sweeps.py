from pathlib import Path

import pytest
import zstandard

from analysis.pipeline import analyze
from commands import SMALL, foundry, statuses, succeeds, sweep_folder
from foundry.errors import InputError
from foundry.models.openai.openai_server import Secret
from foundry.storing.store import SweepFolder
from openai_server import ChatCase, OpenAIServer, refused
from own_backend import Paid

KEY = "sk-tests/4f9d8c7b6a5e"


def everything_below(folder: Path) -> bytes:
    """Return the content of all files below, and their names; what is compressed is decompressed too."""
    contents = []
    for path in sorted(folder.rglob("*")):
        contents.append(str(path).encode())
        if path.is_file():
            contents.append(path.read_bytes())
        if path.suffix == ".zst":
            reader = zstandard.ZstdDecompressor().stream_reader(path.read_bytes(), read_across_frames=True)
            contents.append(reader.read())
    return b"\n".join(contents)


@pytest.fixture
def openai(workspace: Path):
    def start(server: OpenAIServer, *arguments: str):
        surroundings = {"OPENAI_BASE_URL": server.base_url, "OPENAI_API_KEY": KEY}
        return foundry(*arguments, cwd=workspace, **surroundings)

    return start


@pytest.mark.slow
def test_a_sweep_over_models_is_complete_comes_from_the_cache_next_time_and_holds_no_key(openai, workspace: Path):
    sweep = ("-m", "model=openai/a,openai/meta-llama/Llama-3.1-8B", "seed=0-1", "runner.workers=1", *SMALL)
    with OpenAIServer(key=KEY) as server:
        first = openai(server, *sweep)
        assert first.returncode == 0, first.stderr
        asked = len(server.bodies)
        again = openai(server, *sweep, "output.dir=again")
        assert again.returncode == 0, again.stderr
        assert len(server.bodies) == asked == 2 * 2 * 4 * 4 * 2
        assert {headers["authorization"] for headers in server.headers} == {f"Bearer {KEY}"}
    folder = SweepFolder.open(workspace / sweep_folder(first.stdout))
    assert statuses(folder.path) == statuses(workspace / "again") == ["complete"] * 4
    assert {run.factors["model"] for run in folder.runs()} == {"openai/a", "openai/meta-llama/Llama-3.1-8B"}
    assert {call.cached for run in SweepFolder.open(workspace / "again").runs() for call in run.calls()} == {True}
    kept = everything_below(workspace) + (first.stdout + first.stderr + again.stdout).encode()
    assert b"OPENAI_API_KEY" in kept and b"openai/a" in kept
    assert KEY.encode() not in kept and KEY.replace("/", "\\/").encode() not in kept


@pytest.mark.slow
def test_output_that_fits_no_format_is_a_failed_reply_and_fails_no_run(openai, workspace: Path):
    text = "The model produced output that does not match the expected peg-native format"
    with OpenAIServer(lambda body: refused(500, text, type="server_error", code=500)) as server:
        quick = ("model.server.retry.wait_initial_s=0.001", "model.server.retry.wait_max_s=0.001")
        small = ("world.agents=2", "world.steps=2", "analyze=false", "output.dir=out")
        done = openai(server, "model=openai/a", *small, *quick)
    assert done.returncode == 0 and statuses(workspace / "out") == ["complete"], done.stderr
    finished = foundry("status", "out", cwd=workspace).stdout
    assert "100.0% of 8 replies are unreadable (8 aborted by the server). Examples:" in finished
    assert "does not match the expected peg-native format" in finished
    assert any("foundry status shows examples" in note for note in analyze([workspace / "out"], plots=False).notes)


@pytest.mark.slow
def test_a_sweep_goes_on_with_other_flags_of_its_server_and_not_with_other_weights(openai, workspace: Path):
    def served(n_ctx: int, size: int) -> dict[str, object]:
        return {"a": {"meta": {"n_ctx": n_ctx, "n_embd": 64, "size": size}, "max_model_len": n_ctx}}

    sweep = ("-m", "model=openai/a", "runner.workers=1", "output.dir=out", *SMALL)
    with OpenAIServer(models=served(4096, 7)) as server:
        assert openai(server, *sweep, "seed=0").returncode == 0
        (folder,) = SweepFolder.open(workspace / "out").runs()
        (folder.path / "run.json").unlink()
        asked = len(server.bodies)
        server.models = served(8192, 7)
        resumed = openai(server, "resume", "out")
        assert resumed.returncode == 0 and len(server.bodies) == asked, resumed.stderr
        assert openai(server, *sweep, "seed=0-1").returncode == 0
        server.models = served(8192, 8)
        refused = openai(server, *sweep, "seed=0-2")
    assert refused.returncode == 2 and "Model 'openai/a' changed since this sweep began" in refused.stderr
    digests = {call.digest for run in SweepFolder.open(workspace / "out").runs() for call in run.calls()}
    assert len(digests) == 1


def test_a_run_counts_the_tokens_that_the_server_took_from_its_prompt_cache(openai, workspace: Path):
    usage = {"prompt_tokens": 90, "completion_tokens": 3, "prompt_tokens_details": {"cached_tokens": 64}}
    with OpenAIServer(lambda body: ChatCase("I stay.", usage=usage)) as server:
        done = openai(server, "model=openai/a", "analyze=false", *SMALL)
        again = openai(server, "model=openai/a", "analyze=false", "output.dir=again", *SMALL)
    for path in (workspace / sweep_folder(done.stdout), workspace / "again"):
        run = SweepFolder.open(path).runs()[0]
        counts = run.summary().counts
        assert (counts.cached_tokens, counts.prompt_tokens) == (64 * counts.calls, 90 * counts.calls)
        assert {call.cached_tokens for call in run.calls()} == {64}
    assert again.returncode == 0 and counts.cached == counts.calls
    succeeds("verify", str(workspace / "again"), cwd=workspace)


def test_a_server_that_repeats_the_key_in_its_refusal_gets_it_nowhere_and_another_goes_on(openai, workspace: Path):
    with OpenAIServer(lambda body: refused(400, f"Bad request by {KEY}")) as server:
        done = openai(server, "model=openai/a", "output.dir=out", *SMALL)
    assert done.returncode == 3
    kept = everything_below(workspace) + (done.stdout + done.stderr).encode()
    assert b"Bad request by [key]" in kept and KEY.encode() not in kept
    with OpenAIServer() as server:
        done = openai(server, "resume", "out")
        assert done.returncode == 0 and len(server.bodies) == 4 * 4 * 2, done.stderr
    assert statuses(workspace / "out") == ["complete"]


def test_a_wrong_key_ends_the_sweep_before_it_starts_and_is_not_repeated(openai, workspace: Path):
    with OpenAIServer(key="another") as server:
        done = openai(server, "model=openai/a", *SMALL)
    assert done.returncode == 2
    assert "Incorrect API key provided: [key]" in done.stderr and "OPENAI_API_KEY" in done.stderr
    assert KEY not in done.stderr
    assert list(workspace.iterdir()) == []


def test_a_key_in_place_of_its_variables_name_is_refused_and_not_repeated(openai):
    with OpenAIServer() as server:
        done = openai(server, "model=openai/a", f"model.server.api_key_env={KEY}", *SMALL)
    assert done.returncode == 2 and "must be the name of an environment variable" in done.stderr
    assert KEY not in done.stderr + done.stdout
    with pytest.raises(InputError, match="ends with API_KEY"):
        Secret.from_environment("SECRET_TOKEN")


def test_a_secret_shows_itself_nowhere_and_a_placeholder_leaves_replies_alone(monkeypatch):
    monkeypatch.setenv("MY_API_KEY", f"  {KEY}\n")
    secret = Secret.from_environment("MY_API_KEY")
    assert secret.headers == {"authorization": f"Bearer {KEY}"}
    assert KEY not in repr(secret)
    echoed = f'{{"text": "{KEY}", "escaped": "{KEY}"}}'.replace("/", "\\/", 1).encode()
    assert secret.removed_from_reply(echoed) == b'{"text": "[key]", "escaped": "[key]"}'
    monkeypatch.setenv("MY_API_KEY", "EMPTY")
    placeholder = Secret.from_environment("MY_API_KEY")
    assert placeholder.removed_from_reply(b"EMPTY room") == b"EMPTY room"
    assert placeholder.removed(b"the body is EMPTY") == b"the body is EMPTY"
    written_out = "".join(f"\\u{ord(sign):04X}" for sign in KEY).encode()
    assert secret.removed(b'{"error": "' + written_out + b'"}') == b'{"error": "[key]"}'
    assert Secret.from_environment("OTHER_API_KEY").headers == Secret.from_environment(None).headers == {}
    monkeypatch.setenv("MY_API_KEY", "two words")
    with pytest.raises(InputError, match="The value of MY_API_KEY is not a key") as caught:
        Secret.from_environment("MY_API_KEY")
    assert "two" not in str(caught.value)


SIX = ("world.agents=6", "world.steps=2", "analyze=false", "runner.workers=1")
SIX_CALLS = 6 * 2 * 2


@pytest.fixture
def own(workspace: Path, monkeypatch: pytest.MonkeyPatch):
    """Run the command with a backend of this class into a folder of this name."""
    for name, value in (("asked", []), ("most_in_flight", 0), ("digest", None)):
        monkeypatch.setattr(Paid, name, value)
    (workspace / "mine" / "model").mkdir(parents=True)
    for kind in ("Paid", "Slow"):
        file = workspace / "mine" / "model" / f"{kind.lower()}.yaml"
        file.write_text(f"_target_: own_backend.{kind}\nname: {kind.lower()}\n", encoding="utf-8")

    def start(kind: str, output: str):
        arguments = ("--config-dir", "mine", f"model={kind}", f"output.dir={output}", *SIX)
        return foundry(*arguments, cwd=workspace)

    return start


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "at_once"), [("paid", 64), ("slow", 2)])
def test_what_it_answered_is_not_asked_again_and_what_failed_is_tried_again(own, workspace, kind: str, at_once: int):
    first = own(kind, "one")
    assert first.returncode == 0, first.stdout + first.stderr
    assert len(Paid.asked) == SIX_CALLS + 1 and 1 < Paid.most_in_flight <= at_once
    (run,) = SweepFolder.open(workspace / "one").runs()
    assert [attempt.error for call in run.calls() for attempt in call.attempts] == ["Not yet."]
    assert own(kind, "two").returncode == 0
    assert len(Paid.asked) == SIX_CALLS + 1 and statuses(workspace / "two") == ["complete"]


def test_one_that_says_by_an_old_name_that_it_costs_something_is_refused_before_it_is_asked(
    own, workspace, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(Paid, "remote", True, raising=False)
    done = own("paid", "one")
    assert done.returncode == 2 and "has an attribute `remote`, which is called `costs` now" in done.stderr
    assert done.stderr.count("\n") == 1 and Paid.asked == [] and not (workspace / "one").exists()


def test_weights_that_it_says_have_changed_stop_the_sweep(own, workspace, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(Paid, "digest", "first")
    ask = Paid.ask

    async def replaced(self, request):
        Paid.digest = "second" if len(Paid.asked) > SIX_CALLS // 2 else Paid.digest
        return await ask(self, request)

    monkeypatch.setattr(Paid, "ask", replaced)
    done = own("paid", "one")
    assert done.returncode == 3 and "digest first at the start, second now" in done.stderr
    assert statuses(workspace / "one") == ["failed"]
