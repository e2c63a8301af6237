"""Models of the `transformers` library in this process; they answer the calls that wait in batches."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from foundry.errors import InputError, not_found
from foundry.models.base import ModelInfo, Reply, Request
from foundry.models.local.settings import LocalServing, Sampling
from foundry.models.serving import ServedModel, read_settings

if TYPE_CHECKING:
    from types import ModuleType

    from foundry.models.local.engine import Engine


DTYPES = ("auto", "float32", "bfloat16", "float16", "float64")


@dataclass
class _Waiting:
    request: Request
    images: int
    answer: asyncio.Future[Reply]


class Batches:
    """Collects requests in batches; only requests with the same number of images share a batch.

    While the model answers one batch, the next batch is collected.

    `work` gets the requests of a batch and returns a reply or an exception for each. The function `work` always runs in
    the same thread.
    """

    def __init__(self, work: Callable[[Sequence[Request]], Sequence[Reply | Exception]], size: int) -> None:
        self._work = work
        self._size = size
        self._queue: deque[_Waiting] = deque()
        self._task: asyncio.Task[None] | None = None
        self._thread: ThreadPoolExecutor | None = None

    async def ask(self, request: Request) -> Reply:
        """Put a request into a batch, and return its reply."""
        images = sum(len(message.images) for message in request.messages)
        waiting = _Waiting(request, images, asyncio.get_running_loop().create_future())
        self._queue.append(waiting)
        if self._task is None:
            self._task = asyncio.create_task(self._work_off())
        try:
            return await waiting.answer
        finally:
            if waiting in self._queue:  # its caller has given up
                self._queue.remove(waiting)

    async def run(self, work: Callable[[], object]) -> None:
        """Run a function in the thread in which the model answers its batches."""
        await asyncio.get_running_loop().run_in_executor(self._executor(), work)

    def close(self) -> None:
        """End the model's thread; a later call of the model starts a new thread."""
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.shutdown(wait=True)

    async def _work_off(self) -> None:
        try:
            while self._queue:
                batch = self._next()
                self._hand_out(batch, await self._results([waiting.request for waiting in batch]))
        finally:
            self._task = None

    async def _results(self, requests: Sequence[Request]) -> Sequence[Reply | Exception]:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._executor(), self._work, requests)
        except Exception as error:  # noqa: BLE001 - everyone who waits for the batch gets it
            return [error] * len(requests)

    def _next(self) -> list[_Waiting]:
        images = self._queue[0].images
        batch = [waiting for waiting in self._queue if waiting.images == images][: self._size]
        taken = set(map(id, batch))
        self._queue = deque(waiting for waiting in self._queue if id(waiting) not in taken)
        return batch

    def _hand_out(self, batch: Sequence[_Waiting], results: Sequence[Reply | Exception]) -> None:
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


class TransformersModel(ServedModel):
    """Answers calls of several agents and runs in one batch. A reply depends on its prompt and seed, not on its batch.

    The exception is rounding, which depends on the shape of a batch. In half precision the text of a reply may
    therefore depend on its batch, as on any server with parallel calls.
    """

    in_process = True
    replaceable = False

    def __init__(
        self,
        *,
        weights: str,
        name: str,
        dtype: str,
        options: Mapping[str, Any],
        server: Mapping[str, Any],
        template: Mapping[str, Any] | None = None,
        revision: str | None = None,
    ) -> None:
        """Take the settings, described in `conf/model/hf.yaml`; the weights are loaded later."""
        if not weights.strip():
            raise InputError("model.weights is empty: write model=hf/<folder or id>.")
        if dtype not in DTYPES:
            raise not_found("model.dtype", dtype, DTYPES)
        self.name = name
        self.server: LocalServing = read_settings(server, LocalServing)
        self._weights, self._revision = weights, revision
        self._dtype = dtype
        self._sampling = _sampling(options)
        self._template = dict(template or {})
        self._engine: Engine | None = None
        self._batches = Batches(lambda requests: self._load().answer(requests), self.server.batch_size)

    @property
    def longest_reply(self) -> int | None:
        """The option `max_new_tokens`."""
        return self._sampling.max_new_tokens

    def parameters(self) -> dict[str, Any]:
        """Return the settings that affect an answer; weights, messages and seed are not among them."""
        return {"dtype": self._dtype, "options": msgspec.to_builtins(self._sampling), "template": self._template}

    async def ask(self, request: Request) -> Reply:
        """Answer a request in a batch with other requests that have the same number of images."""
        started = time.perf_counter()
        reply = await self._batches.ask(request)
        total = time.perf_counter() - started
        queued = max(0.0, total - reply.timings["output"])
        timings = {**reply.timings, "total": total, "latency": total, "queue": queued}
        return msgspec.structs.replace(reply, timings=timings)

    async def inspect(self) -> ModelInfo:
        """Read and hash the model's files."""
        return await asyncio.to_thread(self._inspect)

    async def warm_up(self) -> None:
        """Load the weights."""
        await self._batches.run(self._load)

    async def unload(self) -> None:
        """Free the memory of the model."""
        await self.close()

    async def close(self) -> None:
        """Free the memory of the model and end the thread; a later call loads the weights again."""
        self._batches.close()
        engine, self._engine = self._engine, None
        if engine is not None:
            engine.close()

    def _inspect(self) -> ModelInfo:
        module = _engine_module()
        folder = self._folder()
        from foundry.models.local import weights as transformers_weights

        described = module.Description.read(folder)
        module.device_of(self.server.device)
        return ModelInfo(
            name=self.name,
            digest=transformers_weights.digest(folder),
            server_version=module.VERSIONS,
            capabilities=("completion", *(("vision",) if described.sees else ())),
            context_length=described.context_length,
        )

    def _load(self) -> Engine:
        if self._engine is None:
            self._engine = _engine_module().Engine(
                self._folder(),
                dtype=self._dtype,
                device=self.server.device,
                sampling=self._sampling,
                template=self._template,
            )
        assert self._engine is not None
        return self._engine

    def _folder(self) -> Path:
        from foundry.models.local import weights as transformers_weights

        return transformers_weights.find_folder(self._weights, self._revision)


def _engine_module() -> ModuleType:
    try:
        from foundry.models.local import engine as transformers_engine
    except ImportError as error:
        raise InputError(
            f"model=hf/... needs the library {error.name}, which is not installed: pip install 'foundry-worlds[hf]'"
        ) from error
    return transformers_engine


def _sampling(options: Mapping[str, Any]) -> Sampling:
    try:
        return msgspec.convert(dict(options), Sampling)
    except msgspec.ValidationError as error:
        raise InputError(f"model.options: {error}. Options are: {', '.join(Sampling.__struct_fields__)}.") from None
