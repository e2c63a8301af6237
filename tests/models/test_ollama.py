from __future__ import annotations

import asyncio
import base64
import json
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime

import ollama_cases as cases
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ollama_server import OllamaServer

from foundry.errors import InputError, RequestError, ServerError, TransientError
from foundry.models.base import UnusableReply
from foundry.models.ollama_errors import seconds_to_wait
from foundry.models.ollama_wire import chat_body, split_thinking, without_surrogates

PIXEL = b"\x89PNG\r\n"
OPTIONS = {
    "temperature": 0.2,
    "top_k": 40,
    "top_p": 0.9,
    "min_p": 0.0,
    "typical_p": 1.0,
    "repeat_penalty": 1.0,
    "repeat_last_n": 64,
    "presence_penalty": 0.0,
    "frequency_penalty": 0.0,
    "num_keep": 4,
    "num_predict": 512,
    "num_ctx": 8192,
}
SHARED = {"model": "qwen3:4b-instruct-2507-q4_K_M", "stream": False, "truncate": False, "think": False}


@pytest.fixture
def ask(make_model, make_request, run):
    """Ask a server that answers like this once, and return what it got and what it gave."""

    def ask_once(answer, *contents, request=None, **changes):
        with OllamaServer(answer if callable(answer) else cases.in_turn(answer)) as server:
            asked = make_model(server.url, **changes)
            reply = run(asked, lambda m: m.ask(request or make_request(*contents)))
            return reply, server.bodies[0]

    return ask_once


def test_a_call_sends_exactly_this_body(ask):
    _, body = ask(cases.grid_answer, "Where?")
    assert body == {
        **SHARED,
        "messages": [{"role": "user", "content": "Where?"}],
        "keep_alive": "30m",
        "options": {**OPTIONS, "seed": 7},
    }


def test_the_body_is_the_one_of_the_pure_function(ask, make_model, make_request):
    _, body = ask(cases.grid_answer, "Where?")
    assert body == chat_body(make_model("gpu1").settings, make_request("Where?"), "30m")


def test_images_travel_as_plain_base64_beside_the_text(ask, make_request):
    request = make_request("Look", images=(PIXEL,))
    _, body = ask(cases.grid_answer, request=request, name="qwen2.5vl:3b")
    assert body["messages"] == [{"role": "user", "content": "Look", "images": [base64.b64encode(PIXEL).decode()]}]


def test_a_schema_goes_with_its_kind_of_question(ask, make_request):
    _, body = ask(cases.grid_answer, request=make_request(kind="message"), format="schema")
    assert sorted(body["format"]["properties"]) == ["message", "reasoning"]


def test_options_left_to_the_model_are_not_sent_and_load_options_are_when_set(ask):
    _, body = ask(cases.grid_answer, options={"num_thread": 2, "top_k": None})
    assert body["options"]["num_thread"] == 2
    assert not {"top_k", "stop", "num_gpu"} & set(body["options"])


def test_parameters_are_what_is_sent_beside_messages_seed_and_keep_alive(make_model):
    assert make_model("gpu1").parameters() == {**SHARED, "options": OPTIONS}


def test_parameters_hold_the_schemas_of_all_kinds(make_model):
    model = make_model("gpu1", format="schema")
    assert set(model.parameters()["format"]) == {"action", "message"} == set(model.kinds)


def test_transport_settings_are_no_parameters(make_model):
    slow = make_model("gpu1,gpu2", server={"keep_alive": 5, "read_timeout_s": 9})
    assert slow.parameters() == make_model("gpu9").parameters()


def test_a_kind_without_schema_is_refused_before_anything_is_sent(make_model, make_request):
    with pytest.raises(RequestError, match="No schema for questions of kind 'dance'; there are: action, message"):
        chat_body(make_model("gpu1", format="schema").settings, make_request(kind="dance"), "30m")


def test_schema_properties_are_in_alphabetical_order(make_model):
    for schema in make_model("gpu1", format="schema").settings.schemas.values():
        assert list(schema["properties"]) == sorted(schema["properties"])


def test_a_reply_carries_text_tokens_host_and_timings(ask):
    case = cases.ChatCase(text="I stay.", prompt_tokens=900, output_tokens=5, delay_s=0.02)
    reply, _ = ask(case)
    assert (reply.text, reply.ending, reply.thinking) == ("I stay.", "stop", None)
    assert (reply.prompt_tokens, reply.output_tokens) == (900, 5)
    assert reply.host.startswith("http://127.0.0.1:")
    assert reply.timings["output"] == pytest.approx(0.02)
    parts = sum(reply.timings[name] for name in ("load", "prompt", "output", "queue"))
    assert parts == pytest.approx(reply.timings["total"])
    assert reply.timings["latency"] >= reply.timings["total"] > 0


def test_lone_surrogates_become_replacement_characters_both_ways(ask):
    raw = b'{"message": {"role": "assistant", "content": "a\\ud800b"}, "done": true, "done_reason": "stop"}'
    reply, body = ask(cases.ChatCase(raw=raw), "x\ud83dy")
    assert reply.text == "a\ufffdb"
    assert body["messages"][0]["content"] == "x\ufffdy"


@given(st.text(st.characters(codec=None)))
def test_any_text_can_be_sent_and_only_lone_surrogates_change(text):
    clean = without_surrogates(text)
    clean.encode()
    if not any(0xD800 <= ord(character) <= 0xDFFF for character in text):
        assert clean == text


def test_thinking_that_comes_before_the_text_is_taken_apart():
    assert split_thinking("<think>\nfire?\n</think>\n\nstay", "") == ("stay", "fire?")
    assert split_thinking("<think>fire and", "") == ("", "fire and")
    assert split_thinking("stay <think>", "") == ("stay <think>", "")
    assert split_thinking("<think>a</think>b", "else") == ("<think>a</think>b", "else")


def test_a_reply_cut_by_the_length_limit_says_so(ask):
    assert ask(cases.ChatCase(text='{"act', done_reason="length"))[0].ending == "length"


def test_thinking_without_content_up_to_the_limit_is_a_reply(ask):
    reply, _ = ask(cases.ONLY_THINKING)
    assert (reply.text, reply.ending) == ("", "length")
    assert reply.thinking.startswith("Hmm")


@pytest.mark.parametrize("case", [cases.ABORTED, cases.ABORTED_500])
def test_a_model_that_repeats_itself_gives_an_aborted_reply(ask, case):
    with pytest.raises(UnusableReply) as caught:
        ask(case)
    assert (caught.value.reply.text, caught.value.reply.ending) == ("", "aborted")


def test_an_empty_reply_is_unusable_and_kept(ask):
    with pytest.raises(UnusableReply, match="empty") as caught:
        ask(cases.EMPTY)
    assert (caught.value.reply.ending, caught.value.reply.output_tokens) == ("stop", 1)


@pytest.mark.parametrize(
    ("case", "kind", "says"),
    [
        (cases.refused(400, "invalid think value"), RequestError, "invalid think value. It would be refused again"),
        (cases.refused(413, "too large"), RequestError, "413 too large"),
        (cases.refused(401, "unauthorized"), ServerError, "wants a key"),
        (cases.refused(403, "forbidden"), ServerError, "OLLAMA_HOST"),
        (cases.refused(404, "model 'x' not found"), ServerError, "ollama pull qwen3:4b-instruct"),
        (cases.refused(302, ""), ServerError, "no answer of an Ollama API"),
        (cases.busy(), TransientError, "server busy, please try again. maximum pending"),
        (cases.refused(429, "too many"), TransientError, "429 too many"),
        (cases.refused(502, "bad gateway"), TransientError, "502 bad gateway"),
        (cases.refused(504, "too slow"), TransientError, "504 too slow"),
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
def test_every_failure_is_an_error_of_one_line_of_the_right_kind(ask, case, kind, says):
    with pytest.raises(kind, match=says) as caught:
        ask(case)
    message = str(caught.value)
    assert type(caught.value) is kind
    assert "\n" not in message
    assert "Ollama at http://127.0.0.1:" in message
    assert "qwen3:4b-instruct-2507-q4_K_M" in message


@pytest.mark.parametrize(("case", "is_busy"), [(cases.busy(), True), (cases.RUNNER_DIED, False)])
def test_only_a_full_server_is_busy(ask, case, is_busy):
    with pytest.raises(TransientError) as caught:
        ask(case)
    assert caught.value.busy is is_busy


def test_retry_after_is_read_as_seconds_or_as_a_date(ask):
    with pytest.raises(TransientError) as caught:
        ask(cases.busy("7"))
    assert caught.value.retry_after_s == 7
    now = datetime(2026, 9, 1, tzinfo=UTC)
    assert seconds_to_wait(format_datetime(now + timedelta(seconds=90), usegmt=True), now) == 90
    assert seconds_to_wait(format_datetime(now - timedelta(days=1), usegmt=True), now) == 0


@given(st.text() | st.sampled_from(["-1", "inf", "nan", "Tue, 99 Foo 2026"]))
def test_any_retry_after_is_a_finite_wait_or_none(header):
    wait = seconds_to_wait(header, datetime(2026, 9, 1, tzinfo=UTC))
    assert wait is None or 0 <= wait < float("inf")


def test_a_long_prompt_is_refused_by_the_server_and_ends_the_run(ask):
    with pytest.raises(RequestError, match="exceeds the available context size"):
        ask(cases.grid_answer, "word " * 20_000)


def test_a_prompt_that_was_cut_without_a_word_is_noticed(ask):
    with pytest.raises(RequestError, match="silent truncation of a prompt of 9000 bytes to 1026 tokens"):
        ask(cases.truncated(2048), "fire and water " * 600, options={"num_ctx": 2048})


def test_a_short_prompt_is_never_taken_for_a_cut_one(ask):
    reply, _ = ask(cases.truncated(2048), "fire and water " * 60, options={"num_ctx": 2048})
    assert reply.prompt_tokens == 1026


def test_a_reply_that_overflows_the_context_is_noticed(ask):
    with pytest.raises(RequestError, match="overflowed the context"):
        ask(cases.ChatCase(text="on and on", prompt_tokens=2000, output_tokens=100), options={"num_ctx": 2048})


def test_a_server_that_never_answers_is_given_up_after_the_read_time_out(ask):
    with pytest.raises(TransientError, match=r"no reply within 0\.1 s"):
        ask(cases.HANGING, server={"read_timeout_s": 0.1})


def test_a_refused_connection_is_worth_another_try(make_model, make_request, run):
    with OllamaServer() as server:
        url = server.url
    with pytest.raises(TransientError, match=r"Start Ollama \(ollama serve"):
        run(make_model(url), lambda model: model.ask(make_request()))


def test_something_that_does_not_speak_http_is_worth_another_try(make_model, make_request):
    async def babble(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
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

    with pytest.raises(TransientError):
        asyncio.run(ask_it())


def test_calls_go_to_the_least_loaded_host(make_model, make_request, run):
    with OllamaServer(latency_s=0.05) as first, OllamaServer(latency_s=0.05) as second:
        model = make_model([first.url, second.url])
        run(model, lambda m: m.ask_all([make_request(seed=n) for n in range(7)]))
        assert (first.counts.chats, second.counts.chats) == (4, 3)


def test_a_dead_host_does_not_draw_every_call(make_model, make_request, run):
    with OllamaServer() as dead:
        gone = dead.url

    async def ask_one_by_one(model):
        return [(await asyncio.gather(model.ask(make_request()), return_exceptions=True))[0] for _ in range(6)]

    with OllamaServer() as alive:
        replies = run(make_model([gone, alive.url]), ask_one_by_one)
        assert sum(isinstance(reply, TransientError) for reply in replies) == 1


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
        await model.warm_up()
        return await model.ask(make_request())

    with OllamaServer(load_s=0.4) as server:
        reply = run(make_model(server.url, server={"read_timeout_s": 0.1}), warm_up_and_ask)
        assert reply.server_version == "0.32.15"
        assert server.counts.loads == 1
        assert server.loads == [{**SHARED, "messages": [], "keep_alive": "30m", "options": OPTIONS}]


def test_a_load_whose_caller_gives_up_starts_again(make_model, make_request, run):
    with OllamaServer(load_s=0.3) as server:
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
        ({"name": "gpt-oss:120b-cloud"}, "runs in Ollama's cloud"),
        ({"name": "glm-5:cloud"}, "runs in Ollama's cloud"),
        ({"name": " "}, "foundry models"),
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


def test_the_default_answers_depend_on_prompt_and_seed_alone(ask, make_request):
    prompt = '{"action": ...}'
    texts = [ask(cases.grid_answer, request=make_request(prompt, seed=seed))[0].text for seed in (1, 1, 2)]
    assert texts[0] == texts[1] != texts[2]
    assert set(json.loads(texts[0])) >= {"action", "memory", "reasoning"}
