"""Servers that say anything at all: every reply is a valid one, or an error with a name."""

import asyncio
import gzip
import json
import logging
import tracemalloc
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest
from aiohttp import web
from hypothesis import given, settings
from hypothesis import strategies as st

import ollama_cases as cases
from foundry.errors import BackendError, TransientError
from foundry.models.base import ChatMessage, Reply, Request
from foundry.models.http.pausing import requested_wait
from foundry.models.http.transport import LARGEST_BODY, Origin, _say_unknown, decoded
from foundry.models.ollama import ollama_server, ollama_wire
from foundry.models.openai import openai_wire
from json_parts import places, put
from local_server import LocalServer
from models.asking import ask, ask_openai, make_model, make_openai, make_request, run
from ollama_server import OllamaServer
from openai_server import ChatCase

HERE = Origin(host="http://127.0.0.1:1", model="m", version="1")
ASKED = Request(messages=(ChatMessage("user", "Where?"),), seed=7, kind="action", observation={}, step=1, agent=0)
OLLAMA = ollama_wire.ChatSettings(model="m", think=False, options={"num_ctx": 8192})
OPENAI = openai_wire.ChatSettings(model="m", options={}, context_length=8192)
OLLAMA_REPLY = {
    "model": "m",
    "message": {"role": "assistant", "content": "Left.", "thinking": "Hm."},
    "done": True,
    "done_reason": "stop",
    **{"total_duration": 9, "load_duration": 1, "prompt_eval_duration": 2, "eval_duration": 3},
    **{"prompt_eval_count": 4, "eval_count": 5},
}
OPENAI_REPLY = {
    "model": "m-2026",
    "system_fingerprint": "fp",
    "choices": [{"message": {"content": "Left.", "reasoning": "Hm."}, "finish_reason": "stop"}],
    "usage": {"prompt_tokens": 4, "completion_tokens": 5},
}
REFUSED = {"error": {"message": "no", "type": "t", "code": "c", "param": "p"}}

MANY = settings(max_examples=40)

json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.sampled_from([2**64, -(2**64), 10**400, 2**53, 0])
    | st.floats()
    | st.text(alphabet=st.characters(), max_size=5)
    | st.sampled_from(["\ud800", "stop", "", "NaN", "9" * 400]),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=4,
)


@st.composite
def spoilt(draw: st.DrawFn, whole: dict[str, Any]) -> bytes:
    """A body in which up to three places hold something else."""
    body: Any = whole
    for _ in range(draw(st.integers(1, 3))):
        body = put(body, draw(st.sampled_from(list(places(body)))), draw(json_values))
    return json.dumps(body).encode()


def assert_whole(reply: Reply) -> None:
    """A reply that the cache and the records give back as it is."""
    for codec in (msgspec.json, msgspec.msgpack):
        assert codec.decode(codec.encode(reply), type=Reply) == reply


def read_or_refused(read: Callable[[], Reply]) -> None:
    try:
        reply = read()
    except BackendError as error:
        str(error).encode()
        inner = getattr(error, "reply", None)
        if inner is not None:
            assert_whole(inner)
    else:
        assert_whole(reply)


@MANY
@given(spoilt(OLLAMA_REPLY))
def test_whatever_ollama_replies_is_a_valid_reply_or_an_error_with_a_name(content: bytes):
    read_or_refused(lambda: ollama_wire.read_reply(content, ASKED, OLLAMA, HERE, latency_s=0.1))


@MANY
@given(spoilt(OPENAI_REPLY) | spoilt({**OPENAI_REPLY, **REFUSED}))
def test_whatever_an_openai_server_replies_is_a_valid_reply_or_an_error_with_a_name(content: bytes):
    read_or_refused(lambda: openai_wire.read_reply(content, ASKED, OPENAI, HERE, latency_s=0.1))


@MANY
@given(spoilt(REFUSED) | st.binary(max_size=30), st.sampled_from([302, 400, 401, 404, 429, 500, 503]))
def test_whatever_a_refusal_holds_is_an_error_with_a_name(content: bytes, status: int):
    for error in (ollama_server.refusal(HERE, status, content), openai_wire.refusal(HERE, status, content)):
        assert isinstance(error, BackendError) and "\n" not in str(error)
        str(error).encode()


@given(
    st.sampled_from(["-1", "inf", "nan", "Tue, 99 Foo 2026", "9" * 400 + "h"])
    | st.text(max_size=30)
    | st.from_regex(r"[A-Z][a-z]{2}, \d+ [A-Z][a-z]{2} \d+ \d+:\d+:\d+ [+-]\d+", fullmatch=True)
)
def test_whatever_headers_ask_is_a_finite_wait_or_none(text: str):
    names = ("retry-after", "retry-after-ms", "x-ratelimit-reset-tokens", "x-ratelimit-remaining-tokens")
    for name in names:
        wait_s = requested_wait({"x-ratelimit-remaining-tokens": "0", name: text})
        assert wait_s is None or 0 <= wait_s < float("inf")


def test_a_reply_nested_too_deep_is_worth_another_try():
    for nested in (b"[" * 100_000, b'{"message":' * 100_000):
        with pytest.raises(TransientError, match="not JSON"):
            ask(cases.ChatCase(raw=nested))
        with pytest.raises(TransientError, match="not JSON"):
            ask_openai(ChatCase(raw=nested))


ODD = {"eval_count": True, "prompt_eval_count": -3, "total_duration": float("nan"), "eval_duration": "long"}


def test_a_number_that_is_none_is_unknown_and_said_once(caplog: pytest.LogCaptureFixture):
    _say_unknown.cache_clear()
    raw = json.dumps({**OLLAMA_REPLY, **ODD}).encode()
    with caplog.at_level(logging.WARNING, "foundry"):
        reply, _ = ask(cases.ChatCase(raw=raw))
    assert (reply.prompt_tokens, reply.output_tokens, set(reply.timings)) == (None, None, {"latency"})
    unknown = ["prompt_eval_count", "eval_count", "total_duration"]
    assert [record.getMessage().split("'")[3] for record in caplog.records] == unknown
    with caplog.at_level(logging.WARNING, "foundry"):
        for _ in range(3):
            ollama_wire.read_reply(raw, ASKED, OLLAMA, Origin(host="http://h", model="m"), latency_s=0.1)
    assert len(caplog.records) == 6


class Pouring(LocalServer):
    def __init__(self, pieces: Iterator[bytes], pause_s: float = 0.0, encoding: str = "identity") -> None:
        super().__init__()
        self.pieces, self.pause_s, self.encoding = pieces, pause_s, encoding
        self.poured = 0

    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        response = web.StreamResponse(headers={"Content-Encoding": self.encoding})
        await response.prepare(request)
        for piece in self.pieces:
            await response.write(piece)
            self.poured += len(piece)
            await asyncio.sleep(self.pause_s)
        await response.write_eof()
        return response


def endless(piece: bytes) -> Iterator[bytes]:
    while True:
        yield piece


@pytest.fixture(params=["ollama", "openai"])
def make_any(request: pytest.FixtureRequest):
    return make_model if request.param == "ollama" else lambda url, **kind: make_openai(f"{url}/v1", **kind)


def test_a_reply_that_drips_ends_at_the_time_limit_of_the_whole(make_any):
    with Pouring(endless(b" "), pause_s=0.005) as server:
        model = make_any(server.url, server={"read_timeout_s": 0.1})
        with pytest.raises(TransientError, match=r"no complete reply within 0\.1 s"):
            run(model, lambda m: m.ask(make_request()))


def test_a_reply_without_an_end_is_left(make_any):
    with Pouring(endless(b" " * 2**20)) as server, pytest.raises(TransientError, match="longer than 8 MiB"):
        run(make_any(server.url), lambda m: m.ask(make_request()))
    assert server.poured < 8 * LARGEST_BODY


def test_a_small_body_that_unpacks_to_gigabytes_costs_little_memory(make_any):
    bomb = gzip.compress(b" " * 2**20) * 2**11
    with Pouring(iter([bomb]), encoding="gzip") as server:
        tracemalloc.start()
        try:
            with pytest.raises(TransientError, match="longer than 8 MiB"):
                run(make_any(server.url), lambda m: m.ask(make_request()))
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert peak < 64 * 2**20


def test_a_compressed_reply_of_common_size_is_read(make_any):
    either = {**OLLAMA_REPLY, "choices": OPENAI_REPLY["choices"]}
    with Pouring(iter([gzip.compress(json.dumps(either).encode())]), encoding="gzip") as server:
        assert run(make_any(server.url), lambda m: m.ask(make_request())).text == "Left."


@pytest.mark.parametrize(
    "body",
    [
        b'{"a": 1e5, "b": -0, "c": 123456789012345678901234567890, "d": 0.1, "e": "\\u00e9\xc3\xa9"}',
        b'{"a": 1, "a": [true, null, {}]}',
        b'{"a": NaN, "b": -Infinity, "c": 1e400}',
        b'{"a": "\xff\xed\xa0\x80", "\xff": 1}',
        b'{"a": "\\ud800"}',
    ],
)
def test_a_body_says_what_json_says_that_it_does(body: bytes):
    assert repr(decoded(body)) == repr(json.loads(body.decode("utf-8", "replace")))
    assert decoded(body[:-1]) is None


def test_a_long_pause_is_said_once(caplog: pytest.LogCaptureFixture):
    async def ask_thrice(model: Any) -> list[Any]:
        return await asyncio.gather(*(model.ask(make_request(str(n))) for n in range(3)), return_exceptions=True)

    with OllamaServer(lambda body: cases.busy("300")) as server, caplog.at_level(logging.WARNING, "foundry"):
        errors = run(make_model(server.url), ask_thrice)
    assert [type(error) for error in errors] == [TransientError] * 3
    (said,) = [record.getMessage() for record in caplog.records]
    assert said.endswith("asks for a pause of 300 s; calls to it wait.")
