import base64
import contextlib
import json
from pathlib import Path

import pytest

from foundry.errors import InputError, RequestError, ServerError, TransientError
from foundry.models.answers.sqlite import SqliteAnswers
from foundry.models.base import RequestKeys, UnusableReply
from foundry.models.wrappers.limited import Limit
from foundry.running.build import model_stack
from models.asking import ask_openai, make_openai, make_request, run
from openai_server import ChatCase, OpenAIServer, refused

PNG = b"\x89PNG\r\n\x1a\n1"
JPEG = b"\xff\xd8\xff\xe01"
OTHER_FORMAT = "The model produced output that does not match the expected peg-native format"
OVERFLOW = "This model's maximum context length is 8192 tokens."


def test_every_set_option_is_sent_with_its_value_and_no_other():
    reply, body = ask_openai("Left.", extra={"top_k": 40, "min_p": None})
    assert body == {
        "model": "a",
        "messages": [{"role": "user", "content": "Where do you go?"}],
        "stream": False,
        "temperature": 0.2,
        "top_p": 0.9,
        "presence_penalty": 0.0,
        "frequency_penalty": 0.0,
        "max_tokens": 512,
        "top_k": 40,
        "seed": 7,
    }
    assert (reply.text, reply.ending, reply.thinking) == ("Left.", "stop", None)


def test_tokens_host_fingerprint_and_the_models_full_name_are_kept():
    case = ChatCase("Left.", model="a-2026-01-01", usage={"prompt_tokens": 90, "completion_tokens": 3})
    reply, _ = ask_openai(case)
    assert (reply.prompt_tokens, reply.output_tokens) == (90, 3)
    assert (reply.server_version, reply.served_model) == ("fp_44709d6fcb", "a-2026-01-01")
    assert reply.host is not None and reply.host.endswith("/v1")
    assert reply.timings["latency"] > 0


@pytest.mark.parametrize(
    ("told", "cached"),
    [
        ({"prompt_tokens": 90, "completion_tokens": 3, "prompt_tokens_details": {"cached_tokens": 64}}, 64),
        ({"prompt_tokens": 90, "completion_tokens": 3, "prompt_tokens_details": {"cached_tokens": 0}}, 0),
        ({"prompt_tokens": 90, "completion_tokens": 3, "prompt_tokens_details": None}, None),
        ({"prompt_tokens": 90, "completion_tokens": 3}, None),
    ],
)
def test_tokens_from_the_servers_prompt_cache_are_kept_where_it_tells_them(told, cached):
    reply, _ = ask_openai(ChatCase("Left.", usage=told))
    assert reply.cached_tokens == cached


def test_the_rest_of_the_time_that_llama_cpp_accounts_for_is_the_wait_for_its_slot():
    reply, _ = ask_openai(ChatCase("Left.", timings={"prompt_ms": 0.002, "predicted_ms": 0.003, "cache_n": 1}))
    assert (reply.timings["prompt"], reply.timings["output"]) == pytest.approx((2e-6, 3e-6))
    assert reply.timings["queue"] == pytest.approx(reply.timings["latency"] - 5e-6)
    longer, _ = ask_openai(ChatCase("Left.", timings={"prompt_ms": 1e9, "predicted_ms": 0}))
    assert longer.timings["queue"] == 0


@pytest.mark.parametrize("timings", [{"prompt_ms": 1.0}, {"prompt_ms": "1", "predicted_ms": 2}, [], "1 s"])
def test_odd_times_of_a_server_are_left_out(timings):
    reply, _ = ask_openai(ChatCase("Left.", timings=timings))
    assert reply.timings.keys() == {"latency"}


@pytest.mark.parametrize(("slots", "most", "begin"), [(4, 512, 5), (4, 3, 3), (None, 512, 16)])
def test_the_limit_begins_at_the_slots_that_llama_cpp_tells_and_one_call_more(tmp_path: Path, slots, most, begin):
    limits = []

    async def stack(model):
        info = await model.inspect()
        with contextlib.closing(SqliteAnswers(tmp_path / "answers.sqlite")) as answers:
            model_stack(model, lambda: answers, info, lambda bounds: limits.append(Limit(bounds)) or limits[0])

    with OpenAIServer(models={"a": {"meta": {}}}, props=None if slots is None else {"total_slots": slots}) as server:
        bounds = {"min": 1, "max": most, "initial": min(16, most)}
        run(make_openai(server.base_url, server={"in_flight": bounds, "canary": False}), stack)
    assert limits[0].allowed == begin
    assert limits[0].bounds.max == (most if slots is None else begin)


def test_images_are_data_uris_before_the_text():
    _, body = ask_openai("A door.", request=make_request("What is there?", images=(PNG, JPEG)), image_detail="low")
    *images, text = body["messages"][0]["content"]
    assert text == {"type": "text", "text": "What is there?"}
    assert [image["image_url"]["detail"] for image in images] == ["low", "low"]
    for image, kind, content in zip(images, ("png", "jpeg"), (PNG, JPEG), strict=True):
        head, _, data = image["image_url"]["url"].partition(",")
        assert head == f"data:image/{kind};base64"
        assert base64.b64decode(data) == content


def test_a_schema_goes_with_its_kind_of_question():
    _, body = ask_openai("{}", format="schema", request=make_request(kind="message"))
    asked = body["response_format"]
    assert (asked["type"], asked["json_schema"]["name"], asked["json_schema"]["strict"]) == (
        "json_schema",
        "message",
        False,
    )
    assert asked["json_schema"]["schema"]["required"] == ["message", "reasoning"]
    with pytest.raises(RequestError, match="No schema for questions of kind 'command'; available: action, message"):
        ask_openai("{}", format="schema", request=make_request(kind="command"))


def test_the_seed_goes_by_another_name_or_not_at_all():
    assert ask_openai("x", seed_field="random_seed")[1]["random_seed"] == 7
    assert "seed" not in ask_openai("x", seed_field=None)[1]


@pytest.mark.parametrize(
    ("message", "thinking"),
    [
        ({"reasoning_content": "Hm."}, "Hm."),
        ({"reasoning": "Hm."}, "Hm."),
        ({"reasoning": {"effort": "low"}}, None),
        ({"reasoning_content": ""}, None),
    ],
)
def test_what_was_thought_is_kept_apart(message, thinking):
    assert ask_openai(ChatCase("Left.", message))[0].thinking == thinking


def test_a_refusal_in_words_is_a_reply_and_parts_of_text_are_joined():
    assert ask_openai(ChatCase(None, {"refusal": "I will not."}))[0].text == "I will not."
    parts = [{"type": "thinking", "thinking": []}, {"type": "text", "text": "Le"}, {"type": "text", "text": "ft."}]
    assert ask_openai(ChatCase(parts))[0].text == "Left."


@pytest.mark.parametrize("reason", ["length", "max_tokens"])
def test_a_reply_cut_by_its_length_says_so(reason):
    assert ask_openai(ChatCase("", finish_reason=reason))[0].ending == "length"


@pytest.mark.parametrize("reason", ["content_filter", "abort", "error", None])
def test_a_reply_that_the_server_gave_up_is_aborted_and_without_text(reason):
    with pytest.raises(UnusableReply) as caught:
        ask_openai(ChatCase("half a", finish_reason=reason))
    assert (caught.value.reply.text, caught.value.reply.ending) == ("", "aborted")
    with pytest.raises(UnusableReply, match="the reply is empty"):
        ask_openai(ChatCase(None))


@pytest.mark.parametrize("raw", [b'{"id": "x", "choi', b"[]", b'{"choices": []}', b'{"choices": [{"message": null}]}'])
def test_what_is_no_reply_is_worth_another_try(raw):
    with pytest.raises(TransientError, match="not JSON|not a JSON object|contains no message"):
        ask_openai(ChatCase(raw=raw))


@pytest.mark.parametrize(
    ("case", "kind", "says"),
    [
        (refused(400, "bad schema"), RequestError, "400 bad schema. It would be refused again"),
        (refused(422, "not valid"), RequestError, "422 not valid"),
        (refused(400, OVERFLOW, code="context_length_exceeded"), RequestError, "does not fit"),
        (refused(400, "too long", type="exceed_context_size_error", code=400), RequestError, "does not fit"),
        (refused(500, "image input is not supported - hint: mmproj"), RequestError, "model.vision=false"),
        (refused(400, "no", code="unsupported_parameter", param="max_tokens"), ServerError, "options.max_tokens=null"),
        (refused(400, "no", code="unsupported_value", param="temperature"), ServerError, "options.temperature=null"),
        (refused(400, "no", code="unknown_parameter", param="top_k"), ServerError, "Remove top_k"),
        (refused(401, "no key"), ServerError, "Put the key into OPENAI_API_KEY"),
        (refused(402, "Insufficient Balance"), ServerError, "no money left"),
        (refused(403, "country"), ServerError, "may not use this model"),
        (refused(404, "no such model", code="model_not_found"), ServerError, "Check the model's name"),
        (refused(404, "page not found"), ServerError, "/v1"),
        (refused(429, "quota", code="insufficient_quota"), ServerError, "no money left"),
        (refused(429, "quota", type="insufficient_quota"), ServerError, "no money left"),
        (refused(429, "slow down"), TransientError, "429 slow down"),
        (refused(503, "Loading model", type="unavailable_error", code=503), TransientError, "Loading model"),
        (refused(529, "overloaded"), TransientError, "529 overloaded"),
        (refused(408, "slow"), TransientError, "408 slow"),
        (refused(500, "it broke"), TransientError, "500 it broke"),
        (refused(500, OTHER_FORMAT, type="server_error", code=500), UnusableReply, "expected peg-native format"),
        (refused(302), ServerError, "not an answer of an OpenAI API"),
        (ChatCase(status=400, raw=b'{"object":"error","message":"bad","code":40001}'), RequestError, "400 bad"),
        (ChatCase(status=500, raw=b"<html>"), TransientError, "500 <html>"),
        (ChatCase(error="text alone", status=400), RequestError, "400 text alone"),
        (ChatCase(error={"message": "upstream", "code": 502}), TransientError, "502 upstream"),
        (ChatCase(error={"message": "moderation", "code": 403}), ServerError, "403 moderation"),
    ],
)
def test_every_refusal_means_what_it_should(case, kind, says):
    with pytest.raises(kind) as caught:
        ask_openai(case)
    assert says in str(caught.value)
    assert type(caught.value) is kind
    if isinstance(caught.value, TransientError):
        assert caught.value.busy == any(status in says + str(case.status) for status in ("429", "502", "503", "529"))


def test_a_server_that_never_answers_or_is_not_there_is_worth_another_try():
    with pytest.raises(TransientError, match=r"no complete reply within 0\.1 s") as late:
        ask_openai(ChatCase(hang=True), server={"read_timeout_s": 0.1})
    with OpenAIServer() as server:
        gone = server.base_url
    with pytest.raises(TransientError, match="OPENAI_BASE_URL"):
        run(make_openai(gone), lambda model: model.ask(make_request()))
    assert late.value.late and not late.value.busy


def test_a_call_that_used_more_than_the_context_was_cut():
    case = ChatCase("x", usage={"prompt_tokens": 90, "completion_tokens": 20})
    with pytest.raises(RequestError, match=r"prompt \(90 tokens\) and reply \(20\) overflowed"):
        ask_openai(case, context_length=100)
    assert ask_openai(case, context_length=110)[0].text == "x"


def test_the_list_of_models_tells_what_it_can():
    rows = {
        "a": {"max_model_len": 4096, "created": 1},
        "b": {"architecture": {"input_modalities": ["text", "image"]}},
        "c": {"capabilities": {"vision": False}},
        "d": {"capabilities": ["completion", "multimodal"]},
    }
    with OpenAIServer(models=rows) as server:
        infos = {row: run(make_openai(server.base_url, served=row), lambda m: m.inspect()) for row in rows}
        finished = run(make_openai(server.base_url, vision=True), lambda m: m.inspect())
        server.models["a"]["created"] = 2
        later = run(make_openai(server.base_url), lambda m: m.inspect())
    assert infos["a"].context_length == 4096
    assert {row: ("vision" in info.capabilities, "vision" in info.undeclared) for row, info in infos.items()} == {
        "a": (False, True),
        "b": (True, False),
        "c": (False, False),
        "d": (True, False),
    }
    assert ("vision" in finished.capabilities, finished.undeclared) == (True, ())
    assert later.digest == infos["a"].digest != infos["b"].digest
    assert str(later.digest).startswith("listed-")


def test_servers_that_list_different_models_are_refused():
    with OpenAIServer(models={"a": {"root": "x"}}) as first, OpenAIServer(models={"a": {"root": "y"}}) as second:
        model = make_openai([first.base_url, second.base_url])
        with pytest.raises(InputError, match="differs between hosts"):
            run(model, lambda m: m.inspect())


def test_a_model_that_is_not_listed_is_refused_with_the_closest_one():
    with OpenAIServer() as server:
        asked = make_openai(server.base_url, served="meta-llama/Llama-3.1-8")
        with pytest.raises(InputError, match="Did you mean 'meta-llama/Llama-3.1-8B'") as caught:
            run(asked, lambda m: m.inspect())
    assert "lists_models=false" in str(caught.value)


def test_a_server_without_a_list_is_not_asked_for_one():
    with OpenAIServer(lists=False) as server:
        with pytest.raises(InputError, match="404"):
            run(make_openai(server.base_url), lambda m: m.inspect())
        unlisted = {"server": {"lists_models": False}}
        info = run(make_openai(server.base_url, **unlisted), lambda m: m.inspect())
        other = run(make_openai("elsewhere:1/v1", **unlisted), lambda m: m.inspect())
    assert info.undeclared == ("vision",)
    assert info.digest != other.digest


def test_a_revision_or_another_option_is_another_answer():
    changes = [{}, {"revision": "2"}, {"options": {"temperature": 0.3}}, {"extra": {"top_k": 1}}, {"format": "schema"}]
    request = make_request()
    models = [make_openai("x/v1", **change) for change in changes]
    keys = {RequestKeys(model, None).key(request.messages, 7) for model in models}
    assert len(keys) == len(changes)
    assert "revision" not in json.dumps(models[0].parameters())


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"served": " "}, "model=openai/<name"),
        ({"format": "json"}, "model.format 'json' not found"),
        ({"format": "schema", "schemas": None}, "needs a JSON Schema"),
        ({"image_detail": "huge"}, "model.image_detail 'huge' not found"),
        ({"options": {"top_k": 1}}, r"\+model.extra.top_k"),
        ({"options": {"max_token": 1}}, "Did you mean 'max_tokens'"),
        ({"extra": {"seed": 1}}, "model.extra.seed is refused, because foundry sets this field itself"),
        ({"extra": {"temperature": 1}}, "model.extra.temperature is refused, because foundry sets this field itself"),
        ({"server": {"base_url": " , "}}, "base_url is empty"),
        ({"server": {"base_url": "ftp://x"}}, "model.server.base_url 'ftp://x' cannot be read"),
        ({"server": {"longest_pause_s": 0}}, "model.server: Expected"),
    ],
)
def test_bad_settings_are_refused_in_one_line(changes, says):
    base_url = changes.get("server", {}).get("base_url", "x/v1")
    with pytest.raises(InputError, match=says):
        make_openai(base_url, **changes)
