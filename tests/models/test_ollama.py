import asyncio
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime

import msgspec
import pytest

import ollama_cases as cases
from foundry.composing.compose import compose
from foundry.errors import InputError, RequestError, ServerError, TransientError
from foundry.models.base import UnusableReply
from foundry.models.http.pausing import seconds_to_wait
from foundry.models.ollama.info import list_models
from foundry.models.ollama.ollama_server import full_tag
from foundry.models.ollama.ollama_wire import load_body
from foundry.running.build import build
from models.asking import ask, make_model, make_request, run
from ollama_cases import FakeModel
from ollama_server import OllamaServer


def test_proxies_and_keys_in_the_environment_are_ignored(monkeypatch):
    for name in ("HTTP_PROXY", "http_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.setenv("OLLAMA_API_KEY", "secret")
    with OllamaServer() as server:
        model = make_model(server.url)  # used in one event loop after another
        assert run(model, lambda m: m.ask(make_request())).text
        assert run(model, lambda m: m.inspect()).digest
        assert run(model, lambda m: m.ask(make_request())).text
        assert not any("authorization" in headers for headers in server.headers)


def test_a_warm_up_outlasts_the_read_time_out_and_loads_with_the_calls_own_options():
    async def warm_up_and_ask(model):
        warming = asyncio.create_task(model.warm_up())
        await asyncio.sleep(0)  # so that it is the first to be sent
        with pytest.raises(TransientError, match=r"no complete reply within 0\.1 s"):
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


def test_unloading_frees_the_model_on_every_host():
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
        ({"options": {"seed": 1}}, "set for each call"),
        ({"options": {"num_ctx": None}}, "num_ctx must be a number of tokens"),
        ({"server": {"read_timeout_s": 0}}, r"model.server: Expected `float` > 0"),
        ({"server": {"read_timout_s": 5}}, "unknown field `read_timout_s`"),
        ({"server": {"in_flight": {"min": 4, "max": 2, "initial": 4}}}, "min <= initial <= max"),
    ],
)
def test_bad_settings_are_refused_in_one_line(changes, says):
    with pytest.raises(InputError, match=says):
        make_model("gpu1", **changes)


def test_the_shipped_settings_take_the_hosts_from_the_environment(monkeypatch):
    monkeypatch.setenv("OLLAMA_HOST", "0.0.0.0")
    composed = compose([])
    model = build(composed.conditions[0].config["model"])
    assert (model.hosts, model.settings.num_ctx, model.kinds) == (("http://127.0.0.1:11434",), 10240, None)


OTHER_FORMAT = "The model produced output that does not match the expected peg-native format"


@pytest.mark.parametrize(
    ("case", "kind", "says"),
    [
        (cases.refused(400, "invalid think value"), RequestError, "invalid think value. It would be refused again"),
        (cases.refused(413, "too large"), RequestError, "413 too large"),
        (cases.refused(401, "unauthorized"), ServerError, "requires a key"),
        (cases.refused(403, "forbidden"), ServerError, "OLLAMA_HOST"),
        (cases.refused(403, "remote model is unavailable: ollama cloud is disabled"), ServerError, "cloud: name one"),
        (cases.refused(500, OTHER_FORMAT), UnusableReply, "expected peg-native format"),
        (cases.refused(500, "prediction aborted, token repeat limit reached"), UnusableReply, "token repeat limit"),
        (cases.refused(404, "model 'x' not found"), ServerError, "ollama pull qwen3:4b-instruct"),
        (cases.refused(302, ""), ServerError, "not an answer of an Ollama API"),
        (cases.busy(), TransientError, "server busy, please try again. maximum pending"),
        (cases.refused(429, "too many"), TransientError, "429 too many"),
        (cases.refused(502, "bad gateway"), TransientError, "502 bad gateway"),
        *((cases.refused(status, "too slow"), TransientError, f"{status} too slow") for status in (408, 499, 504)),
        (cases.RUNNER_DIED, TransientError, "unexpected EOF"),
        (cases.BAD_OPTION, ServerError, 'option "seed" must be of type integer'),
        (cases.BAD_FORMAT, ServerError, "invalid format"),
        (cases.ERROR_WITH_200, TransientError, "no longer running"),
        (cases.CUT, TransientError, "not JSON, or was cut"),
        (cases.ChatCase(raw=b"[1]"), TransientError, "not a JSON object"),
        (cases.ChatCase(raw=b'{"done": true}'), TransientError, "no message"),
        (cases.DROPPED, TransientError, "ServerDisconnectedError"),
        (cases.ChatCase(text="a" * 50, drop=True, cut=True), TransientError, "ClientPayloadError|ClientConnection"),
    ],
)
def test_every_failure_is_an_error_of_one_line_of_the_right_kind(case, kind, says):
    with pytest.raises(kind, match=says) as caught:
        ask(case)
    message = str(caught.value)
    assert type(caught.value) is kind
    assert not isinstance(caught.value, TransientError) or caught.value.busy == (case.status in (429, 502, 503))
    assert "\n" not in message
    assert "Ollama at http://127.0.0.1:" in message
    assert "qwen3:4b-instruct-2507-q4_K_M" in message


def test_retry_after_is_read_as_seconds_or_as_a_date():
    with pytest.raises(TransientError) as caught:
        ask(cases.busy("7"))
    assert caught.value.retry_after_s == 7
    now = datetime(2026, 9, 1, tzinfo=UTC)
    assert seconds_to_wait(format_datetime(now + timedelta(seconds=90), usegmt=True), now) == 90
    assert seconds_to_wait(format_datetime(now - timedelta(days=1), usegmt=True), now) == 0


TAG = "qwen3:4b-instruct-2507-q4_K_M"


def inspect(hosts, **changes):
    return run(make_model(hosts, **changes), lambda model: model.inspect())


def test_inspecting_tells_digest_version_capabilities_and_context_and_no_tag_means_latest():
    with OllamaServer(version="0.33.0") as server:
        info = inspect(server.url, name="qwen2.5vl:3b")
    assert (info.name, info.digest, info.server_version) == ("qwen2.5vl:3b", "c3" * 32, "0.33.0")
    assert (info.capabilities, info.context_length) == (("completion", "vision"), 128000)
    with OllamaServer() as server:
        assert inspect(server.url, name="llama3.2").digest == "b2" * 32
    assert full_tag("hf.co/a/b:Q4") == "hf.co/a/b:Q4"
    assert full_tag("gpu1:5000/a/b") == "gpu1:5000/a/b:latest"


def test_an_unknown_model_names_the_closest_and_the_way_to_get_it():
    with OllamaServer() as server, pytest.raises(InputError) as caught:
        inspect(server.url, name="qwen3:4b-instruct")
    message = str(caught.value)
    assert "Model 'qwen3:4b-instruct' not found. Did you mean 'qwen3:4b" in message
    assert "ollama pull qwen3:4b-instruct" in message
    assert "\n" not in message


def test_a_host_that_is_no_ollama_server_is_an_error_that_says_how_to_go_on():
    with OllamaServer() as server:
        url = server.url
    with pytest.raises(InputError, match=r"Start Ollama .* set OLLAMA_HOST, or try .* foundry model=scripted/random"):
        inspect(url)
    with OllamaServer() as server, pytest.raises(InputError, match="404 .* if it is not an Ollama server"):
        inspect(f"{server.url}/elsewhere")


def test_hosts_with_different_models_under_one_name_are_refused():
    with OllamaServer() as first, OllamaServer() as second:
        hosts = [first.url, second.url]
        assert inspect(hosts).digest == "a1" * 32
        second.models[TAG].digest = "ff" * 32
        with pytest.raises(InputError, match=r"differs between hosts: .* has a1a1.*, .* has ffff.*ollama pull"):
            inspect(hosts)


def test_a_context_beyond_the_models_own_is_refused():
    with OllamaServer() as server, pytest.raises(InputError, match=r"num_ctx=40960 or less"):
        inspect(server.url, name="qwen3:4b", options={"num_ctx": 50_000})


def test_thinking_needs_a_model_that_can():
    with OllamaServer() as server:
        assert inspect(server.url, name="qwen3:4b", think="high").capabilities
        with pytest.raises(InputError, match="cannot think"):
            inspect(server.url, think=True)


def test_listing_tells_everything_about_every_installed_model():
    models = [FakeModel(TAG, "a1" * 32, size=5), FakeModel("b:1b", "b1" * 32, ("completion", "vision"), 4096)]
    with OllamaServer(models=models) as server:
        run(make_model(server.url), lambda model: model.warm_up())
        listed = asyncio.run(list_models(server.url))
    assert [(m.name, m.loaded, m.context_length) for m in listed] == [("b:1b", False, 4096), (TAG, True, 262144)]
    first = listed[1]
    assert (first.digest, first.size, first.parameter_size, first.quantization) == ("a1" * 32, 5, "4.0B", "Q4_K_M")
    assert listed[0].capabilities == ("completion", "vision")
