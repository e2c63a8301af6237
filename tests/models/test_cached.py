"""A model whose answers are kept, over both kinds of cache."""

import asyncio
import contextlib
import itertools
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from databases import SqliteStore, Store
from foundry.errors import StorageError, TransientError
from foundry.models.answers.answers import Answers
from foundry.models.answers.unconfirmed import Unconfirmed
from foundry.models.base import ChatMessage, Model, Reply, Request, RequestKeys, Source
from foundry.models.wrappers.cached import CachedModel


class Counting(Model):
    """Answers with the number of the call; holds every answer back until `gate` is open."""

    costs = True
    name = "counting"

    def __init__(self) -> None:
        self.asked: list[Request] = []
        self.gate = asyncio.Event()
        self.failing = False

    async def ask(self, request: Request) -> Reply:
        self.asked.append(request)
        await self.gate.wait()
        if self.failing:
            raise TransientError("no luck")
        return Reply(text=f"answer {len(self.asked)}", prompt_tokens=5, timings={"latency": 0.5})

    def parameters(self) -> dict[str, Any]:
        return {}


def request(seed: int = 1) -> Request:
    messages = (ChatMessage("user", "hello"),)
    key = RequestKeys(Counting(), "d").key(messages, seed)
    return Request(messages=messages, seed=seed, kind="action", observation={}, step=1, agent=0, key=key)


def opened(inner: Counting) -> Counting:
    inner.gate.set()
    return inner


async def ask(store: Store, inner: Counting, *requests: Request) -> list[Reply]:
    answers = store.open()
    try:
        return await CachedModel(inner, Unconfirmed(answers)).ask_all(requests)
    finally:
        answers.close()


def test_what_was_answered_once_is_never_asked_again(store: Store):
    first, second = opened(Counting()), opened(Counting())
    (paid,) = asyncio.run(ask(store, first, request()))
    (free,) = asyncio.run(ask(store, second, request()))
    assert second.asked == []
    assert (free.text, free.prompt_tokens, free.timings) == (paid.text, 5, {"latency": 0.5})
    assert (paid.cached, free.cached) == (False, True)


def test_all_that_decides_an_answer_makes_another_key_wherever_one_part_ends_and_the_next_begins():
    text, images = ("", "a", "aa", "b"), ((), (b"",), (b"a",), (b"a", b""), (b"", b"a"), (b"aa",))
    sources = itertools.product(text, text, ({}, {"a": 1}, {"a": 2}))
    keys = [RequestKeys.of(Source(model=m, digest=d, parameters=p, key="")) for m, d, p in sources]
    messages = [(ChatMessage(*parts),) for parts in itertools.product(text, text, images)]
    asked = [*messages, *((chat_message, ChatMessage("user", "")) for (chat_message,) in messages)]
    made = [of.key(chat_messages, seed) for of in keys for seed in (1, 2) for chat_messages in asked]
    assert len(set(made)) == len(made)


@pytest.mark.parametrize("failing", [False, True])
def test_equal_requests_in_flight_cost_one_call_and_share_its_answer_or_its_failure(store: Store, failing: bool):
    async def thrice(answers: Answers) -> tuple[Counting, list[Any]]:
        inner = Counting()
        inner.failing = failing
        model = CachedModel(inner, Unconfirmed(answers))
        tasks = [asyncio.create_task(model.ask(request())) for _ in range(3)]
        while not inner.asked:
            await asyncio.sleep(0)
        inner.gate.set()
        return inner, await asyncio.gather(*tasks, return_exceptions=True)

    answers = store.open()
    inner, replies = asyncio.run(thrice(answers))
    answers.close()
    assert len(inner.asked) == 1
    if failing:
        assert [type(reply) for reply in replies] == [TransientError] * 3
    else:
        assert {reply.text for reply in replies} == {"answer 1"}
        assert sorted(reply.cached for reply in replies) == [False, True, True]


def test_a_failed_call_is_not_kept_and_the_other_answers_of_its_batch_are(store: Store):
    class Picky(Counting):
        async def ask(self, request: Request) -> Reply:
            if request.seed == 2:
                raise TransientError("no luck")
            return await super().ask(request)

    with pytest.raises(TransientError, match="no luck"):
        asyncio.run(ask(store, opened(Picky()), request(seed=1), request(seed=2)))
    again = opened(Counting())
    asyncio.run(ask(store, again, request(seed=1), request(seed=2)))
    assert [asked.seed for asked in again.asked] == [2]


def test_who_gives_up_while_answers_are_committed_takes_none_from_the_others(store: Store):
    async def two(answers: Answers) -> list[Any]:
        model = CachedModel(opened(Counting()), Unconfirmed(answers))
        leaves, stays = (asyncio.create_task(model.ask(request(seed=seed))) for seed in (1, 2))
        while not model._unsaved:
            await asyncio.sleep(0)
        leaves.cancel()
        return await asyncio.gather(leaves, stays, return_exceptions=True)

    answers = store.open()
    assert [type(result) for result in asyncio.run(two(answers))] == [asyncio.CancelledError, Reply]
    assert len(answers.get([request(seed=seed).key for seed in (1, 2)])) == 2
    answers.close()


def test_an_answer_that_could_not_be_committed_is_seen_by_nobody(tmp_path: Path):
    """The table is taken away while the model answers, so that the commit fails."""
    store = SqliteStore(tmp_path)

    class Spoiling(Counting):
        async def ask(self, request: Request) -> Reply:
            with contextlib.closing(sqlite3.connect(store.where)) as database:
                database.execute("DROP TABLE answers")
            return await super().ask(request)

    async def both() -> list[Any]:
        answers = store.open()
        model = CachedModel(opened(Spoiling()), Unconfirmed(answers))
        leader, follower = asyncio.create_task(model.ask(request())), asyncio.create_task(model.ask(request()))
        results = await asyncio.gather(leader, follower, return_exceptions=True)
        answers.close()
        return results

    assert [type(result) for result in asyncio.run(both())] == [StorageError, StorageError]


def test_a_damaged_row_is_asked_again_and_replaced(store: Store):
    asyncio.run(ask(store, opened(Counting()), request()))
    store.damage()
    again, third = opened(Counting()), opened(Counting())
    asyncio.run(ask(store, again, request()))
    asyncio.run(ask(store, third, request()))
    assert (len(again.asked), len(third.asked)) == (1, 0)
