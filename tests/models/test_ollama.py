from __future__ import annotations

import asyncio

import msgspec
import pytest

from foundry.composing.compose import compose
from foundry.errors import InputError, TransientError
from foundry.models.ollama.ollama_wire import load_body
from foundry.running.build import build
from ollama_server import OllamaServer


def test_a_refused_connection_is_worth_another_try(make_model, make_request, run):
    with OllamaServer() as server:
        url = server.url
    with pytest.raises(TransientError, match=r"Start Ollama \(ollama serve"):
        run(make_model(url), lambda model: model.ask(make_request()))


def test_something_that_does_not_speak_http_is_worth_another_try(make_model, make_request):
    calls: list[asyncio.Task[None] | None] = []

    async def babble(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        calls.append(asyncio.current_task())
        await reader.readline()
        writer.write(b"SSH-2.0-OpenSSH\r\n")
        writer.close()
        await writer.wait_closed()

    async def ask_it() -> None:
        async with await asyncio.start_server(babble, "127.0.0.1", 0) as server:
            model = make_model(f"127.0.0.1:{server.sockets[0].getsockname()[1]}")
            try:
                await model.ask(make_request())
            finally:
                await model.close()
                await asyncio.gather(*filter(None, calls))

    with pytest.raises(TransientError):
        asyncio.run(ask_it())


def test_calls_go_to_the_least_loaded_host(make_model, make_request, run):
    with OllamaServer() as first, OllamaServer() as second:
        model = make_model([first.url, second.url])
        run(model, lambda m: m.ask_all([make_request(seed=n) for n in range(7)]))
        assert (first.counts.chats, second.counts.chats) == (4, 3)


def test_a_model_can_be_used_in_one_event_loop_after_another(make_model, make_request, run):
    with OllamaServer() as server:
        model = make_model(server.url)
        assert run(model, lambda m: m.ask(make_request())) is not None
        assert run(model, lambda m: m.ask(make_request())) is not None


def test_proxies_and_keys_in_the_environment_are_ignored(make_model, make_request, run, monkeypatch):
    for name in ("HTTP_PROXY", "http_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.setenv("OLLAMA_API_KEY", "secret")
    with OllamaServer() as server:
        assert run(make_model(server.url), lambda m: m.ask(make_request())).text
        assert run(make_model(server.url), lambda m: m.inspect()).digest
        assert not any("authorization" in headers for headers in server.headers)


def test_a_warm_up_outlasts_the_read_time_out_and_loads_with_the_calls_own_options(make_model, make_request, run):
    async def warm_up_and_ask(model):
        warming = asyncio.create_task(model.warm_up())
        await asyncio.sleep(0)  # so that it is the first to be sent
        with pytest.raises(TransientError, match=r"no reply within 0\.1 s"):
            await model.ask(make_request())
        server.free()
        await warming
        model.server = msgspec.structs.replace(model.server, read_timeout_s=600.0)
        return await model.ask(make_request())

    with OllamaServer(holds_loads=True) as server:
        model = make_model(server.url, server={"read_timeout_s": 0.1})
        reply = run(model, warm_up_and_ask)
        assert reply.server_version == "0.32.15"
        assert server.counts.loads == 1
        assert server.loads == [load_body(model.settings, "30m")]
        assert {**server.loads[0]["options"], "seed": 7} == server.bodies[0]["options"]


def test_a_load_whose_caller_gives_up_starts_again(make_model, make_request, run):
    with OllamaServer(holds_loads=True) as server:
        with pytest.raises(TransientError, match="no reply within"):
            run(make_model(server.url, server={"read_timeout_s": 0.05}), lambda m: m.ask(make_request()))
        assert server.loaded == ()


def test_unloading_frees_the_model_on_every_host(make_model, run):
    async def load_and_unload(model):
        await model.warm_up()
        await model.unload()

    with OllamaServer() as first, OllamaServer() as second:
        run(make_model([first.url, second.url]), load_and_unload)
        assert (first.loaded, second.loaded) == ((), ())
        assert second.loads[-1]["keep_alive"] == 0
        assert second.counts.unloads == 1


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"name": "gpt-oss:120b-cloud"}, "calls go to Ollama's cloud"),
        ({"name": "glm-5:cloud"}, "model.server.remote=true"),
        ({"name": " "}, "foundry doctor"),
        ({"think": "hard"}, "model.think 'hard' not found"),
        ({"format": "json"}, "model.format 'json' not found"),
        ({"format": "schema", "schemas": None}, "needs a JSON Schema"),
        ({"options": {"temprature": 1}}, "Did you mean 'temperature'"),
        ({"options": {"seed": 1}}, "set per call"),
        ({"options": {"num_ctx": None}}, "num_ctx must be a number of tokens"),
        ({"server": {"read_timeout_s": 0}}, r"model.server: Expected `float` > 0"),
        ({"server": {"read_timout_s": 5}}, "unknown field `read_timout_s`"),
        ({"server": {"in_flight": {"min": 4, "max": 2, "initial": 4}}}, "min <= initial <= max"),
    ],
)
def test_bad_settings_are_refused_in_one_line(make_model, changes, says):
    with pytest.raises(InputError, match=says):
        make_model("gpu1", **changes)


def test_the_shipped_settings_take_the_hosts_from_the_environment(monkeypatch):
    monkeypatch.setenv("OLLAMA_HOST", "0.0.0.0")
    composed = compose([])
    assert composed is not None
    model = build(composed.conditions[0].config["model"])
    assert (model.hosts, model.settings.num_ctx, model.kinds) == (("http://127.0.0.1:11434",), 10240, None)
