from __future__ import annotations

import asyncio
import heapq
import itertools

import pytest

from foundry.errors import TransientError
from foundry.models.base import Model, Reply
from foundry.models.wrappers.limited import LimitedModel
from foundry.records import Attempt
from ollama_server import OllamaServer

BUSY = TransientError("full", busy=True)


class Simulated(Model):
    """A server with `slots` places where a call takes one unit of a time that only its events move on."""

    def __init__(self, slots: int, *, reports_queue: bool = True) -> None:
        self.name = "simulated"
        self.slots = slots
        self.reports_queue = reports_queue
        self.now = 0.0
        self.free_at = [0.0] * slots
        self.events: list[tuple[float, int, asyncio.Future[None]]] = []
        self.numbers = itertools.count()

    def parameters(self):
        return {}

    async def ask(self, request):
        arrived = self.now
        started = max(arrived, heapq.heappop(self.free_at))
        heapq.heappush(self.free_at, started + 1)
        ended = asyncio.get_running_loop().create_future()
        heapq.heappush(self.events, (started + 1, next(self.numbers), ended))
        await ended
        timings = {"latency": self.now - arrived}
        return Reply(text="", timings=timings | ({"queue": started - arrived} if self.reports_queue else {}))

    async def run_out(self) -> None:
        """Let all calls end, in the order of their time."""
        await settle()
        while self.events:
            self.now, _, ended = heapq.heappop(self.events)
            ended.set_result(None)
            await settle()


async def settle() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


def play(model, request, *, callers, calls):
    """Ask `calls` times in all from `callers` at once and return the limit after every call."""
    limits = []

    async def caller(numbers):
        for _ in numbers:
            await model.ask(request)
            limits.append(model.limit)

    async def whole():
        numbers = iter(range(calls))
        tasks = [asyncio.create_task(caller(numbers)) for _ in range(callers)]
        await model.inner.run_out()
        await asyncio.gather(*tasks)

    asyncio.run(whole())
    return limits


def test_the_limit_doubles_up_to_its_bound_while_no_queue_forms(make_request):
    model = LimitedModel(Simulated(1000), min=1, max=64, initial=1)
    limits = play(model, make_request(), callers=200, calls=1000)
    assert list(dict.fromkeys(limits)) == [2, 4, 8, 16, 32, 64]


@pytest.mark.parametrize("reports_queue", [True, False])
@pytest.mark.parametrize("slots", [1, 4, 16])
def test_the_limit_settles_where_a_few_calls_wait(make_request, slots, reports_queue):
    model = LimitedModel(Simulated(slots, reports_queue=reports_queue), min=1, max=256, initial=2)
    limits = play(model, make_request(), callers=300, calls=3000)
    assert all(slots <= limit <= slots + 4 for limit in limits[-500:])


def test_a_limit_far_too_high_comes_down(make_request):
    model = LimitedModel(Simulated(2), min=1, max=64, initial=20)
    assert play(model, make_request(), callers=100, calls=1500)[-1] <= 6


def test_the_limit_stays_while_too_few_calls_are_there_to_reach_it(make_request):
    idle = LimitedModel(Simulated(100), min=1, max=64, initial=8)
    queueing = LimitedModel(Simulated(1), min=1, max=64, initial=8)
    assert set(play(idle, make_request(), callers=7, calls=200)) == {8}
    assert set(play(queueing, make_request(), callers=7, calls=200)) == {8}


@pytest.mark.parametrize("outcome", [BUSY, Reply(text="", attempts=(Attempt(error="", elapsed_s=0, busy=True),))])
def test_calls_refused_together_halve_the_limit_once(scripted, make_request, outcome):
    async def refuse():
        await settle()
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome

    async def refuse_all():
        await asyncio.gather(*(model.ask(make_request()) for _ in range(model.limit)), return_exceptions=True)
        return model.limit

    model = LimitedModel(scripted(refuse), min=1, max=64, initial=16)
    assert [asyncio.run(refuse_all()) for _ in range(3)] == [8, 4, 2]


def test_other_failures_leave_the_limit(scripted, make_request):
    model = LimitedModel(scripted(TransientError("down")), min=1, max=64, initial=16)
    with pytest.raises(TransientError):
        asyncio.run(model.ask(make_request()))
    assert (model.limit, model.in_flight) == (16, 0)


def test_the_limit_never_falls_below_its_least(scripted, make_request):
    model = LimitedModel(scripted(BUSY), min=3, max=64, initial=4)
    for _ in range(5):
        with pytest.raises(TransientError):
            asyncio.run(model.ask(make_request()))
    assert model.limit == 3


class Gate(Model):
    """Answers when it is told to, and notes who came in which order."""

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


def test_callers_are_served_in_the_order_they_came(make_request):
    async def whole():
        model = LimitedModel(Gate(), min=2, max=2, initial=2)
        tasks = [asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(6)]
        await settle()
        assert (model.inner.came, model.in_flight, model.waiting) == ([0, 1], 2, 4)
        for seed in (1, 0, 2, 3, 4, 5):
            model.inner.gates[seed].set_result(None)
            await settle()
        await asyncio.gather(*tasks)
        return model.inner.came, model.in_flight, model.waiting

    assert asyncio.run(whole()) == ([0, 1, 2, 3, 4, 5], 0, 0)


def test_a_cancelled_waiter_leaks_no_slot(make_request):
    async def whole():
        model = LimitedModel(Gate(), min=1, max=1, initial=1)
        first, second, third = (asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(3))
        await settle()
        second.cancel()
        model.inner.gates[0].set_result(None)
        await settle()
        assert (second.cancelled(), model.inner.came, model.in_flight) == (True, [0, 2], 1)
        model.inner.gates[2].set_result(None)
        await asyncio.gather(first, third)
        return model.in_flight, model.waiting

    assert asyncio.run(whole()) == (0, 0)


def test_a_waiter_cancelled_just_after_it_got_its_slot_hands_it_on(make_request):
    async def whole():
        model = LimitedModel(Gate(), min=1, max=1, initial=1)
        first, second, third = (asyncio.create_task(model.ask(make_request(seed=seed))) for seed in range(3))
        await settle()
        model.inner.gates[0].set_result(None)
        asyncio.get_running_loop().call_soon(second.cancel)
        await settle()
        assert (first.done(), second.cancelled()) == (True, True)
        model.inner.gates[2].set_result(None)
        await third
        return model.inner.came, model.in_flight, model.waiting

    assert asyncio.run(whole()) == ([0, 2], 0, 0)


def test_a_cancelled_call_gives_its_slot_back(make_request):
    async def whole():
        model = LimitedModel(Gate(), min=1, max=1, initial=1)
        task = asyncio.create_task(model.ask(make_request()))
        await settle()
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        return model.in_flight

    assert asyncio.run(whole()) == 0


def test_a_real_server_with_four_slots_gets_a_few_calls_more_than_that(make_model, make_request, run):
    with OllamaServer(latency_s=0.01, slots=4) as server:
        model = LimitedModel(make_model(server.url), min=1, max=64, initial=2)
        run(model, lambda m: m.ask_all([make_request(seed=seed) for seed in range(400)]))
        assert 3 <= model.limit <= 10
        assert server.counts.most_in_flight <= 16
