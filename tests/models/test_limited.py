import asyncio
import time

import pytest

from foundry.errors import TransientError
from foundry.models.base import Model, Reply
from foundry.models.serving import InFlight, Retry
from foundry.models.wrappers.limited import Limit, LimitedModel
from foundry.models.wrappers.retried import RetriedModel
from models.asking import Scripted, make_request

BUSY = TransientError("full", busy=True)
LATE = TransientError("no reply", late=True)


def limit(least: int, most: int, initial: int, **settings) -> Limit:
    return Limit(InFlight(min=least, max=most, initial=initial), **settings)


async def settle() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


def retried(inner: Model, limit: Limit) -> Model:
    async def nap(seconds: float) -> None:
        await asyncio.sleep(0)

    retry = Retry(attempts=2, unusable_attempts=2, wait_initial_s=1.0, wait_max_s=1.0)
    return LimitedModel(RetriedModel(inner, retry, sleep=nap, noted=limit.note_failure), limit)


@pytest.mark.parametrize("failure", [BUSY, LATE])
def test_tries_that_are_refused_or_time_out_together_halve_the_limit_before_any_of_them_gives_up(failure):
    limits = []

    async def refuse():
        await settle()
        limits.append(found.allowed)
        raise failure

    async def refuse_all():
        await asyncio.gather(*(model.ask(make_request()) for _ in range(16)), return_exceptions=True)

    found = limit(1, 64, 16)
    model = retried(Scripted(refuse), found)
    asyncio.run(refuse_all())
    assert limits[0] == 16 and limits[-1] <= 8


def test_other_failures_leave_the_limit():
    found = limit(1, 64, 4)
    model = retried(Scripted(TransientError("down")), found)
    for _ in range(10):
        with pytest.raises(TransientError):
            asyncio.run(model.ask(make_request()))
    assert (found.allowed, found.in_flight) == (4, 0)


def test_a_try_that_began_under_an_earlier_limit_says_nothing_of_this_one():
    found = limit(1, 64, 16)
    before = time.perf_counter()
    found.allow(8)
    for _ in range(100):
        found.note_failure(BUSY, before)
    assert found.allowed == 8


def test_time_and_calls_are_summed_up_for_the_climb():
    clock = [10.0]

    async def answer():
        await settle()
        clock[0] += 2.0
        return Reply(text="", output_tokens=50, timings={"queue": 0.5})

    found = limit(1, 1, 1, clock=lambda: clock[0])
    model = LimitedModel(Scripted(answer), found)

    async def whole():
        await asyncio.gather(*(model.ask(make_request()) for _ in range(3)))
        clock[0] += 4.0

    asyncio.run(whole())
    sums = found.sums
    assert (sums.calls, sums.work, sums.seconds, sums.queue_s, sums.told_s) == (3, 150, 6, 1.5, 6)
    assert (sums.clock_s, sums.in_flight_s, sums.waiting_s) == (10, 6, 4)


class Gate(Model):
    def __init__(self) -> None:
        self.name = "gate"
        self.came: list[int] = []
        self.gates: dict[int, asyncio.Future[None]] = {}

    def parameters(self):
        return {}

    async def ask(self, request):
        self.came.append(request.seed)
        self.gates[request.seed] = asyncio.get_running_loop().create_future()
        await self.gates[request.seed]
        return Reply(text="", timings={"latency": 1.0, "queue": 2.0})


def test_callers_are_served_in_the_order_they_came():
    async def whole():
        model = LimitedModel(Gate(), limit(2, 2, 2))
        tasks = [asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(6)]
        await settle()
        assert (model.inner.came, model.limit.in_flight, model.limit.waiting) == ([0, 1], 2, 4)
        for seed in (1, 0, 2, 3, 4, 5):
            model.inner.gates[seed].set_result(None)
            await settle()
        await asyncio.gather(*tasks)
        return model.inner.came, model.limit.in_flight, model.limit.waiting

    assert asyncio.run(whole()) == ([0, 1, 2, 3, 4, 5], 0, 0)


def test_neither_a_cancelled_waiter_nor_a_cancelled_call_leaks_a_slot():
    async def whole():
        model = LimitedModel(Gate(), limit(1, 1, 1))
        first, second, third = (asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(3))
        await settle()
        second.cancel()
        model.inner.gates[0].set_result(None)
        await settle()
        assert (second.cancelled(), model.inner.came, model.limit.in_flight) == (True, [0, 2], 1)
        third.cancel()
        await asyncio.gather(first, third, return_exceptions=True)
        return model.limit.in_flight, model.limit.waiting

    assert asyncio.run(whole()) == (0, 0)


def test_a_waiter_cancelled_just_after_it_got_its_slot_hands_it_on():
    async def whole():
        model = LimitedModel(Gate(), limit(1, 1, 1))
        first, second, third = (asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(3))
        await settle()
        model.inner.gates[0].set_result(None)
        asyncio.get_running_loop().call_soon(second.cancel)
        await settle()
        assert (first.done(), second.cancelled()) == (True, True)
        model.inner.gates[2].set_result(None)
        await third
        return model.inner.came, model.limit.in_flight, model.limit.waiting

    assert asyncio.run(whole()) == ([0, 2], 0, 0)


def test_where_the_limit_rises_calls_come_two_by_two_and_not_in_a_burst():
    async def whole():
        model = LimitedModel(Gate(), limit(1, 64, 2))
        model.limit.share()
        tasks = [asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(10)]
        await settle()
        model.limit.allow(10)
        tasks.append(asyncio.create_task(model.ask(make_request(seed=10))))  # comes last, though there is room
        came = []
        for seed in range(11):
            await settle()
            came.append(len(model.inner.came))
            model.inner.gates[seed].set_result(None)
        await asyncio.gather(*tasks)
        return came, model.inner.came

    assert asyncio.run(whole()) == ([2, 4, 6, 8, 10, 11, 11, 11, 11, 11, 11], list(range(11)))
