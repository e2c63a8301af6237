"""Calls that wait in one event loop, answered together in a thread so that the loop lives."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Generic, TypeVar

Asked = TypeVar("Asked")
Given = TypeVar("Given")


@dataclass
class _Waiting(Generic[Asked, Given]):
    asked: Asked
    kind: Hashable
    answer: asyncio.Future[Given]


class Batches(Generic[Asked, Given]):
    """Collects calls of one kind into batches; while one batch is worked on, the next one gathers.

    `work` gets the calls of a batch and returns a result or an exception for each; it runs in a thread that is
    always the same one.
    """

    def __init__(self, work: Callable[[Sequence[Asked]], Sequence[Given | Exception]], size: int) -> None:
        self._work = work
        self._size = size
        self._queue: deque[_Waiting[Asked, Given]] = deque()
        self._task: asyncio.Task[None] | None = None
        self._thread: ThreadPoolExecutor | None = None

    async def ask(self, asked: Asked, kind: Hashable) -> Given:
        """Answer one call in a batch with others of its kind."""
        waiting = _Waiting[Asked, Given](asked, kind, asyncio.get_running_loop().create_future())
        self._queue.append(waiting)
        if self._task is None:
            self._task = asyncio.create_task(self._work_off())
        try:
            return await waiting.answer
        finally:
            if waiting in self._queue:  # its caller has given up
                self._queue.remove(waiting)

    async def run(self, work: Callable[[], object]) -> None:
        """Do something else in the thread."""
        await asyncio.get_running_loop().run_in_executor(self._executor(), work)

    def close(self) -> None:
        """End the thread; a later call starts another one."""
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.shutdown(wait=True)

    async def _work_off(self) -> None:
        try:
            while self._queue:
                batch = self._next()
                self._hand_out(batch, await self._results([waiting.asked for waiting in batch]))
        finally:
            self._task = None

    async def _results(self, asked: Sequence[Asked]) -> Sequence[Given | Exception]:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._executor(), self._work, asked)
        except Exception as error:  # noqa: BLE001 - handed on to everyone who waits for the batch
            return [error] * len(asked)

    def _next(self) -> list[_Waiting[Asked, Given]]:
        """Take the first call of the queue and those of its kind, in their order."""
        kind = self._queue[0].kind
        batch = [waiting for waiting in self._queue if waiting.kind == kind][: self._size]
        taken = set(map(id, batch))
        self._queue = deque(waiting for waiting in self._queue if id(waiting) not in taken)
        return batch

    def _hand_out(self, batch: Sequence[_Waiting[Asked, Given]], results: Sequence[Given | Exception]) -> None:
        for waiting, result in zip(batch, results, strict=True):
            if waiting.answer.done():
                continue
            if isinstance(result, Exception):
                waiting.answer.set_exception(result)
            else:
                waiting.answer.set_result(result)

    def _executor(self) -> ThreadPoolExecutor:
        if self._thread is None:
            self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="foundry-hf")
        return self._thread
