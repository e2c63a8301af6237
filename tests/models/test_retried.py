import asyncio

import pytest

import ollama_cases as cases
from foundry.errors import RequestError, ServerError, TransientError
from foundry.models.base import Reply, UnusableReply
from foundry.models.http.pausing import Pause, parse_reset, requested_wait
from foundry.models.http.transport import Origin
from foundry.models.serving import InFlight, Retry
from foundry.models.wrappers.limited import Limit, LimitedModel
from foundry.models.wrappers.retried import RetriedModel
from models.asking import Scripted, make_model, make_openai, make_request, run
from ollama_server import OllamaServer
from openai_server import ChatCase, OpenAIServer, limited

DOWN = TransientError("down")


class Naps(list[float]):
    async def __call__(self, seconds: float) -> None:
        self.append(seconds)


def retried(inner, naps, **changes):
    settings = {"attempts": 4, "unusable_attempts": 2, "wait_initial_s": 1.0, "wait_max_s": 3.0, **changes}
    return RetriedModel(inner, Retry(**settings), sleep=naps)


def test_failed_tries_are_noted_in_the_reply_and_a_good_one_costs_no_wait():
    naps = Naps()
    reply = asyncio.run(retried(Scripted(Reply(text="hi")), naps).ask(make_request()))
    assert (reply.text, reply.attempts, naps) == ("hi", (), [])
    inner = Scripted(DOWN, TransientError("full", busy=True), Reply(text="hi"))
    reply = asyncio.run(retried(inner, Naps()).ask(make_request()))
    assert [(attempt.error, attempt.busy) for attempt in reply.attempts] == [("down", False), ("full", True)]
    assert all(attempt.elapsed_s >= 0 for attempt in reply.attempts)


def test_waits_double_up_to_the_longest_one_with_jitter():
    naps = Naps()
    with pytest.raises(TransientError):
        asyncio.run(retried(Scripted(DOWN), naps, attempts=5).ask(make_request()))
    assert len(naps) == 4
    for nap, longest in zip(naps, [1, 2, 3, 3], strict=True):
        assert longest / 2 <= nap <= longest


def test_callers_that_failed_together_do_not_come_back_together():
    naps = Naps()
    model = retried(Scripted(*[DOWN, Reply(text="hi")] * 20), naps)
    asyncio.run(model.ask_all([make_request()] * 20))
    assert len(set(naps)) == 20


def test_a_server_is_not_asked_before_the_time_it_named_and_a_short_one_shortens_no_wait():
    naps = Naps()
    inner = Scripted(TransientError("full", busy=True, retry_after_s=17.0), Reply(text="hi"))
    asyncio.run(retried(inner, naps).ask(make_request()))
    assert naps == [17.0]
    inner = Scripted(TransientError("full", retry_after_s=0.0), Reply(text="hi"))
    asyncio.run(retried(inner, naps).ask(make_request()))
    assert len(naps) == 2 and naps[1] >= 0.5


def test_a_wait_of_a_day_is_granted_and_a_longer_one_ends_the_sweep():
    naps = Naps()
    day = TransientError("full", busy=True, retry_after_s=86_400.0)
    asyncio.run(retried(Scripted(day, Reply(text="hi")), naps).ask(make_request()))
    assert naps == [86_400.0]
    years = TransientError("full.", busy=True, retry_after_s=1e9)
    with pytest.raises(ServerError, match=r"^full\. The server asks for a wait of 1000000000 s\. .*foundry resume$"):
        asyncio.run(retried(Scripted(years, Reply(text="hi")), naps).ask(make_request()))
    with pytest.raises(TransientError, match=r"^full\.$"):
        asyncio.run(retried(Scripted(years), naps, attempts=1).ask(make_request()))
    assert naps == [86_400.0]


def test_the_last_failure_is_raised_and_says_how_often_it_was_tried():
    inner = Scripted(TransientError("full.", busy=True, retry_after_s=1))
    with pytest.raises(TransientError, match=r"^full\. Given up after 4 tries\.$") as caught:
        asyncio.run(retried(inner, Naps()).ask(make_request()))
    assert (caught.value.busy, len(inner.asked)) == (True, 4)


@pytest.mark.parametrize("error", [RequestError("bad"), ServerError("gone"), ValueError("bug")])
def test_other_failures_are_never_tried_again(error):
    inner, naps = Scripted(error), Naps()
    with pytest.raises(type(error), match=str(error)):
        asyncio.run(retried(inner, naps).ask(make_request()))
    assert (len(inner.asked), naps) == (1, [])


@pytest.mark.parametrize("ending", ["stop", "aborted"])
def test_an_unusable_reply_stands_once_its_few_tries_are_used_up(ending):
    inner = Scripted(UnusableReply("nothing to read", Reply(text="", ending=ending)))
    reply = asyncio.run(retried(inner, Naps()).ask(make_request()))
    assert (reply.text, reply.ending, len(reply.attempts), len(inner.asked)) == ("", ending, 2, 2)


def test_other_failures_do_not_use_up_the_tries_of_an_unusable_reply():
    inner = Scripted(DOWN, UnusableReply("empty", Reply(text="")), Reply(text="hi"))
    reply = asyncio.run(retried(inner, Naps()).ask(make_request()))
    assert (reply.text, len(reply.attempts)) == ("hi", 2)


def test_a_cancelled_call_is_not_tried_again():
    async def cancel_it():
        started = asyncio.Event()

        async def hang():
            started.set()
            return await asyncio.get_running_loop().create_future()

        inner = Scripted(hang)
        task = asyncio.create_task(retried(inner, Naps()).ask(make_request()))
        await started.wait()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return len(inner.asked)

    assert asyncio.run(cancel_it()) == 1


def test_everything_else_is_the_wrapped_models():
    model = retried(make_model("gpu1", format="schema"), Naps())
    assert (model.name, model.costs) == (model.inner.name, True)
    assert (model.parameters(), model.kinds) == (model.inner.parameters(), model.inner.kinds)
    assert retried(Scripted(DOWN), Naps()).costs is False


@pytest.mark.parametrize(
    ("answers", "tries", "ending"),
    [
        ([cases.busy("0.003"), cases.RUNNER_DIED, cases.DROPPED, "hi"], 4, "stop"),
        ([cases.CUT, cases.ERROR_WITH_200, "hi"], 3, "stop"),
        ([cases.EMPTY, "hi"], 2, "stop"),
        ([cases.EMPTY], 2, "stop"),
        ([cases.ABORTED], 2, "aborted"),
        ([cases.ABORTED_500], 2, "aborted"),
    ],
)
def test_a_real_server_that_fails_is_asked_again(answers, tries, ending):
    naps = Naps()
    with OllamaServer(cases.in_turn(*answers)) as server:
        reply = run(retried(make_model(server.url), naps), lambda model: model.ask(make_request()))
        assert (server.counts.chats, reply.ending, len(naps)) == (tries, ending, tries - 1)
        assert reply.text == ("hi" if "hi" in answers else "") and len({str(body) for body in server.bodies}) == 1


HERE = Origin(host="http://h/v1", model="a", server="The server")


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        *[("20ms", 0.02), ("1s", 1.0), ("6m0s", 360.0), ("1h2m3.5s", 3723.5), ("12.5", 12.5), ("0", 0.0), (" 7 ", 7.0)],
        *((text, None) for text in ("", "soon", "-1", "nan", "1790000000", "2026-11-21T06:00:00Z", "5 parsecs")),
    ],
)
def test_the_time_of_a_reset_is_read_in_every_form_and_no_other(text, seconds):
    assert parse_reset(text) == pytest.approx(seconds)


@pytest.mark.parametrize(
    ("headers", "wait_s"),
    [
        ({}, None),
        ({"retry-after": "3"}, 3.0),
        ({"retry-after-ms": "1500", "retry-after": "2"}, 1.5),
        ({"x-ratelimit-remaining-requests": "1", "x-ratelimit-reset-requests": "6m0s"}, None),
        ({"x-ratelimit-remaining-requests": "0", "x-ratelimit-reset-requests": "6m0s"}, 360.0),
        ({"x-ratelimit-remaining-tokens": "0", "x-ratelimit-reset-tokens": "2s"}, 2.0),
        ({"x-ratelimit-remaining-tokens": "0", "x-ratelimit-reset-tokens": "never"}, None),
        ({"x-ratelimit-remaining-tokens": "some"}, None),
        (
            {
                "x-ratelimit-remaining-tokens": "0",
                "x-ratelimit-reset-tokens": "2s",
                "x-ratelimit-remaining-requests": "0",
                "x-ratelimit-reset-requests": "1s",
            },
            2.0,
        ),
    ],
)
def test_a_limit_that_is_used_up_asks_to_wait_for_its_reset(headers, wait_s):
    assert requested_wait(headers) == wait_s


def test_calls_wait_until_the_longest_pause_is_over():
    naps = Naps()
    pause = Pause(60.0, sleep=naps, clock=lambda: 100.0 + sum(naps))
    for wait_s in (None, 2.0, 0.5):
        pause.note(wait_s, HERE)
    asyncio.run(pause.over(HERE))
    asyncio.run(pause.over(HERE))
    assert naps == [2.0]


def test_a_pause_that_is_too_long_ends_the_sweep():
    pause = Pause(60.0)
    pause.note(3600.0, HERE)
    with pytest.raises(ServerError, match="a pause of 3600 s.*foundry resume"):
        asyncio.run(pause.over(HERE))
    assert isinstance(pause.judged(TransientError("429", busy=True, retry_after_s=61.0), HERE), ServerError)
    transient_error = TransientError("429", busy=True, retry_after_s=59.0)
    assert pause.judged(transient_error, HERE) is transient_error


def test_a_429_is_tried_again_after_the_time_that_it_names_and_told_to_the_limit():
    naps = Naps()
    with OpenAIServer(cases.in_turn(limited(retry_after_ms="30"), "Left.")) as server:
        limit = Limit(InFlight(min=1, max=8, initial=4))
        retry = Retry(attempts=3, unusable_attempts=2, wait_initial_s=0.001, wait_max_s=0.001)
        model = RetriedModel(make_openai(server.base_url), retry, sleep=naps, noted=limit.note_failure)
        reply = run(LimitedModel(model, limit), lambda m: m.ask(make_request()))
    assert (reply.text, [attempt.busy for attempt in reply.attempts]) == ("Left.", [True])
    assert naps == [pytest.approx(0.03)]
    assert limit.sums.refused == 1


def test_the_last_call_of_a_limit_holds_the_next_ones_back():
    used_up = {"x-ratelimit-remaining-requests": "0", "x-ratelimit-reset-requests": "1h"}
    with OpenAIServer(lambda body: ChatCase("Left.", headers=used_up)) as server:
        model = make_openai(server.base_url)
        assert run(model, lambda m: m.ask(make_request())).text == "Left."
        with pytest.raises(ServerError, match=r"longest_pause_s \(900\)"):
            run(model, lambda m: m.ask(make_request()))
        assert len(server.bodies) == 1
