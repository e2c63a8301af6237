from __future__ import annotations

import asyncio

import pytest

from foundry.errors import InputError
from foundry.models.ollama.info import list_models
from foundry.models.ollama.ollama_server import full_tag
from ollama_cases import FakeModel
from ollama_server import OllamaServer

TAG = "qwen3:4b-instruct-2507-q4_K_M"


def inspect(make_model, run, hosts, **changes):
    return run(make_model(hosts, **changes), lambda model: model.inspect())


def test_inspecting_tells_digest_version_capabilities_and_context_and_no_tag_means_latest(make_model, run):
    with OllamaServer(version="0.33.0") as server:
        info = inspect(make_model, run, server.url, name="qwen2.5vl:3b")
    assert (info.name, info.digest, info.server_version) == ("qwen2.5vl:3b", "c3" * 32, "0.33.0")
    assert (info.capabilities, info.context_length) == (("completion", "vision"), 128000)
    with OllamaServer() as server:
        assert inspect(make_model, run, server.url, name="llama3.2").digest == "b2" * 32
    assert full_tag("hf.co/a/b:Q4") == "hf.co/a/b:Q4"
    assert full_tag("gpu1:5000/a/b") == "gpu1:5000/a/b:latest"


def test_an_unknown_model_names_the_closest_and_the_way_to_get_it(make_model, run):
    with OllamaServer() as server, pytest.raises(InputError) as caught:
        inspect(make_model, run, server.url, name="qwen3:4b-instruct")
    message = str(caught.value)
    assert "Model 'qwen3:4b-instruct' not found. Did you mean 'qwen3:4b" in message
    assert "ollama pull qwen3:4b-instruct" in message
    assert "\n" not in message


def test_a_host_that_is_no_ollama_server_is_an_error_that_says_how_to_go_on(make_model, run):
    with OllamaServer() as server:
        url = server.url
    with pytest.raises(InputError, match=r"Start Ollama .* set OLLAMA_HOST, or try .* foundry model=scripted/random"):
        inspect(make_model, run, url)
    with OllamaServer() as server, pytest.raises(InputError, match="404 .* if it is not an Ollama server"):
        inspect(make_model, run, f"{server.url}/elsewhere")


def test_hosts_with_different_models_under_one_name_are_refused(make_model, run):
    with OllamaServer() as first, OllamaServer() as second:
        hosts = [first.url, second.url]
        assert inspect(make_model, run, hosts).digest == "a1" * 32
        second.models[TAG].digest = "ff" * 32
        with pytest.raises(InputError, match=r"not the same on all hosts: .* has a1a1.*, .* has ffff.*ollama pull"):
            inspect(make_model, run, hosts)


def test_a_context_beyond_the_models_own_is_refused(make_model, run):
    with OllamaServer() as server, pytest.raises(InputError, match=r"num_ctx=40960 or less"):
        inspect(make_model, run, server.url, name="qwen3:4b", options={"num_ctx": 50_000})


def test_thinking_needs_a_model_that_can(make_model, run):
    with OllamaServer() as server:
        assert inspect(make_model, run, server.url, name="qwen3:4b", think="high").capabilities
        with pytest.raises(InputError, match="cannot think"):
            inspect(make_model, run, server.url, think=True)


def test_listing_tells_everything_about_every_installed_model(make_model, run):
    models = [FakeModel(TAG, "a1" * 32, size=5), FakeModel("b:1b", "b1" * 32, ("completion", "vision"), 4096)]
    with OllamaServer(models=models) as server:
        run(make_model(server.url), lambda model: model.warm_up())
        listed = asyncio.run(list_models(server.url))
    assert [(m.name, m.loaded, m.context_length) for m in listed] == [("b:1b", False, 4096), (TAG, True, 262144)]
    first = listed[1]
    assert (first.digest, first.size, first.parameter_size, first.quantization) == ("a1" * 32, 5, "4.0B", "Q4_K_M")
    assert listed[0].capabilities == ("completion", "vision")
