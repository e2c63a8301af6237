from __future__ import annotations

import asyncio

import pytest

from foundry.errors import ServerError, TransientError
from foundry.models.http.pausing import Pause, parse_reset, wait_asked
from foundry.models.http.transport import Origin
from foundry.models.serving import InFlight, Retry
from foundry.models.wrappers.limited import Limit, LimitedModel
from foundry.models.wrappers.retried import RetriedModel
from openai_server import ChatCase, OpenAIServer, in_turn, limited

HERE = Origin(host="http://h/v1", model="a", server="The server")


class Clock:
    """A time that passes by waiting alone."""

    def __init__(self) -> None:
        self.now = 100.0
        self.waits: list[float] = []

    def __call__(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        self.waits.append(seconds)
        self.now += seconds


def make_pause(longest_s: float = 60.0) -> tuple[Pause, Clock]:
    clock = Clock()
    return Pause(longest_s, sleep=clock.sleep, clock=clock), clock


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
    assert wait_asked(headers) == wait_s


def test_calls_wait_until_the_longest_pause_is_over():
    pause, clock = make_pause()
    for wait_s in (None, 2.0, 0.5):
        pause.note(wait_s, HERE)
    asyncio.run(pause.over(HERE))
    asyncio.run(pause.over(HERE))
    assert clock.waits == [2.0]


def test_a_pause_that_is_too_long_ends_the_sweep():
    pause, clock = make_pause(longest_s=60.0)
    pause.note(3600.0, HERE)
    with pytest.raises(ServerError, match="a pause of 3600 s.*foundry resume"):
        asyncio.run(pause.over(HERE))
    assert clock.waits == []
    assert isinstance(pause.judged(TransientError("429", busy=True, retry_after_s=61.0), HERE), ServerError)
    kept = TransientError("429", busy=True, retry_after_s=59.0)
    assert pause.judged(kept, HERE) is kept


def test_a_429_is_tried_again_after_the_time_that_it_names_and_told_to_the_limit(make_openai, make_request, run):
    waits: list[float] = []

    async def note(seconds: float) -> None:
        waits.append(seconds)

    with OpenAIServer(in_turn(limited(retry_after_ms="30"), "Left.")) as server:
        limit = Limit(InFlight(min=1, max=8, initial=4))
        retry = Retry(attempts=3, unusable_attempts=2, wait_initial_s=0.001, wait_max_s=0.001)
        retried = RetriedModel(make_openai(server.base_url), retry, sleep=note, noted=limit.note_failure)
        reply = run(LimitedModel(retried, limit), lambda m: m.ask(make_request()))
    assert (reply.text, [attempt.busy for attempt in reply.attempts]) == ("Left.", [True])
    assert waits == [pytest.approx(0.03)]
    assert limit.sums.refused == 1


def test_the_last_call_of_a_limit_holds_the_next_ones_back(make_openai, make_request, run):
    used_up = {"x-ratelimit-remaining-requests": "0", "x-ratelimit-reset-requests": "1h"}
    with OpenAIServer(lambda body: ChatCase("Left.", headers=used_up)) as server:
        model = make_openai(server.base_url)
        assert run(model, lambda m: m.ask(make_request())).text == "Left."
        with pytest.raises(ServerError, match=r"longest_pause_s \(900\)"):
            run(model, lambda m: m.ask(make_request()))
        assert len(server.bodies) == 1
