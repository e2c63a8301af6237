from __future__ import annotations

import asyncio
import io
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from commands import statuses, succeeds
from foundry.errors import InputError, RequestError, ServerError
from foundry.models.base import ChatMessage, Request
from foundry.models.local import weights as transformers_weights
from foundry.models.local.local_model import TransformersModel
from foundry.storing.store import SweepFolder
from models.asking import make_request, run

os.environ.setdefault("OMP_NUM_THREADS", "1")  # several threads only wait for each other over models so small
pytestmark = [
    pytest.mark.local_models,
    pytest.mark.skipif(
        find_spec("torch") is None or find_spec("transformers") is None, reason="needs foundry-worlds[hf]"
    ),
]

OPTIONS = {"temperature": 0.9, "top_k": 0, "top_p": 0.95, "min_p": 0.0, "max_new_tokens": 8}
SERVER = {
    "device": "cpu",
    "batch_size": 8,
    "workers": 1,
    "in_flight": {"min": 32, "max": 32, "initial": 32},
    "retry": {"attempts": 1, "unusable_attempts": 1, "wait_initial_s": 1, "wait_max_s": 1},
}
PROMPTS = ("Where do you go?", "Up.", "A long way to the left of the fire, and back again, past the door.", "")
MakeLocal = Callable[..., TransformersModel]


@pytest.fixture(scope="session")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from tiny_models import make_text_model

    return make_text_model(tmp_path_factory.mktemp("models") / "reader")


@pytest.fixture(scope="session")
def seer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from tiny_models import make_vision_model

    return make_vision_model(tmp_path_factory.mktemp("models") / "seer")


@pytest.fixture(autouse=True)
def own_caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FOUNDRY_WEIGHTS_CACHE", str(tmp_path / "hashes" / "weights.json"))


@pytest.fixture
def make_local() -> MakeLocal:
    def make(weights: Path | str, **changes: Any) -> TransformersModel:
        return TransformersModel(
            weights=str(weights),
            name="hf/tiny",
            dtype=changes.pop("dtype", "float32"),
            options={**OPTIONS, **changes.pop("options", {})},
            server={**SERVER, **changes.pop("server", {})},
            **changes,
        )

    return make


def png(colour: str) -> bytes:
    buffer = io.BytesIO()
    Image.new("RGB", (24, 20), colour).save(buffer, "png")
    return buffer.getvalue()


@pytest.mark.parametrize(("dtype", "size"), [("float32", 3), ("float64", 8)])
def test_a_reply_is_the_same_alone_and_in_any_batch(dtype, size, reader, make_local):
    requests = [make_request(prompt, seed=seed) for seed in (1, 2) for prompt in PROMPTS]

    alone = run(make_local(reader, dtype=dtype, server={"batch_size": 1}), lambda m: m.ask_all(requests))
    together = run(make_local(reader, dtype=dtype, server={"batch_size": size}), lambda m: m.ask_all(requests))
    assert [reply.text for reply in together] == [reply.text for reply in alone]
    assert [reply.prompt_tokens for reply in together] == [reply.prompt_tokens for reply in alone]
    assert len({reply.text for reply in alone}) == len(requests)


def test_the_seed_decides_and_without_temperature_it_does_not(reader, make_local):
    requests = [make_request(seed=seed) for seed in (5, 5, 6)]
    drawn = [reply.text for reply in run(make_local(reader), lambda m: m.ask_all(requests))]
    assert drawn[0] == drawn[1] != drawn[2]
    greedy = make_local(reader, options={"temperature": 0})
    narrow = make_local(reader, options={"top_k": 1})
    texts = [reply.text for model in (greedy, narrow) for reply in run(model, lambda m: m.ask_all(requests))]
    assert len(set(texts)) == 1


def test_no_reply_is_made_with_the_attention_kernel_that_does_not_repeat_itself(reader, make_local, monkeypatch):
    import torch

    from foundry.models.local.engine import SeededRows

    choose, enabled = SeededRows.__call__, []

    def choosing(self, *arguments):
        enabled.append(torch.backends.cuda.cudnn_sdp_enabled())
        return choose(self, *arguments)

    monkeypatch.setattr(SeededRows, "__call__", choosing)
    run(make_local(reader), lambda m: m.ask(make_request()))
    assert enabled and not any(enabled) and torch.backends.cuda.cudnn_sdp_enabled()


def test_the_template_gets_its_settings_and_they_are_part_of_the_answers_key(reader, make_local):
    plain, thinking = make_local(reader), make_local(reader, template={"enable_thinking": True})
    tokens = [run(model, lambda m: m.ask(make_request())).prompt_tokens for model in (plain, thinking)]
    assert tokens[1] == tokens[0] + len("hm")
    assert plain.parameters() != thinking.parameters()


def test_a_reply_ends_by_itself_or_at_its_length_and_its_tokens_are_counted(reader, make_local):
    model = make_local(reader, options={"max_new_tokens": 60, "temperature": 3.0})
    replies = run(model, lambda m: m.ask_all([make_request("abc", seed=seed) for seed in range(6)]))
    stopped = [reply for reply in replies if reply.ending == "stop"]
    assert stopped and all(reply.output_tokens <= 60 and "<|end|>" not in reply.text for reply in stopped)
    for reply in replies:
        assert reply.prompt_tokens == len("abc") + 3 and reply.timings["total"] >= reply.timings["output"] > 0
        assert "torch" in str(reply.server_version)
    (cut,) = run(make_local(reader, options={"max_new_tokens": 3}), lambda m: m.ask_all([make_request()]))
    assert (cut.output_tokens, cut.ending) == (3, "length")


def test_images_of_each_call_are_its_own_and_one_that_cannot_be_read_is_refused(seer, make_local):
    def look(text: str, *colours: str) -> Request:
        messages = (ChatMessage("system", "You see."), ChatMessage("user", text, tuple(map(png, colours))))
        return Request(messages=messages, seed=3, kind="command", observation={}, step=1, agent=0)

    requests = [look("What?", "red"), look("What?", "blue"), look("Where is the door?", "red"), look("What?", "red")]
    requests += [look("What?"), look("What?", "red", "red")]

    async def alone_and_together(model):
        alone = [await model.ask(request) for request in requests]
        return alone, await model.ask_all(requests)

    model = make_local(seer, options={"temperature": 0})
    alone, together = run(model, alone_and_together)
    texts = [reply.text for reply in alone]
    assert [reply.text for reply in together] == texts and texts[0] == texts[3] and len(set(texts)) == 5
    patches, tokens = (16 // 8) ** 2, [reply.prompt_tokens for reply in together]
    assert [tokens[0] - tokens[4], tokens[5] - tokens[4]] == [patches, 2 * patches]
    with pytest.raises(RequestError, match="cannot be given to the model"):
        run(model, lambda m: m.ask(make_request("x", images=(b"no picture",))))


def test_a_prompt_that_does_not_fit_is_refused_and_takes_no_other_with_it(reader, make_local):
    async def ask(model, *requests):
        results = await asyncio.gather(*map(model.ask, requests), return_exceptions=True)
        await model.close()
        return results

    long, short = make_request("x" * 9000), make_request("x")
    tool = Request((ChatMessage("tool", "?"),), seed=1, kind="action", observation={}, step=1, agent=0)
    blind = make_request("x", images=(png("red"),))
    results = asyncio.run(ask(make_local(reader), long, short, tool, blind))
    assert [type(result).__name__ for result in results] == ["RequestError", "Reply", "RequestError", "RequestError"]
    assert "do not fit the context of 8192" in str(results[0])
    assert "No tools here" in str(results[2])
    assert "has no vision" in str(results[3])


def test_a_caller_that_gives_up_leaves_the_others_their_answers_and_the_event_loop_lives(reader, make_local):
    async def cancel_two(model):
        calls = [asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(6)]
        await asyncio.sleep(0)
        for call in (calls[0], calls[5]):
            call.cancel()
        turns = 0
        while not all(call.done() for call in calls):
            await asyncio.sleep(0)
            turns += 1
        assert turns > 100
        return await asyncio.gather(*calls, return_exceptions=True)

    model = make_local(reader, server={"batch_size": 2})
    for _ in range(2):  # a closed model can be used again, in another loop
        results = run(model, cancel_two)
        assert [isinstance(result, asyncio.CancelledError) for result in results] == [True, *[False] * 4, True]
        assert len({result.text for result in results[1:5]}) == 4


def test_the_digest_follows_the_content_and_each_file_is_read_once(reader, tmp_path: Path):
    copy = tmp_path / "elsewhere"
    shutil.copytree(reader, copy)
    (copy / "README.md").write_text("Not part of the model.")
    assert transformers_weights.digest(copy) == transformers_weights.digest(reader)
    content = json.loads((tmp_path / "hashes" / "weights.json").read_text("utf-8"))
    assert len(content) == 2 * len([file for file in reader.iterdir()])
    template = copy / "chat_template.jinja"
    template.write_text(template.read_text("utf-8") + " ", "utf-8")
    assert transformers_weights.digest(copy) != transformers_weights.digest(reader)
    (tmp_path / "hashes" / "weights.json").write_text("broken")
    assert transformers_weights.digest(reader) == transformers_weights.digest(reader)


def test_what_is_known_of_a_model_comes_from_its_files_which_must_hold_a_chat_template(
    reader, seer, tmp_path: Path, make_local
):
    infos = [run(make_local(folder), lambda m: m.inspect()) for folder in (reader, seer)]
    assert [info.capabilities for info in infos] == [("completion",), ("completion", "vision")]
    assert [info.context_length for info in infos] == [8192, 8192]
    assert infos[0].digest != infos[1].digest
    shutil.copytree(reader, tmp_path / "base")
    (tmp_path / "base" / "chat_template.jinja").unlink()
    with pytest.raises(InputError, match="no chat template"):
        run(make_local(tmp_path / "base"), lambda m: m.inspect())


def test_weights_that_are_damaged_end_the_sweep(reader, tmp_path: Path, make_local):
    copy = tmp_path / "damaged"
    shutil.copytree(reader, copy)
    (copy / "model.safetensors").write_bytes(b"not weights")
    with pytest.raises(ServerError, match="cannot be loaded on cpu"):
        run(make_local(copy), lambda m: m.warm_up())


@pytest.mark.parametrize(
    ("weights", "says"),
    [
        ("nowhere/at-all", "Get it with: hf download nowhere/at-all"),
        ("/no/such/folder", "is not a folder"),
        ("empty", "is not a model"),
    ],
)
def test_weights_that_are_not_there_get_one_line(weights, says, workspace: Path, make_local):
    (workspace / "empty").mkdir()
    with pytest.raises(InputError, match=says):
        run(make_local(weights), lambda m: m.inspect())


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"dtype": "float31"}, "Did you mean 'float32'"),
        ({"options": {"top_p": 0}}, "model.options: Expected"),
        ({"options": {"typical_p": 1}}, "Options are: temperature, top_k"),
        ({"server": {"batch_size": 0}}, "model.server: Expected"),
    ],
)
def test_bad_settings_are_refused_in_one_line(changes, says, make_local):
    with pytest.raises(InputError, match=says):
        make_local("x", **changes)


def test_a_device_that_is_not_there_is_refused(reader, make_local):
    with pytest.raises(InputError, match="model.server.device=cuda:7 cannot be used"):
        run(make_local(reader, server={"device": "cuda:7"}), lambda m: m.inspect())


def test_a_sweep_is_answered_in_one_process_and_comes_from_the_cache_next_time(reader, workspace: Path, monkeypatch):
    loaded, load = [], TransformersModel._load
    monkeypatch.setattr(TransformersModel, "_load", lambda model: loaded.append(model) or load(model))
    sweep = (
        *("-m", f"model=hf/{reader}", "model.options.max_new_tokens=4", "seed=0-1", "model.name=tiny"),
        *("world.agents=3", "world.steps=2", "analyze=false", "runner.workers=2"),
    )
    succeeds(*sweep, "output.dir=out", cwd=workspace)
    assert loaded, "the weights were loaded in another process"
    succeeds(*sweep, "output.dir=again", cwd=workspace)
    assert statuses(workspace / "out") == ["complete"] * 2
    calls = [call for run in SweepFolder.open(workspace / "again").runs() for call in run.calls()]
    assert calls and all(call.cached for call in calls)


def test_without_the_library_one_line_says_how_to_install_it(workspace: Path):
    code = "import sys; sys.modules['torch'] = None; from foundry.cli import run; sys.exit(run(['model=hf/x']))"
    done = subprocess.run([sys.executable, "-c", code], cwd=workspace, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "pip install 'foundry-worlds[hf]'" in done.stderr and done.stderr.count("\n") == 1
