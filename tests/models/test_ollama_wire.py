import base64
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ollama_cases as cases
from foundry.errors import RequestError
from foundry.models.base import Request, UnusableReply
from foundry.models.http.transport import Origin
from foundry.models.ollama.ollama_wire import DURATIONS, ChatSettings, chat_body, read_reply
from models.asking import ask, make_model, make_request

PIXEL = b"\x89PNG\r\n"
OPTIONS = {
    **{"temperature": 0.2, "top_k": 40, "top_p": 0.9, "min_p": 0.0, "typical_p": 1.0, "repeat_penalty": 1.0},
    **{"repeat_last_n": 64, "presence_penalty": 0.0, "frequency_penalty": 0.0, "num_keep": 4, "num_predict": 512},
    "num_ctx": 10240,
}
SHARED = {"model": "qwen3:4b-instruct-2507-q4_K_M", "stream": False, "truncate": False, "think": False}


def test_a_call_sends_exactly_the_body_of_the_pure_function():
    _, body = ask(cases.grid_answer, "Where?")
    assert body == chat_body(make_model("gpu1").settings, make_request("Where?"), "30m")
    assert body == {
        **SHARED,
        "messages": [{"role": "user", "content": "Where?"}],
        "keep_alive": "30m",
        "options": {**OPTIONS, "seed": 7},
    }


def test_images_travel_as_plain_base64_beside_the_text():
    request = make_request("Look", images=(PIXEL,))
    _, body = ask(cases.grid_answer, request=request, name="qwen2.5vl:3b")
    assert body["messages"] == [{"role": "user", "content": "Look", "images": [base64.b64encode(PIXEL).decode()]}]


def test_a_schema_goes_with_its_kind_of_question():
    _, body = ask(cases.grid_answer, request=make_request(kind="message"), format="schema")
    assert sorted(body["format"]["properties"]) == ["message", "reasoning"]


def test_options_left_to_the_model_are_not_sent_and_load_options_are_when_set():
    _, body = ask(cases.grid_answer, options={"num_thread": 2, "top_k": None})
    assert body["options"]["num_thread"] == 2
    assert not {"top_k", "stop", "num_gpu"} & set(body["options"])


def test_parameters_are_what_is_sent_beside_messages_seed_and_keep_alive_with_the_schemas_of_all_kinds():
    assert make_model("gpu1").parameters() == {**SHARED, "options": OPTIONS}
    model = make_model("gpu1", format="schema")
    assert set(model.parameters()["format"]) == {"action", "message"} == set(model.kinds)
    for schema in make_model("gpu1", format="schema").settings.schemas.values():
        assert list(schema["properties"]) == sorted(schema["properties"])
    slow = make_model("gpu1,gpu2", server={"keep_alive": 5, "read_timeout_s": 9})
    assert slow.parameters() == make_model("gpu9").parameters()


def test_a_kind_without_schema_is_refused_before_anything_is_sent():
    with pytest.raises(RequestError, match="No schema for questions of kind 'dance'; available: action, message"):
        chat_body(make_model("gpu1", format="schema").settings, make_request(kind="dance"), "30m")


def test_a_reply_carries_text_tokens_host_and_timings():
    case = cases.ChatCase(text="I stay.", prompt_tokens=900, output_tokens=5, delay_s=0.02)
    reply, _ = ask(case)
    assert (reply.text, reply.ending, reply.thinking) == ("I stay.", "stop", None)
    assert (reply.prompt_tokens, reply.output_tokens) == (900, 5)
    assert reply.host.startswith("http://127.0.0.1:")
    assert reply.timings["output"] == pytest.approx(0.02)
    parts = sum(reply.timings[name] for name in ("load", "prompt", "output", "queue"))
    assert parts == pytest.approx(reply.timings["total"])
    assert reply.timings["latency"] >= reply.timings["total"] > 0


@given(st.lists(st.integers(0, 10**12), min_size=4, max_size=4))
def test_what_a_server_leaves_unaccounted_for_is_the_wait_for_a_slot(parts):
    said = dict(zip(DURATIONS, (sum(parts), *parts[1:]), strict=True))
    body = msgspec.json.encode({"message": {"content": "Left."}, "done": True, **said})
    request = Request(messages=(), seed=7, kind="action", observation={}, step=1, agent=0)
    settings = ChatSettings(model="m", think=False, options={"num_ctx": 8192})
    reply = read_reply(body, request, settings, Origin(host="http://gpu", model="m"), latency_s=9.0)
    assert reply.timings["queue"] == pytest.approx(parts[0] / 1e9, abs=1e-6)


def test_lone_surrogates_become_replacement_characters_both_ways():
    raw = b'{"message": {"role": "assistant", "content": "a\\ud800b"}, "done": true, "done_reason": "stop"}'
    reply, body = ask(cases.ChatCase(raw=raw), "x\ud83dy")
    assert reply.text == "a\ufffdb"
    assert body["messages"][0]["content"] == "x\ufffdy"


def test_a_reply_cut_by_the_length_limit_says_so_even_where_all_of_it_is_thinking():
    assert ask(cases.ChatCase(text='{"act', done_reason="length"))[0].ending == "length"
    reply, _ = ask(cases.ONLY_THINKING)
    assert (reply.text, reply.ending) == ("", "length")
    assert reply.thinking.startswith("Hmm")


def test_an_empty_reply_is_unusable_and_kept():
    with pytest.raises(UnusableReply, match="empty") as caught:
        ask(cases.EMPTY)
    assert (caught.value.reply.ending, caught.value.reply.output_tokens) == ("stop", 1)


def test_a_long_prompt_is_refused_by_the_server_and_one_cut_without_a_word_is_noticed():
    with pytest.raises(RequestError, match="exceeds the available context size"):
        ask(cases.grid_answer, "word " * 20_000)
    with pytest.raises(RequestError, match="silent truncation of a prompt of 9000 bytes to 1026 tokens"):
        ask(cases.truncated(2048), "fire and water " * 600, options={"num_ctx": 2048})
    reply, _ = ask(cases.truncated(2048), "fire and water " * 60, options={"num_ctx": 2048})
    assert reply.prompt_tokens == 1026


@pytest.mark.parametrize("prompt_tokens", [1, 2000, 2048])
def test_a_reply_that_fills_the_context_is_one_and_a_token_more_overflows_it(prompt_tokens):
    full = cases.ChatCase(text="on and on", prompt_tokens=prompt_tokens, output_tokens=2048 - prompt_tokens)
    assert ask(full, options={"num_ctx": 2048})[0].text == "on and on"
    with pytest.raises(RequestError, match="overflowed the context"):
        ask(replace(full, output_tokens=2049 - prompt_tokens), options={"num_ctx": 2048})
